"""Write the conformance vectors anew: ``python -m tests.conformance.make [FOLDER]``; the same bytes each time."""

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np

from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack
from tests.conformance.invalid import invalid
from tests.conformance.signing import manifest_of
from tests.conformance.valid import valid

VECTORS = Path(__file__).parent / "vectors"
PACK, EXPECTED = "vector.facezip", "expected.json"
BETAS = (0.75, -0.5, 1.25)


def make(folder: Path) -> None:
    """Every vector: a pack, and what a reader must say of it."""
    shutil.rmtree(folder, ignore_errors=True)
    for name, write in valid():
        write(_room(folder / name) / PACK)
        _write(folder / name, expected_of(folder / name / PACK))
    for name, code, write in invalid():
        write(_room(folder / name) / PACK)
        _write(folder / name, {"code": code})


def expected_of(pack: Path) -> dict[str, Any]:
    """What the library reads: names, some blends with their means and three texels each, and the meshes."""
    model, manifest = read_pack(pack), manifest_of(pack)
    blends = [
        _blend(model, dict(zip(names, betas, strict=False)), kind.name, tile)
        for kind in model.maps
        for tile in {model.tiles[0], model.tiles[-1]}
        for names, betas in ((model.expressions[-1:], (1.0,)), (model.expressions[:3], BETAS))
    ]
    return {
        "code": None,
        "format": manifest["format"],
        "name": manifest["name"] or pack.stem,
        "expressions": model.expressions,
        "maps": [kind.name for kind in model.maps],
        "tiles": model.tiles,
        "blends": blends,
        "meshes": None if model.meshes is None else _meshes(model),
    }


def _blend(model: CompressedTextures, betas: dict[str, float], kind: str, tile: int) -> dict[str, Any]:
    values = model.blend(betas, kind, tile)
    rows, columns, _ = values.shape
    places = [(0, 0), (rows // 2, columns // 3), (rows - 1, columns - 1)]
    return {
        "blend": betas,
        "map": kind,
        "tile": tile,
        "size": values.shape,
        "mean": _numbers(values.mean(axis=(0, 1), dtype=np.float64)),
        "texels": [{"row": row, "column": column, "values": _numbers(values[row, column])} for row, column in places],
    }


def _meshes(model: CompressedTextures) -> dict[str, Any]:
    meshes = model.meshes
    corners = meshes.topology.uv[meshes.topology.face_uv]
    return {
        "vertices": len(meshes.neutral),
        "triangles": meshes.topology.faces.tolist(),
        "uv_of_corners": [_numbers(corner) for corner in corners.reshape(-1, 2)],
        "neutral": [_numbers(vertex) for vertex in meshes.neutral],
        "last_expression": [_numbers(vertex) for vertex in meshes.vertices[-1]],
    }


def _numbers(values: np.ndarray) -> list[float]:
    """Nine digits, which hold a float32 exactly."""
    return [float(f"{value:.9g}") for value in values.tolist()]


def _room(folder: Path) -> Path:
    folder.mkdir(parents=True)
    return folder


def _write(folder: Path, expected: dict[str, Any]) -> None:
    (folder / EXPECTED).write_text(json.dumps(expected, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else VECTORS)

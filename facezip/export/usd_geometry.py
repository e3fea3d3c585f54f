"""The mesh of a head as text of USD: points, faces, UVs by tile, and every expression as a sparse blend shape."""

import json
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.gltf import SMALLEST_TURN, vertex_normals
from facezip.export.source import Source


def geometry_words(source: Source) -> dict[str, object]:
    """What the template of a head says of its mesh; raises as :attr:`facezip.export.source.Source.meshes`."""
    meshes, charts = source.meshes, source.charts
    faces = np.concatenate([chart.faces for chart in charts])
    starts = np.cumsum([0, *(len(chart.faces) for chart in charts)])
    corners = np.concatenate([chart.uv[chart.face_uv].reshape(-1, 2) for chart in charts])
    uv, at = np.unique(corners, axis=0, return_inverse=True)
    normals = vertex_normals(meshes.neutral, meshes.topology.faces)
    return {
        "points": vectors(meshes.neutral),
        "extent": vectors(np.stack([meshes.neutral.min(axis=0), meshes.neutral.max(axis=0)])),
        "counts": ", ".join(["3"] * len(faces)),
        "indices": integers(faces),
        "normals": vectors(normals, 6),
        "st": vectors(uv),
        "st_indices": integers(at),
        "subsets": [
            (tile.layout.number, integers(np.arange(start, end)))
            for tile, start, end in zip(source.tiles, starts, starts[1:], strict=False)
            if start < end
        ],
        "shapes": [
            _shape(delta, vertex_normals(meshes.neutral + delta, meshes.topology.faces) - normals)
            for delta in meshes.deltas
        ],
        "names": quoted(source.expressions),
    }


def _shape(delta: NDArray[np.float32], turned: NDArray[np.float32]) -> dict[str, str]:
    moved = np.flatnonzero((delta != 0).any(axis=1) | (np.abs(turned).max(axis=1) >= SMALLEST_TURN))
    return {
        "points": integers(moved),
        "offsets": vectors(delta[moved]),
        "normal_offsets": vectors(turned[moved], 6),
    }


def quoted(names: Iterable[str]) -> str:
    """Names as a list of strings; quotation marks and backslashes in them are escaped as in JSON."""
    return ", ".join(json.dumps(name, ensure_ascii=False) for name in names)


def integers(values: NDArray[np.integer[Any]]) -> str:
    """A list of whole numbers."""
    return ", ".join(map(str, values.ravel().tolist()))


def vectors(values: NDArray[np.floating[Any]], digits: int = 9) -> str:
    """A list of vectors ``(n, k)``; nine digits are a float32 exactly."""
    pattern = "(" + ", ".join([f"%.{digits}g"] * values.shape[1]) + ")"
    rows: Sequence[Sequence[float]] = values.tolist()
    return ", ".join(pattern % tuple(row) for row in rows)

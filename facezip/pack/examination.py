"""A pack looked at without using it: every file, and all that were changed."""

from pathlib import Path

from facezip.character.diagnosis import Diagnosis, Row, distinct
from facezip.errors import FaceZipError
from facezip.files.packs import MANIFEST
from facezip.files.reading import reading
from facezip.pack.manifest import Manifest
from facezip.pack.parsing import damaged_pack, read_manifest
from facezip.pack.read import read_stored
from facezip.pack.verification import stored


def examine_pack(folder: Path) -> Diagnosis:
    """What a pack holds; where it cannot be used, every file that is missing, added or changed."""
    faults: list[FaceZipError] = []
    rows: list[Row] = []
    summary = "cannot be read"
    try:
        manifest = read_manifest(folder)
        rows, summary = _rows(manifest), _summary(manifest)
        faults += _changed(folder, manifest)
        if not faults:
            read_stored(folder, manifest)
    except FaceZipError as error:
        faults.append(error)
    return Diagnosis("pack", str(folder), summary, tuple(rows), distinct(faults))


def _summary(manifest: Manifest) -> str:
    maps, tiles = ", ".join(kind.name for kind in manifest.maps), ", ".join(str(tile.number) for tile in manifest.tiles)
    differences = manifest.footprint.differences
    return (
        f"'{manifest.name}', {len(manifest.expressions)} expressions; {maps}, {tiles}; {differences} differences each"
    )


def _changed(folder: Path, manifest: Manifest) -> list[FaceZipError]:
    """All that the first fault of :func:`facezip.pack.verification.verify_pack` would hide."""
    with reading(folder):
        present = {entry.name for entry in folder.iterdir()}
        wrong = dict.fromkeys(present - {*manifest.files, MANIFEST}, "not part of the pack")
        for name, stated in manifest.files.items():
            if name not in present:
                wrong[name] = "missing"
            elif (folder / name).is_symlink() or not (folder / name).is_file():
                wrong[name] = "a link or folder, not a file"
            elif stored(folder / name) != stated:
                wrong[name] = "not as it was written"
    return [damaged_pack(folder, f"'{name}' is {what}") for name, what in sorted(wrong.items())]


def _rows(manifest: Manifest) -> list[Row]:
    rows = []
    for (map, tile), (entry, texture) in manifest.entries().items():
        size = f"{texture.size[1]}x{texture.size[0]}"
        stored_as = f"png, uint{texture.neutral_bits}, {entry.image_channels} channel(s), {entry.encoding}"
        rows.append(Row(texture.neutral, map, "neutral", tile, stored_as, "as stored", size))
        rows += [
            Row(file, map, "difference", tile, f"png, uint8, {entry.image_channels} channel(s)", "as stored", size)
            for file in texture.differences
        ]
    for one in manifest.tiles:
        size = f"{one.weight_size[1]}x{one.weight_size[0]} each"
        rows += [Row(file, "weights", "", one.number, "png, uint8", "as stored", size) for file in one.weights]
    if manifest.geometry:
        size = f"{manifest.geometry.vertices} vertices, {manifest.geometry.triangles} triangles"
        rows += [Row(file, "mesh", "", None, size=size) for file in manifest.geometry.files]
    return rows

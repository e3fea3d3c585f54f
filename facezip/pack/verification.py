"""Whether every byte of a pack is as it was written, and nothing else is there."""

import hashlib
import os
import stat
from collections.abc import Iterable
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

from facezip.files.packs import MANIFEST
from facezip.files.reading import reading
from facezip.files.renaming import recover
from facezip.machine.cores import cores
from facezip.pack.manifest import Manifest, StoredFile
from facezip.pack.parsing import damaged_pack, read_manifest


def verify_pack(path: str | Path) -> Manifest:
    """Check that every byte of a pack is as it was written and that nothing was added.

    Raises
    ------
    FaceZipError
        What :func:`facezip.pack.parsing.read_manifest` raises; ``DAMAGED_PACK`` for a file that is missing, added,
        linked, of another length, or with another checksum.
    """
    folder = Path(path)
    with reading(folder):
        recover(Path(os.path.realpath(folder)))
        manifest = read_manifest(folder)
        _check_presence(folder, manifest)
        with ThreadPoolExecutor(cores()) as pool:
            found = stored_files(folder, manifest.files, pool)
        for name, stated in manifest.files.items():
            if found[name] != stated:
                raise damaged_pack(folder, f"'{name}' was changed or damaged after it was written")
    return manifest


def bytes_on_disk(folder: str | Path) -> int:
    """Bytes of all files of a pack."""
    with reading(Path(folder)):
        return sum(file.lstat().st_size for file in Path(folder).iterdir())


def stored(file: Path) -> StoredFile:
    """Length and checksum of a file."""
    with open(file, "rb") as content:
        return StoredFile(os.fstat(content.fileno()).st_size, hashlib.file_digest(content, "sha256").hexdigest())


def stored_files(folder: Path, names: Iterable[str], pool: Executor) -> dict[str, StoredFile]:
    """Lengths and checksums of files of a folder, by name."""
    names = list(names)
    return dict(zip(names, pool.map(lambda name: stored(folder / name), names), strict=True))


def _check_presence(folder: Path, manifest: Manifest) -> None:
    """Names, kinds and lengths, before any file is opened."""
    present = {entry.name for entry in folder.iterdir()}
    for name in sorted(present ^ {*manifest.files, MANIFEST}):
        raise damaged_pack(folder, f"'{name}' is {'not part of the pack' if name in present else 'missing'}")
    for name, stated in manifest.files.items():
        status = (folder / name).lstat()
        if not stat.S_ISREG(status.st_mode):
            raise damaged_pack(folder, f"'{name}' is a link or folder, not a file")
        if status.st_size != stated.bytes:
            # Which says so where that is what Git LFS left in its place.
            with reading(folder / name):
                raise damaged_pack(folder, f"'{name}' has {status.st_size} bytes, not {stated.bytes}")

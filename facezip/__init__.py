"""The compressor: textured facial blendshapes in, one pack out.

>>> import facezip
>>> character = facezip.load_character("my_scans")
>>> model = facezip.compress(character)
>>> facezip.write_pack(model, "my_scans.facezip")
>>> texture = facezip.read_pack("my_scans.facezip").blend({"smile": 0.5, "blink": 1.0})
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from facezip.machine import caches
from facezip.version import __version__

if TYPE_CHECKING:
    from facezip.character.loading import load_character, save_character
    from facezip.character.maps import Map
    from facezip.character.meshes import Meshes
    from facezip.character.scans import Character, Stack
    from facezip.errors import ErrorCode, FaceZipError
    from facezip.files.obj import Topology
    from facezip.fit.choice import choose
    from facezip.fit.methods import compress
    from facezip.pack.model import CompressedTextures, Part
    from facezip.pack.read import read_pack
    from facezip.pack.verification import verify_pack
    from facezip.pack.write import write_pack

# Before any library looks for its own.
caches.settle()

# Where each public name lives: modules load on first use, so that `facezip info` starts at once.
_HOMES = {
    "Character": "character.scans",
    "CompressedTextures": "pack.model",
    "ErrorCode": "errors",
    "FaceZipError": "errors",
    "Map": "character.maps",
    "Meshes": "character.meshes",
    "Part": "pack.model",
    "Stack": "character.scans",
    "Topology": "files.obj",
    "choose": "fit.choice",
    "compress": "fit.methods",
    "load_character": "character.loading",
    "read_pack": "pack.read",
    "save_character": "character.loading",
    "verify_pack": "pack.verification",
    "write_pack": "pack.write",
}

__all__ = [
    "Character",
    "CompressedTextures",
    "ErrorCode",
    "FaceZipError",
    "Map",
    "Meshes",
    "Part",
    "Stack",
    "Topology",
    "__version__",
    "choose",
    "compress",
    "load_character",
    "read_pack",
    "save_character",
    "verify_pack",
    "write_pack",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'facezip' has no attribute '{name}'")
    return getattr(import_module(f"facezip.{_HOMES[name]}"), name)

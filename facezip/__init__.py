"""The compressor: textured facial blendshapes in, one pack out.

>>> import facezip
>>> character = facezip.load_character("my_scans")
>>> model = facezip.compress(character)
>>> facezip.write_pack(model, "my_scans.facezip")
>>> texture = facezip.read_pack("my_scans.facezip").blend({"smile": 0.5, "blink": 1.0})
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from facezip.character import Character, load_character, save_character
    from facezip.choice import choose
    from facezip.errors import ErrorCode, FaceZipError
    from facezip.meshes import Topology
    from facezip.methods import compress
    from facezip.model import CompressedTextures, Meshes
    from facezip.pack import read_pack, verify_pack, write_pack

__version__ = "0.1.0"

# Where each public name lives: modules load on first use, so that `facezip info` starts at once.
_HOMES = {
    "Character": "character",
    "CompressedTextures": "model",
    "ErrorCode": "errors",
    "FaceZipError": "errors",
    "Meshes": "model",
    "Topology": "meshes",
    "choose": "choice",
    "compress": "methods",
    "load_character": "character",
    "read_pack": "pack",
    "save_character": "character",
    "verify_pack": "pack",
    "write_pack": "pack",
}

__all__ = [
    "Character",
    "CompressedTextures",
    "ErrorCode",
    "FaceZipError",
    "Meshes",
    "Topology",
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

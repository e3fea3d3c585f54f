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
    from facezip.surface.folder import load_surface, save_surface
    from facezip.surface.joint import compress_surface
    from facezip.surface.model import CompressedSurface
    from facezip.surface.pack import read_surface, write_surface
    from facezip.surface.scans import Surface

__version__ = "0.1.0"

# Where each public name lives: modules load on first use, so that `facezip info` starts at once.
_HOMES = {
    "Character": "character",
    "CompressedSurface": "surface.model",
    "CompressedTextures": "model",
    "ErrorCode": "errors",
    "FaceZipError": "errors",
    "Meshes": "model",
    "Surface": "surface.scans",
    "Topology": "meshes",
    "choose": "choice",
    "compress": "methods",
    "compress_surface": "surface.joint",
    "load_character": "character",
    "load_surface": "surface.folder",
    "read_pack": "pack",
    "read_surface": "surface.pack",
    "save_character": "character",
    "save_surface": "surface.folder",
    "verify_pack": "pack",
    "write_pack": "pack",
    "write_surface": "surface.pack",
}

__all__ = [
    "Character",
    "CompressedSurface",
    "CompressedTextures",
    "ErrorCode",
    "FaceZipError",
    "Meshes",
    "Surface",
    "Topology",
    "choose",
    "compress",
    "compress_surface",
    "load_character",
    "load_surface",
    "read_pack",
    "read_surface",
    "save_character",
    "save_surface",
    "verify_pack",
    "write_pack",
    "write_surface",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'facezip' has no attribute '{name}'")
    return getattr(import_module(f"facezip.{_HOMES[name]}"), name)

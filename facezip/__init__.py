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
    from facezip.character.folder import load_surface, save_surface
    from facezip.character.scans import Character, load_character, save_character
    from facezip.character.surface import Surface
    from facezip.errors import ErrorCode, FaceZipError
    from facezip.files.obj import Topology
    from facezip.fit.choice import choose
    from facezip.fit.joint import compress_surface
    from facezip.fit.methods import compress
    from facezip.pack.model import CompressedTextures, Meshes
    from facezip.pack.surface_model import CompressedSurface
    from facezip.pack.version_1 import read_pack, verify_pack, write_pack
    from facezip.pack.version_2 import read_surface, write_surface

__version__ = "0.1.0"

# Where each public name lives: modules load on first use, so that `facezip info` starts at once.
_HOMES = {
    "Character": "character.scans",
    "CompressedSurface": "pack.surface_model",
    "CompressedTextures": "pack.model",
    "ErrorCode": "errors",
    "FaceZipError": "errors",
    "Meshes": "pack.model",
    "Surface": "character.surface",
    "Topology": "files.obj",
    "choose": "fit.choice",
    "compress": "fit.methods",
    "compress_surface": "fit.joint",
    "load_character": "character.scans",
    "load_surface": "character.folder",
    "read_pack": "pack.version_1",
    "read_surface": "pack.version_2",
    "save_character": "character.scans",
    "save_surface": "character.folder",
    "verify_pack": "pack.version_1",
    "write_pack": "pack.version_1",
    "write_surface": "pack.version_2",
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

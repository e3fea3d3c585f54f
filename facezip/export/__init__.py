"""A pack in the form that a target takes: one module a target."""

from collections.abc import Callable

from facezip.documents.document import Document
from facezip.export.blender import export_blender
from facezip.export.gltf import export_gltf
from facezip.export.godot import export_godot
from facezip.export.metahuman import export_metahuman
from facezip.export.o3de import export_o3de
from facezip.export.three import export_three
from facezip.export.unity import export_unity
from facezip.export.unreal import export_unreal
from facezip.export.usd import export_usd
from facezip.export.web import export_web

# Each is called with the pack and the output, and with those options as keywords that were given.
TARGETS: dict[str, Callable[..., Document]] = {
    "gltf": export_gltf,
    "unity": export_unity,
    "unreal": export_unreal,
    "godot": export_godot,
    "three": export_three,
    "blender": export_blender,
    "usd": export_usd,
    "metahuman": export_metahuman,
    "o3de": export_o3de,
    "web": export_web,
}

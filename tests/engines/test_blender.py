"""The script of Blender exports runs in Blender and shows in Cycles what ``blend`` gives."""

import ast
import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from facezip import FaceZipError
from facezip.export import TARGETS
from facezip.files.srgb import encode_srgb
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from render.shading import DIFFUSE_CAVITY
from scenes.materials import ROUGHNESS, SPECULAR
from tests.engines import cycles
from tests.engines.heads import HEADS, faces_on, head, named
from tests.facezip.conftest import random_model
from tests.facezip.export.conftest import smooth_model

# Names longer than Blender keeps, which are alike as far as it does.
LONG = ("é" * 60 + " one", "é" * 60 + " two", "a" * 63, "short")
CASES = {
    # Blender's weight maps are rounded where they are made of masks.
    **{name: made for name, made in HEADS.items() if "in blocks" not in name and name != "masks"},
    "20 shapes": head(smooth_model(side=64, expressions=20, meshes=False)),
    "52 shapes": head(smooth_model(side=64, expressions=52, meshes=False)),
    "long names": head(named(random_model(expressions=len(LONG)), LONG)),
}
# The left half of the texture and all of it, by gain.
REGIONS = {"left": 0.25, 'brow\'s "edge"': 0.5}
# Of 255.
AT_TEXELS, ON_HEAD = 0.5, 0.1


@dataclass(frozen=True)
class Case:
    """An export, and what Blender should make of it."""

    name: str
    surface: CompressedTextures
    folder: Path
    output: Path
    poses: list

    @property
    def request(self):
        spans = {kind.name: [0.0, 1.0] if kind.is_normal else [kind.low, kind.high] for kind in self.surface.maps}
        return {
            "name": self.folder.name,
            "names": self.surface.expressions,
            "folder": str(self.folder),
            "output": str(self.output),
            "size": self.surface.parts["albedo", self.surface.tiles[0]].neutral.shape[:2],
            "maps": spans,
            "poses": self.poses,
            "from_editor": self.name in ("one map", "odd names"),
            "jobs": ["pictures", "baked", "reopened"] if "shapes" in self.name else ["pictures", "reopened"],
        }


def poses(surface):
    """Weights and gains: the neutral, the last expression, a blend, and gains of all kinds."""
    names = surface.expressions
    rng = np.random.default_rng(len(names))
    mixed = dict(zip(names, (rng.uniform(-0.5, 1, len(names)) / np.sqrt(len(names))).tolist(), strict=True))
    halved = {"gains.maps.albedo": 0.5}
    return [
        ({}, {}),
        ({names[-1]: 1.0}, {}),
        (mixed, {}),
        (mixed, halved),
        (mixed, {f"gains.expressions.{names[-1]}": 0}),
    ]


def expected(case, kind, tile, number):
    """A map of a pose, from 0 to 1 of its range."""
    weights, gains = case.poses[number]
    gain = gains.get(f"gains.maps.{kind.name}", 1.0)
    strengths = {name: gain * gains.get(f"gains.expressions.{name}", 1.0) for name in weights}
    values = case.surface.blend({name: strengths[name] * value for name, value in weights.items()}, kind.name, tile)
    return 0.5 * values + 0.5 if kind.is_normal else (values - kind.low) / (kind.high - kind.low)


def seen(case, kind, tile, number):
    number %= len(case.poses)
    values = cycles.picture(case.output / f"{tile}.{kind.name}.{number}.exr")[..., :3]
    return encode_srgb(np.clip(values, 0, 1)) if kind.encoding == "srgb" else values


def add_regions(folder):
    """As an export with regions has them."""
    document = json.loads((folder / "facezip.json").read_text())
    height, width = document["weight_size"]
    masks = np.full((height, 2 * width), 255, np.uint8)
    masks[:, width // 2 : width] = 0
    Image.fromarray(masks).save(folder / "regions.png")
    document["gains"] = {"regions": list(REGIONS)}
    document["regions"] = {"file": "regions.png", "columns": 2, "size": [height, width]}
    (folder / "facezip.json").write_text(json.dumps(document))


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    found = {}
    regions = {"regions": head(smooth_model(side=64, meshes=False))}
    for number, (name, surface) in enumerate({**CASES, **regions}.items()):
        folder = tmp_path_factory.mktemp("blender")
        write_pack(surface, folder / "me.facezip")
        TARGETS["blender"](folder / "me.facezip", folder / f"case_{number}")
        (folder / "out").mkdir()
        model = read_pack(folder / "me.facezip")
        found[name] = Case(name, model, folder / f"case_{number}", folder / "out", poses(model))
        if name == "regions":
            add_regions(folder / f"case_{number}")
            found[name].poses.append((found[name].poses[2][0], {f"gains.regions.{k}": v for k, v in REGIONS.items()}))
    return found


@pytest.fixture(scope="module")
def answers(cases, tmp_path_factory):
    """All exports in one Blender, which takes seconds to start."""
    cycles.needed()
    request = {"cases": [case.request for case in cases.values()]}
    return cycles.run("session.py", tmp_path_factory.mktemp("session"), request)


@pytest.fixture(params=CASES)
def case(request, cases):
    return cases[request.param]


def answer(answers, case):
    return answers["cases"][case.folder.name]


def test_the_script_is_python_that_names_files_of_the_folder(case):
    text = (case.folder / "build_head.py").read_text(encoding="utf-8")
    ast.parse(text, feature_version=(3, 11))
    assert "{{" not in text
    for file in re.findall(r'"([\w.]+\.(?:glb|json|png))"', text):
        assert (case.folder / file).is_file()
    document = json.loads((case.folder / "facezip.json").read_text())
    for tile, facts in document.get("tiles", {"": document}).items():
        assert all((case.folder / tile / entry["file"]).is_file() for entry in facts["textures"].values())


def test_the_script_has_the_skin_of_the_verdict(case):
    body = ast.parse((case.folder / "build_head.py").read_text(encoding="utf-8")).body
    constants = {ast.unparse(node.targets[0]): ast.unparse(node.value) for node in body if isinstance(node, ast.Assign)}
    assert constants["(ROUGHNESS, SPECULAR)"] == f"({ROUGHNESS}, {SPECULAR})"
    assert float(constants["DIFFUSE_CAVITY"]) == DIFFUSE_CAVITY
    assert ast.literal_eval(constants["KNOWN"]) == [
        kind.name for kind in case.surface.maps if kind.name != "cavity" or kind.low == 0
    ]


def test_a_pack_without_meshes_is_refused(tmp_path):
    write_pack(random_model(), tmp_path / "me.facezip")
    with pytest.raises(FaceZipError, match="has no meshes"):
        TARGETS["blender"](tmp_path / "me.facezip", tmp_path / "face")
    assert not (tmp_path / "face").exists()


def test_cycles_shows_the_blend_at_the_centres_of_texels(answers, case):
    for kind in case.surface.maps:
        for tile in faces_on(case.surface):
            for number in range(len(case.poses)):
                difference = seen(case, kind, tile, number) - expected(case, kind, tile, number)
                assert 255 * np.abs(difference).max() <= AT_TEXELS, (kind.name, tile, number)


def test_a_region_can_be_turned_down(answers, cases):
    case = cases["regions"]
    shown, weights = seen(case, case.surface.maps[0], 1001, -1), case.poses[-1][0]
    # Between the halves masks are interpolated, from one texel of a weight map to the next.
    half, step = 32, 8
    for columns, gain in ((slice(0, half - step), 0.25 * 0.5), (slice(half + step, None), 0.5)):
        expected = case.surface.blend({name: gain * value for name, value in weights.items()})
        assert 255 * np.abs(shown - expected)[:, columns].max() <= AT_TEXELS
        assert 255 * np.abs(shown - case.surface.blend(weights))[:, columns].max() > 2 * AT_TEXELS


@pytest.mark.parametrize("name", ["20 shapes", "52 shapes"])
def test_baked_on_the_head_it_is_the_blend(answers, cases, name):
    """Of textures like those of skin: Blender's bakes look a little beside the centres of texels."""
    case = cases[name]
    for number in range(len(case.poses)):
        baked = encode_srgb(np.clip(np.load(case.output / f"baked.{number}.npy")[..., :3], 0, 1))
        difference = baked - expected(case, case.surface.maps[0], 1001, number)
        assert 255 * np.sqrt(np.mean(np.square(difference))) <= ON_HEAD


def test_the_mesh_has_the_shapes_of_the_pack_in_their_order(answers, case):
    found, meshes = answer(answers, case), case.surface.meshes
    names = [name.encode()[:63].decode(errors="ignore") for name in case.surface.expressions]
    if len({*names}) == len(names):
        assert found["keys"] == ["Basis", *names]
    # Blender's z is up.
    vertices = np.array(found["vertices"])[:, [0, 2, 1]] * [1, 1, -1]
    deltas = np.array(found["deltas"])[..., [0, 2, 1]] * [1, 1, -1]
    np.testing.assert_allclose(sorted(map(tuple, vertices)), sorted(map(tuple, meshes.neutral)), atol=1e-6)
    np.testing.assert_allclose(deltas, np.broadcast_to(meshes.deltas[:, :1], deltas.shape), atol=1e-5)


def test_sliders_view_and_colour_spaces_are_as_the_guide_says(answers, case):
    found = answer(answers, case)
    assert found["sliders"] == [[-1, 2]]
    assert found["view"] == ["Standard", "None", 0, 1]
    assert {tuple(facts) for facts in found["images"].values()} == {("Non-Color", "CHANNEL_PACKED")}
    assert found["broken"] == []
    assert {*found["gains"].values()} == {1}
    assert len(found["gains"]) == len(case.surface.expressions) + len(case.surface.maps)


def test_drivers_work_after_saving_with_scripts_off(answers, case):
    for (weights, gains), given in zip(case.poses, answer(answers, case)["reopened"], strict=True):
        shown = [gains.get(f"gains.expressions.{name}", 1) * weights.get(name, 0) for name in case.surface.expressions]
        np.testing.assert_allclose(given, shown, atol=1e-6)

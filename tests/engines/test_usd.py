"""USD exports are valid, deform as the pack's meshes do, and show what ``blend`` gives in MaterialX's own GLSL."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from facezip.export import TARGETS
from facezip.export.animation import GAIN
from facezip.export.network import DIFFUSE_CAVITY, ROUGHNESS, SPECULAR, blend_network
from facezip.export.source import read_source
from facezip.files.images import read_texture_exactly, to_float
from facezip.files.srgb import encode_srgb
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from render import shading
from scenes import materials
from tests.engines.heads import HEADS, head
from tests.engines.materialx import glsl, libraries, read
from tests.facezip.export.conftest import smooth_model
from tests.facezip.export.gpu import Gpu, software

CASES = {
    **{name: made for name, made in HEADS.items() if "in blocks" not in name},
    "52 shapes": head(smooth_model(side=64, expressions=52, meshes=False)),
}
# Of values from 0 to 1; of the largest coordinate.
IN_GLSL, OF_POINTS = 1e-3, 2e-6
# What MaterialX's own vertex shaders hand on.
CORNERS = """#version 400
out VertexData { vec2 texcoord_0; } vd;
void main() {
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0;
    vd.texcoord_0 = 0.5 * corner + 0.5;
    gl_Position = vec4(corner, 0, 1);
}"""
TYPES = {"float2": "vector2", "float3": "vector3", "float4": "vector4", "color3f": "color3", "asset": "filename"}
TYPES |= {"int": "integer", "token": "surfaceshader"}


@dataclass(frozen=True)
class Case:
    """An export with an animation, and what it is of."""

    pack: Path
    folder: Path
    surface: CompressedTextures
    frames: list

    def place(self, tile):
        return self.folder / str(tile) if len(self.surface.tiles) > 1 else self.folder


def frames(names):
    rng = np.random.default_rng(len(names))
    mixed = (rng.uniform(-0.5, 1, len(names)) / np.sqrt(len(names))).tolist()
    blend = dict(zip(names, mixed, strict=True))
    return [{}, {names[-1]: 1.0}, blend, {**blend, GAIN + names[0]: 0.25}]


def weights(frame):
    """What textures follow."""
    return {name: frame.get(GAIN + name, 1) * weight for name, weight in frame.items() if not name.startswith(GAIN)}


def write_csv(file, names, rows):
    with open(file, "w", newline="", encoding="utf-8") as content:
        writer = csv.writer(content)
        gains = [[row.get(GAIN + name, 1.0) for name in names] for row in rows]
        betas = [[row.get(name, 0.0) for name in names] for row in rows]
        writer.writerow([*names, *(GAIN + name for name in names)])
        writer.writerows([*beta, *gain] for beta, gain in zip(betas, gains, strict=True))


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    found = {}
    for name, surface in CASES.items():
        folder = tmp_path_factory.mktemp("usd")
        write_pack(surface, folder / "me.facezip")
        write_csv(folder / "frames.csv", surface.expressions, frames(surface.expressions))
        TARGETS["usd"](folder / "me.facezip", folder / "face", animation=folder / "frames.csv")
        model = read_pack(folder / "me.facezip")
        found[name] = Case(folder / "me.facezip", folder / "face", model, frames(model.expressions))
    return found


@pytest.fixture(params=CASES)
def case(request, cases):
    return cases[request.param]


@pytest.fixture
def stage(case):
    usd = pytest.importorskip("pxr.Usd", reason="USD is not installed: pip install usd-core")
    return usd.Stage.Open(str(case.folder / "head.usda"))


@pytest.fixture(scope="module")
def gpu():
    with software() as context:
        yield Gpu(context)


def shaders(stage):
    """Nodes of MaterialX, by material and name."""
    from pxr import UsdShade

    for prim in stage.Traverse():
        shader = UsdShade.Shader(prim)
        if shader and shader.GetShaderId().startswith("ND_"):
            yield prim, shader


def test_validators_know_of_nothing_but_missing_materialx(case, stage):
    """OpenUSD's packages for Python come without MaterialX; its nodes are looked up in MaterialX below."""
    from pxr import UsdValidation

    registry = UsdValidation.ValidationRegistry()
    errors = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators()).Validate(stage)
    ids = {shader.GetShaderId() for _, shader in shaders(stage)}
    assert ids
    others = [error.GetMessage() for error in errors if error.GetName() != "MissingShaderIdInRegistry"]
    assert others == []
    assert all(re.search(r"'(ND_\w+)'", error.GetMessage())[1] in ids for error in errors)


def test_every_node_is_one_of_materialx(case, stage):
    definitions, _ = libraries()
    for prim, shader in shaders(stage):
        definition = definitions.getNodeDef(shader.GetShaderId())
        assert definition, shader.GetShaderId()
        for given in shader.GetInputs():
            kind = str(given.GetTypeName())
            known = definition.getActiveInput(given.GetBaseName())
            assert known, (shader.GetShaderId(), given.GetBaseName())
            assert known.getType() == TYPES.get(kind, kind), prim.GetPath()
        (output,) = shader.GetOutputs()
        assert definition.getActiveOutput(output.GetBaseName()).getType() == TYPES.get(
            str(output.GetTypeName()), str(output.GetTypeName())
        )


def test_connections_are_of_one_type_and_lead_to_what_there_is(case, stage):
    from pxr import UsdShade

    for prim in stage.Traverse():
        for given in (*UsdShade.ConnectableAPI(prim).GetInputs(), *UsdShade.ConnectableAPI(prim).GetOutputs()):
            for path in given.GetAttr().GetConnections():
                source = stage.GetAttributeAtPath(path)
                assert source, path
                if "preview" not in str(path):
                    assert source.GetTypeName() == given.GetTypeName(), path


def test_the_file_of_materialx_has_the_same_nodes(case, stage):
    for tile in case.surface.tiles:
        document = read(case.place(tile) / "facezip.mtlx")
        nodes = {node.getName(): node.getNodeDefString() for node in document.getNodes()}
        nodes.pop("facezip")
        inside = f"/head/materials/tile_{tile}/"
        assert nodes == {
            prim.GetName(): shader.GetShaderId()
            for prim, shader in shaders(stage)
            if str(prim.GetPath()).startswith(inside)
        }


def test_every_file_is_there_at_every_frame(case, stage):
    from pxr import Sdf

    files = set()
    for attribute in (attribute for prim in stage.Traverse() for attribute in prim.GetAttributes()):
        if attribute.GetTypeName() == Sdf.ValueTypeNames.Asset:
            times = attribute.GetTimeSamples() or [0]
            files |= {attribute.Get(time).resolvedPath for time in times}
    names = {str(Path(file).relative_to(case.folder)) for file in files if file}
    assert "" not in files
    images = {name for name in names if "weights" in name}
    layers = -(-case.surface.weights[case.surface.tiles[0]].shape[3] // 4)
    assert len(images) == len(case.frames) * layers * len(case.surface.tiles)
    assert all((case.folder / name).is_file() for name in names)


def test_the_mesh_deforms_as_the_meshes_of_the_pack(case, stage):
    from pxr import Gf, Usd, UsdSkel

    root = UsdSkel.Root(stage.GetPrimAtPath("/head"))
    names = stage.GetPrimAtPath("/head/animation").GetAttribute("blendShapes").Get()
    assert tuple(names) == case.surface.expressions
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, len(case.frames) - 1)
    UsdSkel.BakeSkinning(root, Gf.Interval(0, len(case.frames) - 1))
    points, meshes = stage.GetPrimAtPath("/head/mesh").GetAttribute("points"), case.surface.meshes
    for number, frame in enumerate(case.frames):
        beta = np.array([frame.get(name, 0) for name in case.surface.expressions], np.float32)
        expected = meshes.neutral + np.tensordot(beta, meshes.deltas, axes=1)
        size = np.abs(expected).max()
        assert np.abs(np.array(points.Get(Usd.TimeCode(number))) - expected).max() <= OF_POINTS * size


def test_uvs_and_materials_are_those_of_the_tiles(case, stage):
    from pxr import UsdGeom, UsdShade

    mesh = stage.GetPrimAtPath("/head/mesh")
    uv = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").ComputeFlattened()).reshape(-1, 3, 2)
    assert uv.min() >= 0
    assert uv.max() <= 1
    topology, faces = (
        case.surface.meshes.topology,
        np.array(mesh.GetAttribute("faceVertexIndices").Get()).reshape(-1, 3),
    )
    whole = topology.uv[topology.face_uv]
    assert {tuple(face) for face in faces.tolist()} == {tuple(face) for face in topology.faces.tolist()}
    shifted = whole - np.floor(whole.mean(axis=1, keepdims=True))
    assert {*map(tuple, uv.reshape(-1, 6).round(5).tolist())} == {*map(tuple, shifted.reshape(-1, 6).round(5).tolist())}
    bound = UsdShade.MaterialBindingAPI(mesh)
    if len(case.surface.tiles) == 1:
        assert bound.ComputeBoundMaterial()[0].GetPath() == "/head/materials/tile_1001"
    else:
        subsets = bound.GetMaterialBindSubsets()
        columns = np.floor(whole.mean(axis=1)[:, 0]).astype(int) + 1001
        for subset in subsets:
            material = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0].GetPrim().GetName()
            count = len(subset.GetIndicesAttr().Get())
            assert count == (columns == int(material.removeprefix("tile_"))).sum()


def test_weights_of_a_frame_are_those_of_the_blend(case):
    for tile in case.surface.tiles:
        for number, frame in enumerate(case.frames):
            expected = case.surface.combined(weights(frame), tile)
            for layer in range(-(-expected.shape[2] // 4)):
                seen = exr(case.place(tile) / f"weights_{layer}.{number:04d}.exr")
                slots = expected[..., 4 * layer : 4 * layer + 4]
                np.testing.assert_allclose(seen[..., : slots.shape[2]], slots, atol=1e-6)
                assert (seen[..., slots.shape[2] :] == 0).all()


def exr(file):
    return oiio.ImageBuf(str(file)).get_pixels(oiio.FLOAT)


def textures(gpu, folder, number):
    """Textures of a frame by the names of their nodes, the last row first, as renderers load images: v = 0 is below."""
    found = {}
    for file in folder.glob("*.png"):
        if not file.name.startswith(("weights", "preview")):
            found[file.stem] = gpu.texture(to_float(read_texture_exactly(file))[::-1])
    for file in folder.glob(f"weights_*.{number:04d}.exr"):
        found[file.name.split(".")[0]] = gpu.texture(exr(file)[::-1])
    return found


def shader(case, tile, kind, gain=1.0):
    """What shows a map: the text, and how many numbers it gives."""
    document = read(case.place(tile) / "facezip.mtlx")
    document.getNode(f"gain_{kind.name}").setInputValue("value", gain)
    source = next(one for one in read_source(case.pack).tiles if one.layout.number == tile)
    node = blend_network(source).maps[kind.name]
    return glsl(document, node.name), 1 if node.type == "float" else 3


def shown(gpu, case, tile, kind, number, text, channels):
    """A map as MaterialX's GLSL shows it, from 0 to 1 of its range."""
    size = case.surface.parts[kind.name, tile].neutral.shape[:2]
    values = gpu.draw(text, size, textures(gpu, case.place(tile), number), corners=CORNERS)[::-1, :, :channels]
    if kind.encoding == "srgb":
        return encode_srgb(np.clip(values, 0, 1))
    return values if kind.is_normal else (values - kind.low) / (kind.high - kind.low)


def expected(case, tile, kind, number, gain=1.0):
    frame = {name: gain * weight for name, weight in weights(case.frames[number]).items()}
    values = case.surface.blend(frame, kind.name, tile)
    return 0.5 * values + 0.5 if kind.is_normal else (values - kind.low) / (kind.high - kind.low)


def test_materialx_shows_the_blend(gpu, case):
    tile = case.surface.tiles[-1]
    for kind in case.surface.maps:
        text = shader(case, tile, kind)
        for number in range(len(case.frames)):
            error = np.abs(shown(gpu, case, tile, kind, number, *text) - expected(case, tile, kind, number))
            assert error.max() <= IN_GLSL, (kind.name, number)


def test_a_map_can_be_turned_down(gpu, cases):
    case = cases["several maps"]
    for kind in case.surface.maps:
        error = np.abs(
            shown(gpu, case, 1001, kind, 1, *shader(case, 1001, kind, 0.5)) - expected(case, 1001, kind, 1, 0.5)
        )
        assert error.max() <= IN_GLSL, kind.name


def test_the_skin_samples_no_more_textures_than_there_are(case):
    document = read(case.place(1001) / "facezip.mtlx")
    samplers = re.findall(r"uniform sampler2D (\w+)_file;", glsl(document, "skin"))
    images = {node.getName() for node in document.getNodes("image")}
    assert len(samplers) == len({*samplers})
    assert {*samplers} <= images
    # All maps but those that a standard surface has no place for.
    seen = {kind.name for kind in case.surface.maps if kind.low == 0 or kind.is_normal}
    if seen == {kind.name for kind in case.surface.maps}:
        assert {*samplers} == images


def test_the_skin_is_that_of_the_verdict():
    assert (ROUGHNESS, SPECULAR) == (materials.ROUGHNESS, materials.SPECULAR)
    assert DIFFUSE_CAVITY == shading.DIFFUSE_CAVITY

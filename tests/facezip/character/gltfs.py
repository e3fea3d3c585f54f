"""glTFs as exporters write them: a small character in one file, changed, split over files, or put into URIs."""

import base64
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from facezip.character.gltf_read import load_gltf
from facezip.files.glb import Glb
from facezip.files.glb_builder import GlbBuilder
from facezip.files.images import png
from tests.facezip.conftest import random_character, with_albedo

FORMS = ("glb", "glb, images beside", "gltf, files beside", "gltf, data in URIs")


def scans(seed=0, mask=True, **how):
    """A small character: a sheet of 5 x 5 vertices with textures of 8 x 8 texels."""
    character = random_character(seed=seed, **{"side": 8, "grid": 5, "expressions": 2, **how})
    vertices = character.meshes.neutral / 20
    meshes = replace(character.meshes, neutral=vertices, vertices=character.meshes.vertices / 20)
    region = np.zeros(character.first.resolution, np.float32)
    region[1:7, 2:6] = 1
    return with_albedo(replace(character, meshes=meshes), **({"mask": region} if mask else {}))


class Scene:
    """A glTF under construction.

    Attributes
    ----------
    character : whose it is.
    document, builder : its JSON, and what collects its arrays.
    """

    def __init__(self, character):
        self.character = character
        meshes = character.meshes
        self.builder = GlbBuilder({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}]})
        self.document = self.builder.document
        self.document["nodes"] = [{"name": "head node", "mesh": 0}]
        names = ["neutral", *character.expressions]
        albedo = [character.first.neutral, *character.first.textures]
        for name, texels in zip(names, albedo, strict=True):
            self.material(name, texels)
        if character.first.mask is not None:
            self.material("mask", character.first.mask[:, :, None])
        corners = meshes.topology.faces.ravel()
        uv = meshes.topology.uv[meshes.topology.face_uv.ravel()]
        primitive = self.primitive(
            meshes.neutral[corners], uv * (1, -1) + (0, 1), [delta[corners] for delta in meshes.deltas], 0
        )
        self.mesh("head", [primitive], character.expressions)

    @property
    def face(self):
        """The primitive of the face."""
        return self.document["meshes"][0]["primitives"][0]

    def add(self, kind, entry):
        self.document.setdefault(kind, []).append(entry)
        return len(self.document[kind]) - 1

    def image(self, name, texels):
        return self.builder.image(name, png(texels), "image/png")

    def texture(self, texels, name="", **more):
        return self.add("textures", {"source": self.image(name, texels), **more})

    def material(self, name, texels=None, **more):
        shading = {} if texels is None else {"baseColorTexture": {"index": self.texture(texels, name)}}
        return self.add("materials", {"name": name, "pbrMetallicRoughness": shading, **more})

    def materials(self, *names):
        """The materials of the names, or of the neutral, the expressions and the mask."""
        return [entry for entry in self.document["materials"] if not names or entry["name"] in names]

    def textures(self):
        """The base colour textures of all materials."""
        found = (entry["pbrMetallicRoughness"].get("baseColorTexture") for entry in self.materials())
        return [entry for entry in found if entry]

    def array(self, values):
        return self.builder.array(np.asarray(values, np.float32))

    def primitive(self, positions, uv, targets, material):
        return {
            "attributes": {"POSITION": self.array(positions), "TEXCOORD_0": self.array(uv)},
            "targets": [{"POSITION": self.array(delta)} for delta in targets],
            "material": material,
        }

    def mesh(self, name, primitives, targets=()):
        extras = {"extras": {"targetNames": list(targets)}} if targets else {}
        return self.add("meshes", {"name": name, "primitives": primitives, **extras})

    def show(self, mesh, **node):
        self.document["scenes"][0]["nodes"].append(self.add("nodes", {"mesh": mesh, **node}))

    def glb(self):
        return self.builder.finish()

    def write(self, folder, form="glb"):
        """Write it in one of :data:`FORMS`; the path."""
        return write(self.glb(), folder, form)

    def read(self, folder):
        """The character that is read back, where nodes put it: not where heads have to be."""
        path = self.write(folder)
        return load_gltf(path, path.stem, None, None, 2)


def full_scene():
    """A scene that states all that is read: nodes, a skin, a placement, a factor, other maps, and a second part."""
    scene = Scene(scans())
    count = scene.document["accessors"][scene.face["attributes"]["POSITION"]]["count"]
    joints = scene.builder.array(np.zeros((count, 4), np.uint8))
    scene.face["attributes"] |= {"JOINTS_0": joints, "WEIGHTS_0": scene.array(np.eye(4)[:1].repeat(count, axis=0))}
    scene.document["nodes"][0]["skin"] = scene.add("skins", {"joints": [1]})
    scene.document["nodes"] += [{"scale": [2, 2, 2]}, {"children": [1], "translation": [0, 1, 0]}]
    flat = np.full((4, 4, 3), (128, 128, 255), np.uint8)
    for material in scene.materials():
        shading = material["pbrMetallicRoughness"]
        transform = {"scale": [-1, 1], "offset": [1, 0], "rotation": 0.0}
        shading["baseColorTexture"]["extensions"] = {"KHR_texture_transform": transform}
        placed = {"extensions": {"KHR_texture_transform": transform}}
        material["normalTexture"] = {"index": scene.texture(flat), "scale": 0.5, **placed}
        shading |= {"baseColorFactor": [0.5, 0.5, 0.5, 1], "roughnessFactor": 0.5}
        shading["metallicRoughnessTexture"] = {"index": scene.texture(flat), **placed}
    points = np.eye(3)
    teeth = scene.primitive(points, points[:, :2], [points, points], scene.material("enamel"))
    scene.show(scene.mesh("teeth", [teeth], scene.character.expressions), name="teeth node")
    return scene


def write(glb, folder, form):
    """Write a file in one of :data:`FORMS` into an empty folder; the path."""
    for old in folder.iterdir():
        old.unlink()
    document = json.loads(json.dumps(glb.document))
    if form == "glb":
        path = folder / "head.glb"
        path.write_bytes(glb.to_bytes())
        return path
    for number, image in enumerate(document.get("images", [])):
        content = glb.view(image.pop("bufferView"))
        image["uri"] = linked(folder, f"picture {number}.png", image.pop("mimeType"), content, "URIs" in form)
    if form.startswith("glb"):
        path = folder / "head.glb"
        path.write_bytes(Glb(document, glb.binary).to_bytes())
        return path
    document["buffers"] = [
        {
            "byteLength": len(glb.binary),
            "uri": linked(folder, "head.bin", "application/octet-stream", glb.binary, "URIs" in form),
        }
    ]
    path = folder / "head.gltf"
    path.write_text(json.dumps(document, indent=2))
    return path


def linked(folder: Path, name: str, mime: str, content: bytes, as_data: bool) -> str:
    """A URI with the content in it, or of a file that is written."""
    if as_data:
        return f"data:{mime};base64,{base64.b64encode(content).decode()}"
    (folder / name).write_bytes(content)
    return name.replace(" ", "%20")


def corners(character):
    """Positions ``(N + 1, F, 3, 3)`` and UVs ``(F, 3, 2)`` of all triangles' corners."""
    meshes = character.meshes
    shapes = np.concatenate([meshes.neutral[None], meshes.vertices])
    return shapes[:, meshes.topology.faces], meshes.topology.uv[meshes.topology.face_uv]


def assert_same(read, meant, atol=1e-6):
    """The same expressions, geometry and texels; positions and UVs to a tolerance."""
    assert read.expressions == meant.expressions
    for one, other in zip(corners(read), corners(meant), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=atol)
    assert read.stacks.keys() == meant.stacks.keys()
    for key, stack in meant.stacks.items():
        np.testing.assert_array_equal(read.stacks[key].neutral, stack.neutral)
        np.testing.assert_array_equal(read.stacks[key].textures, stack.textures)
        np.testing.assert_array_equal(read.stacks[key].weight, stack.weight)


def words(character):
    """What its notes say."""
    return [note.words for note in character.notes]

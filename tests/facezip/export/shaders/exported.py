"""An export whose shaders are run on the files that lie beside it."""

import base64
import json
import re
from dataclasses import replace

import numpy as np

from facezip.export import TARGETS
from facezip.export.shaders import number
from facezip.files.images import read_texture_exactly
from facezip.files.srgb import decode_srgb
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.export.gains import masks_in, regions_in, turned

# Of values in [0, 1], and of the components of normals.
TOLERANCE = 1e-4


class Exported:
    """An export, its textures in memory as its engine keeps them, and a blend to compare with."""

    def __init__(self, model, target, folder, tile=1001):
        write_pack(model, folder / "me.facezip")
        self.folder, self.model = folder / target, read_pack(folder / "me.facezip")
        uniform = self.model.weights[tile].shape[1:3] == (1, 1)
        self.regions = {} if uniform else regions_in(folder, self.model.tiles)
        TARGETS[target](folder / "me.facezip", self.folder, region=self.regions)
        if len(self.model.tiles) > 1:
            self.folder /= str(tile)
        self.tile = tile
        self.facts = json.loads((self.folder / "facezip.json").read_text())
        rng = np.random.default_rng(1)
        self.beta = rng.uniform(0, 1, len(self.model.expressions)).astype(np.float32)
        self.blend = dict(zip(self.model.expressions, map(float, self.beta), strict=True))
        gains = {kind.name: gain for kind, gain in zip(self.model.maps, rng.uniform(0, 2, 5), strict=False)}
        self.gains = {"maps": gains, "regions": dict(zip(self.regions, rng.uniform(0, 2, 3), strict=False))}
        self.size = self.model.parts["albedo", tile].neutral.shape[:2]
        _, *weight_size, self.slots = self.model.weights[tile].shape
        self.weight_size = tuple(weight_size)
        self.layers = -(-self.slots // 4)
        self.maps = [name for name in self.facts["textures"] if not name.startswith("weights")]
        self.outs = {kind: f"out_{kind.name}" for kind in self.model.maps}
        masks = {self.tile: masks_in(self.folder)} if self.regions else {}
        of_tile = replace(self.model, weights={tile: self.model.weights[tile]})
        self.seen = turned(of_tile, self.gains, masks)

    def text(self, file):
        return (self.folder / file).read_text(encoding="utf-8")

    def textures(self, gpu, upside_down=False):
        turn = -1 if upside_down else 1
        beside = {name: self.facts[name] for name in ("regions", "masks") if name in self.facts}
        entries = {**self.facts["textures"], **beside}
        read = {name: read_texture_exactly(self.folder / entry["file"]) for name, entry in entries.items()}
        return {name: gpu.texture(texels[::turn]) for name, texels in read.items()}

    @property
    def masks(self):
        return self.facts.get("masks")

    @property
    def given(self):
        """What the pre-pass is given of a blend: β, or the activations ``(L · K', 4)`` of masks."""
        if not self.masks:
            return self.beta
        rows = np.frombuffer(base64.b64decode(self.masks["activations"]), "<f2").astype(np.float32)
        return np.einsum("n,nvc->vc", self.beta, rows.reshape(len(self.beta), self.masks["vectors"], 4))

    def given_as(self, vector):
        """The declaration of an array of it."""
        return f"{vector} values[{len(self.given)}]" if self.masks else f"float values[{len(self.beta)}]"

    @property
    def gains_of_regions(self):
        """Text of their list."""
        return ", ".join(map(number, self.gains["regions"].values()))

    def with_gains(self, text, maps, regions):
        """Text whose gains are constants: of maps ``float PREFIXname``, and ``float regions[K]``."""
        for name, gain in self.gains["maps"].items():
            constant = f"static const float {maps}{name} = {number(gain)};"
            text = re.sub(rf"(uniform )?float {maps}{name}( = 1.0)?;", constant, text)
        values = f"static const float {regions}[{len(self.regions)}] = {{ {self.gains_of_regions} }};"
        return re.sub(rf"(uniform )?float {regions}\[\d+\];", values, text)

    def type_of(self, kind):
        return "float" if kind.encoding == "data" else "vec3"

    @property
    def wide(self):
        """Of a picture of all maps, side by side."""
        return self.size[0], self.size[1] * len(self.model.maps)

    def shown(self, vector, place, values):
        """Text that takes, at a place of the wide picture, the value of the map there."""
        maps = range(len(self.model.maps))
        cases = "".join(f"{place} < {self.size[1] * (k + 1)}.0 ? {values[k]} : " for k in maps)
        return f"{vector}4({cases}{vector}3(0.0, 0.0, 0.0), 1.0)"

    def all_match(self, drawn, upside_down=False, encoded=False):
        for kind, part in zip(self.model.maps, np.split(drawn, len(self.model.maps), axis=1), strict=True):
            self.matches(part, kind, upside_down, encoded)

    def matches(self, drawn, kind, upside_down=False, encoded=False):
        expected = self.seen.blend(self.blend, kind.name, self.tile)
        if kind.encoding == "srgb" and not encoded:
            expected = decode_srgb(expected)
        expected = np.broadcast_to(expected, (*self.size, 3))
        seen = drawn[:: -1 if upside_down else 1, :, :3]
        np.testing.assert_allclose(seen, expected, atol=TOLERANCE * (kind.high - kind.low), err_msg=kind.name)


def place(vector, position, size):
    """Text of the UV at a pixel of a picture of all maps, side by side."""
    height, width = size
    column = f"({position}.x - {width}.0 * floor({position}.x / {width}.0))"
    return f"{vector}({column}, {position}.y) / {vector}({width}, {height})"


def hlsl_type(exported, kind):
    return exported.type_of(kind).replace("vec", "float")

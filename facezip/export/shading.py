"""What a blend costs on a GPU: the exported shaders of a pack's shape, beside a fetch of every expression's texture."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.fill import Fill
from facezip.export.regions import Regions
from facezip.export.shaders import GLSL, shader
from facezip.export.sheets import Sheet
from facezip.export.source import Tile
from facezip.pack.manifest import TileEntry

if TYPE_CHECKING:
    import moderngl

SLOTS = 4
# Texels of a texture's side a texel of a weight map's.
WEIGHT_SCALE = 8
CORNERS = "#version 330\nvoid main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0, 1); }"
HEAD = "#version 330\nprecision highp float;\nlayout(location = 0) out vec4 result;\n"


class Pass:
    """A program that is drawn over every pixel of a target.

    Parameters
    ----------
    program, target : what is drawn, and where.
    textures : by the names of samplers.
    """

    def __init__(
        self,
        context: "moderngl.Context",
        program: "moderngl.Program",
        target: "moderngl.Framebuffer",
        textures: Mapping[str, Any],
    ) -> None:
        self._program, self._target, self._textures = program, target, textures
        self._corners = context.vertex_array(program, [])
        self.rows = target.height

    def draw(self, first: int, last: int) -> None:
        """Draw some rows of pixels."""
        self._target.scissor = (0, first, self._target.width, last - first)
        self._target.use()
        for unit, (name, texture) in enumerate(self._textures.items()):
            texture.use(unit)
            self._program[name] = unit
        self._corners.render(vertices=3)


def tile_of(expressions: int, side: int) -> Tile:
    """A tile of one albedo of that shape, as far as shaders say it: its texels are the GPU's."""
    names = tuple(f"expression {n}" for n in range(expressions))
    columns = int(np.ceil(np.sqrt(expressions)))
    size = side // WEIGHT_SCALE
    layout = TileEntry(1001, (size, size), columns, (2.0,) * SLOTS, (-1.0,) * SLOTS, ("weights.1001.png",), ())
    sheet = Sheet(
        ((KNOWN[ALBEDO], slice(0, 3)),),
        np.zeros((1, 1, 3), np.uint8),
        np.zeros((SLOTS, 1, 1, 3), np.uint8),
        np.full((SLOTS, 3), 0.5, np.float32),
        names,
        np.zeros((expressions, 1, 1, SLOTS), np.float32),
        Fill(np.ones((1, 1), np.bool_)),
    )
    regions = Regions((), np.zeros((0, size, size), np.uint8))
    return Tile("bench", names, layout, (), (b"",), (KNOWN[ALBEDO],), (sheet,), regions)


class Shading:
    """A picture of ``side``² pixels, one texel each, drawn both ways out of random textures of 8 bits, RGBA.

    Parameters
    ----------
    context : an OpenGL device.
    expressions : N.
    side : of textures and picture; a multiple of 8.
    seed : of the texels.

    Attributes
    ----------
    maps, atlas, every : the neutral and the differences; the weight maps; the neutral and all expressions, as layers.
    weights, picture : what is drawn into.

    Raises
    ------
    FaceZipError
        ``NO_GPU`` where the device has no room for N + 1 textures, or no array of so many layers.
    """

    def __init__(self, context: "moderngl.Context", expressions: int, side: int, seed: int = 0) -> None:
        self._context, self._count, self._side = context, expressions, side
        self._tile = tile_of(expressions, side)
        self._random = np.random.default_rng(seed)
        self._made: list[Any] = []
        self._prepass, self._blend, self._textures = self._programs()
        self._allocate()
        self.show(np.zeros(expressions, np.float32))

    def _programs(self) -> list["moderngl.Program"]:
        text, count = HEAD + shader(self._tile, GLSL), self._count
        uv = f"gl_FragCoord.xy / {self._side}.0"
        maps = [f"map_{i}" for i in range(1 + SLOTS)]
        samplers = "".join(f"uniform sampler2D {name};\n" for name in (*maps, "weight_map"))
        return [
            self._program(f"""{text}
uniform sampler2D atlas;
uniform float values[{count}];
void main() {{ result = facezip_weights_0(atlas, ivec2(gl_FragCoord.xy), values); }}"""),
            self._program(f"""{text}{samplers}
void main() {{
    vec2 at = {uv};
    result = vec4(facezip_color({", ".join(maps)}, texture(weight_map, at), at, 1.0), 1.0);
}}"""),
            self._program(f"""{text}
uniform sampler2DArray all_maps;
uniform int at_work, layers[{count}];
uniform float values[{count}];
void main() {{
    vec2 at = {uv};
    vec3 neutral = texture(all_maps, vec3(at, 0.0)).rgb, sum = neutral;
    for (int k = 0; k < at_work; k++) {{
        sum += values[k] * (texture(all_maps, vec3(at, float(layers[k]))).rgb - neutral);
    }}
    result = vec4(facezip_linear(clamp(sum, 0.0, 1.0)), 1.0);
}}"""),
        ]

    def _program(self, fragment: str) -> "moderngl.Program":
        program = self._context.program(vertex_shader=CORNERS, fragment_shader=fragment)
        self._made.append(program)
        return program

    def _allocate(self) -> None:
        context, side, size = self._context, self._side, self._side // WEIGHT_SCALE
        columns = self._tile.layout.weight_columns
        self.every = self._array(self._count + 1)
        self.maps = [self._texture((side, side)) for _ in range(1 + SLOTS)]
        self.atlas = self._texture((columns * size, -(-self._count // columns) * size))
        self.weights, self.picture = context.texture((size, size), 4, dtype="f2"), context.texture((side, side), 4)
        self._made += [self.every, *self.maps, self.atlas, self.weights, self.picture]
        if context.error != "GL_NO_ERROR":
            raise FaceZipError(
                ErrorCode.NO_GPU, f"this device has no room for {self._count + 1} textures of {side}²; ask for less"
            )
        self.weights.repeat_x = self.weights.repeat_y = False
        self._targets = [context.framebuffer([one]) for one in (self.weights, self.picture)]
        self._made += self._targets

    def _array(self, count: int) -> "moderngl.TextureArray":
        """All expressions' textures as layers: more than a shader may have by name."""
        side, limit = self._side, self._context.info["GL_MAX_ARRAY_TEXTURE_LAYERS"]
        if count > limit:
            raise FaceZipError(ErrorCode.NO_GPU, f"this device has arrays of up to {limit} textures; ask for fewer")
        array = self._context.texture_array((side, side, count), 4)
        for layer in range(count):
            array.write(self._random.bytes(4 * side * side), viewport=(0, 0, layer, side, side, 1))
        array.repeat_x = array.repeat_y = False
        return array

    def _texture(self, size: tuple[int, int]) -> "moderngl.Texture":
        texture = self._context.texture(size, 4, self._random.bytes(4 * size[0] * size[1]))
        texture.repeat_x = texture.repeat_y = False
        return texture

    def show(self, weights: NDArray[np.float32]) -> None:
        """Set β, ``(N,)``; only textures of weights other than 0 are at work."""
        self._prepass["values"] = weights.tolist()
        order = np.argsort(weights == 0, kind="stable")
        self._textures["at_work"] = int(np.count_nonzero(weights))
        self._textures["layers"] = (order + 1).tolist()
        self._textures["values"] = weights[order].tolist()

    def passes(self) -> Mapping[str, Pass]:
        """By name what can be timed: the ``prepass``, the ``blend`` of six fetches, and the ``textures``."""
        weights, picture = self._targets
        units = {f"map_{i}": texture for i, texture in enumerate(self.maps)} | {"weight_map": self.weights}
        return {
            "prepass": Pass(self._context, self._prepass, weights, {"atlas": self.atlas}),
            "blend": Pass(self._context, self._blend, picture, units),
            "textures": Pass(self._context, self._textures, picture, {"all_maps": self.every}),
        }

    def release(self) -> None:
        """Give back what the device has of it."""
        # What is bound cannot be.
        self._context.simple_framebuffer((1, 1)).use()
        for made in self._made:
            made.release()

"""The text of every export is run, on the files that lie beside it, and gives what ``model.blend`` gives."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from facezip.export import TARGETS
from facezip.export.shaders import GLSL, HLSL, camel, identifier, number, shader
from facezip.export.source import read_source
from facezip.files.decoding import decode
from facezip.files.images import read_texture_exactly
from facezip.files.srgb import decode_srgb
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import KINDS, grey, layered_model
from tests.facezip.export.gains import masks_in, regions_in, turned
from tests.facezip.export.gpu import Gpu, compile_glsl, hlsl_to_glsl, software

MODELS = {
    "four slots": random_model(meshes=True),
    "one slot": random_model(slots=1, meshes=True),
    "two layers": random_model(slots=5, expressions=7, meshes=True),
    "uniform weights": random_model(weights=(1, 1), meshes=True),
    "grey": grey(random_model(meshes=True)),
    "five maps": layered_model(),
    "normals alone, two layers": layered_model(kinds=(KINDS[0], KINDS[2]), slots=5),
    "three maps, uniform weights": layered_model(kinds=(KINDS[0], KINDS[2], KINDS[3]), weights=(1, 1)),
    "masks": masked(random_model(meshes=True)),
    "nine masks, two layers, five maps": masked(layered_model(slots=5, expressions=7), 9),
    "one mask": masked(random_model(slots=1, meshes=True), 1),
}
# Of values in [0, 1], and of the components of normals.
TOLERANCE = 1e-4


@pytest.fixture(scope="module")
def gpu():
    with software() as context:
        yield Gpu(context)


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


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]


def test_glsl_gives_the_blend_of_every_map(model, gpu, tmp_path):
    exported = Exported(model, "gltf", tmp_path)
    core, textures = exported.text("facezip.glsl"), exported.textures(gpu)
    uniform = exported.weight_size == (1, 1)
    atlases = {
        f"atlas_{layer}": textures.get("masks" if exported.masks else f"weights_{layer}")
        for layer in range(exported.layers)
    }
    atlases["regions"] = textures.get("regions")
    weights = {}
    for layer in range(exported.layers):
        atlas = "" if uniform else f"atlas_{layer}, regions, "
        gains = "" if uniform else f", float[]({exported.gains_of_regions})"
        source = f"""#version 450
uniform sampler2D atlas_{layer};
uniform sampler2D regions;
uniform {exported.given_as("vec4")};
layout(location = 0) out vec4 result;
{core}
void main() {{ result = facezip_weights_{layer}({atlas}ivec2(gl_FragCoord.xy), values{gains}); }}"""
        weights[f"weights_{layer}"] = gpu.texture(gpu.draw(source, exported.weight_size, atlases, exported.given))
    names = [f"map_{name}" for name in exported.maps]
    sampled = [f"texture(map_{name}, uv)" for name in weights]
    bound = {f"map_{name}": texture for name, texture in (textures | weights).items()}
    gains_of_maps = [*map(number, exported.gains["maps"].values())]

    def draw(size, result):
        source = f"""#version 450
{"".join(f"uniform sampler2D map_{name};" for name in (*exported.maps, *weights))}
layout(location = 0) out vec4 result;
{core}
void main() {{
    vec2 uv = {place("vec2", "gl_FragCoord", exported.size)};
    {"".join(f"{exported.type_of(kind)} {out};" for kind, out in exported.outs.items())}
    facezip_surface({", ".join([*names, *sampled, "uv", *gains_of_maps, *exported.outs.values()])});
    result = {result};
}}"""
        return gpu.draw(source, size, bound)

    values = [f"vec3({out})" for out in exported.outs.values()]
    exported.all_match(draw(exported.wide, exported.shown("vec", "gl_FragCoord.x", values)))
    albedo = [f"map_{name}" for name in read_sheet(exported, "albedo")]
    arguments = ", ".join([*albedo, *sampled, "uv", gains_of_maps[0]])
    for function, encoded in (("facezip_encoded", True), ("facezip_color", False)):
        drawn = draw(exported.size, f"vec4({function}({arguments}), 1.0)")
        exported.matches(drawn, model.maps[0], encoded=encoded)


def read_sheet(exported, name):
    facts = exported.facts["maps"][name]
    return [facts["neutral"], *facts["differences"]]


def place(vector, position, size):
    """Text of the UV at a pixel of a picture of all maps, side by side."""
    height, width = size
    column = f"({position}.x - {width}.0 * floor({position}.x / {width}.0))"
    return f"{vector}({column}, {position}.y) / {vector}({width}, {height})"


def test_each_tile_has_numbers_of_its_own(gpu, tmp_path):
    model = layered_model(tiles=(1001, 1002))
    for tile in model.tiles:
        (tmp_path / str(tile)).mkdir()
        godot(Exported(model, "godot", tmp_path / str(tile), tile), gpu)


def test_godot_gives_the_blend_of_every_map(model, gpu, tmp_path):
    godot(Exported(model, "godot", tmp_path), gpu)


def godot(exported, gpu):
    textures = exported.textures(gpu)
    atlases = {f"atlas_{layer}": textures.get(f"weights_{layer}") for layer in range(exported.layers)}
    atlases |= {"region_masks": textures.get("regions"), "mask_atlas": textures.get("masks")}
    targets = {}
    for target in range(-(-exported.slots // 3)):
        source = as_glsl(exported, "weights.gdshader", exported.weight_size, "COLOR")
        source = source.replace("uniform int target = 0;", f"const int target = {target};")
        drawn = gpu.draw(source, exported.weight_size, atlases, exported.given)
        assert (drawn[..., 3] == 1).all()
        targets[f"map_weights_{target}"] = gpu.texture(drawn)
    maps = {f"map_{name}": textures[name] for name in exported.maps}
    shown = {"normal": "NORMAL", "roughness": "vec3(ROUGHNESS)", "specular": "vec3(SPECULAR)"}
    values = [{"albedo": "ALBEDO", "cavity": "vec3(CAVITY)", **shown}[kind.name] for kind in exported.model.maps]
    shown = exported.shown("vec", "gl_FragCoord.x", values)
    for compatibility in (False, True):
        source = as_glsl(exported, "head.gdshader", exported.size, shown, compatibility)
        drawn = gpu.draw(source, exported.wide, maps | targets)
        exported.all_match(drawn, encoded=compatibility)


def as_glsl(exported, file, size, result, compatibility=False):
    """Godot's language is GLSL with a few words more; the head is a flat sheet."""
    text = exported.with_gains(exported.text(file), "map_gain_", "region_gains").replace("static const", "const")
    # What the head does not show is one of its variables all the same.
    if "cavity" in exported.facts["maps"]:
        text = text.replace("    ALBEDO =", "    CAVITY = out_cavity;\n    ALBEDO =")
    text = re.sub(r"^(shader_type|render_mode).*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"(uniform sampler2D \w+) : [\w, ]+;", r"\1;", text)
    text = re.sub(r"(uniform \w+ \w+) : hint_range\([^)]*\)", r"\1", text)
    return f"""#version 450
layout(location = 0) out vec4 result;
const bool OUTPUT_IS_SRGB = {str(compatibility).lower()};
vec4 COLOR; vec3 ALBEDO; float ROUGHNESS, SPECULAR, CAVITY;
vec3 TANGENT = vec3(1, 0, 0), BINORMAL = vec3(0, 1, 0), NORMAL = vec3(0, 0, 1);
vec2 UV = {place("vec2", "gl_FragCoord", size)};
vec3 VERTEX = vec3(UV.x, 1.0 - UV.y, 0.0);
{text}
void main() {{ fragment(); result = {result}; }}"""


# What Shader Graph writes in front of an include: the type of textures, and the graph's own properties.
UNITY_GRAPH = """
struct UnityTexture2D { Texture2D tex; SamplerState samplerstate; float4 texelSize; float4 scaleTranslate; };
UnityTexture2D built(Texture2D tex, SamplerState samplerstate, float4 texelSize)
{
    UnityTexture2D made;
    made.tex = tex; made.samplerstate = samplerstate;
    made.texelSize = texelSize; made.scaleTranslate = float4(1, 1, 0, 0);
    return made;
}
"""
UNITY_PROPERTY = "Texture2D {0}; SamplerState sampler{0}; float4 {0}_TexelSize;\n"
UNITY_STUB = """float4 main(float4 position : SV_Position) : SV_Target {{ {body} }}"""


def unity_programs(exported, file):
    """The HLSL of each pass of a shader file."""
    text = exported.text(file)
    shared = "".join(re.findall(r"HLSLINCLUDE(.*?)ENDHLSL", text, re.DOTALL))
    passes = [shared + own for own in re.findall(r"HLSLPROGRAM(.*?)ENDHLSL", text, re.DOTALL)]
    assert passes
    return [re.sub(r"#pragma.*", "", text) for text in passes]


def test_unity_gives_the_blend_from_rows_that_lie_upside_down(model, gpu, tmp_path):
    exported = Exported(model, "unity", tmp_path)
    textures = exported.textures(gpu, upside_down=True)
    bound = {f"_FaceZip{camel(name)}": texture for name, texture in textures.items()}
    regions = {"_FaceZipRegions": textures.get("regions")}
    for layer, program in enumerate(unity_programs(exported, "FaceZipWeights.shader")):
        functions, call = re.search(r"(.*)float4 frag.*(return .*?;)", program, re.DOTALL).groups()
        text = functions.replace('#include "UnityCG.cginc"', "")
        body = f"int2 texel = int2(position.xy); {call}"
        text = exported.with_gains(text, "_FaceZipGain_", "_FaceZipRegionGains")
        source = hlsl_to_glsl(text + UNITY_STUB.format(body=body), tmp_path)
        atlas = {"_MainTex": textures.get("masks" if exported.masks else f"weights_{layer}")}
        drawn = gpu.draw(source, exported.weight_size, atlas | regions, exported.given)
        bound[f"_FaceZipWeights{layer}"] = gpu.texture(drawn)
    for keyword in ("", "#define UNITY_COLORSPACE_GAMMA\n"):
        source = hlsl_to_glsl(keyword + unity_graph(exported), tmp_path)
        drawn = gpu.draw(source, exported.wide, bound, exported.beta)
        exported.all_match(drawn, upside_down=True, encoded=bool(keyword))


def unity_graph(exported):
    """A shader as Shader Graph makes it of GUIDE.md: the include behind the declarations of its own properties."""
    names = [*map(camel, exported.maps), *(f"Weights{layer}" for layer in range(exported.layers))]
    properties = [f"_FaceZip{name}" for name in names]
    declared = UNITY_GRAPH + "".join(UNITY_PROPERTY.format(name) for name in properties)
    outs = exported.outs.values()
    variables = "".join(f"{hlsl_type(exported, kind)} {out};" for kind, out in exported.outs.items())
    textures = [f"built({name}, sampler{name}, {name}_TexelSize)" for name in properties]
    gains = [f"_FaceZipGain_{kind.name}" for kind in exported.model.maps]
    arguments = ", ".join([place("float2", "position", exported.size), *textures, *gains, *outs])
    shown = exported.shown("float", "position.x", [f"(float3){out}" for out in outs])
    body = f"{variables} FaceZip_float({arguments}); return {shown};"
    declared += "".join(f"float {name};\n" for name in gains)
    text = declared + exported.text("FaceZip.hlsl") + UNITY_STUB.format(body=body)
    return exported.with_gains(text, "_FaceZipGain_", "_FaceZipRegionGains")


def test_unity_s_guide_names_the_inputs_of_the_node_in_their_order(model, tmp_path):
    exported = Exported(model, "unity", tmp_path)
    signature = re.search(r"void FaceZip_float\((.*)\)", exported.text("FaceZip.hlsl")).group(1)
    inputs = re.findall(r"UnityTexture2D (\w+)", signature)
    named = exported.text("GUIDE.md").split("as Texture 2D: ")[1].split(".\n")[0]
    assert re.findall(r"`(\w+)`", named) == inputs
    gains = exported.text("GUIDE.md").split("as Float: ")[1].split(".\n")[0]
    assert re.findall(r"`(Gain\w+)`", gains) == re.findall(r" float (Gain\w+)", signature)
    outputs = exported.text("GUIDE.md").split("Outputs: ")[1].split(".\n")[0]
    assert re.findall(r"`(\w+)`", outputs) == re.findall(r"out \w+ (\w+)", signature)


def hlsl_type(exported, kind):
    return exported.type_of(kind).replace("vec", "float")


def test_unreal_gives_the_blend_of_every_map(model, gpu, tmp_path):
    exported = Exported(model, "unreal", tmp_path)
    textures = {camel(name): texture for name, texture in exported.textures(gpu).items()}
    declared = "#define Texture2DSample(t, s, uv) t.Sample(s, uv)\n"
    betas = "".join(f"#define B{n} (2.0 * values[{n}])\n#define G{n} 0.5\n" for n in range(len(exported.beta)))
    betas += "".join(f"#define R{k} {number(gain)}\n" for k, gain in enumerate(exported.gains["regions"].values()))
    betas += "".join(f"#define Gain{camel(name)} {number(gain)}\n" for name, gain in exported.gains["maps"].items())
    declared += f"float values[{len(exported.beta)}];\n{betas}"
    targets, names = {}, ["Regions", *(f"Weights{layer}" for layer in range(exported.layers))]
    if exported.masks:
        names = ["Regions", "Masks", "Activations"]
        textures["Activations"] = unreal_activations(exported, gpu, declared, tmp_path)
    for number_ in range(-(-exported.slots // 3)):
        source = node(declared, exported.text(f"weights_{number_}_node.hlsl"), names, exported.weight_size)
        drawn = gpu.draw(hlsl_to_glsl(source, tmp_path), exported.weight_size, textures, exported.beta)
        assert (drawn[..., :3] >= 0).all()
        targets[f"Weights{number_}"] = gpu.texture(drawn)
    bound = {camel(name): textures[camel(name)] for name in exported.maps} | targets
    # The engine's normals have y down.
    outs = {kind: f"Out{camel(kind.name)}" for kind in model.maps[1:]}
    declared += "".join(f"static {hlsl_type(exported, kind)} {out};\n" for kind, out in outs.items())
    values = ["value", *(f"{out} * float3(1, -1, 1)" if kind.is_normal else out for kind, out in outs.items())]
    shown = exported.shown("float", "position.x", [f"(float3)({value})" for value in values])
    source = node(declared, exported.text("head_node.hlsl"), bound, exported.size, shown)
    exported.all_match(gpu.draw(hlsl_to_glsl(source, tmp_path), exported.wide, bound, exported.beta))


def unreal_activations(exported, gpu, declared, folder):
    """The texture of a blend's activations: what the first of the materials draws."""
    stored = {"Activations": gpu.texture(decode(exported.folder / "activations.exr"))}
    size = -(-exported.slots // 3), exported.masks["vectors"] // exported.layers
    source = node(declared, exported.text("activations_node.hlsl"), stored, size)
    drawn = gpu.draw(hlsl_to_glsl(source, folder), size, stored, exported.beta)
    assert (drawn[..., :3] >= 0).all()
    return gpu.texture(drawn)


def node(declared, text, textures, size, shown="float4(value, 1)"):
    """A Custom node is the body of a function whose parameters are its inputs, and what else it gives its outputs."""
    # Unreal's compilers take functions in a structure within a function; glslang does not, it gets them bare.
    structure = re.compile(r"struct FaceZip\n{\n(.*?)\n};\n", re.DOTALL)
    functions, text = "".join(structure.findall(text)), structure.sub("", text)
    text = text.replace("FaceZip face;", "").replace("face.facezip", "facezip")
    maps = "".join(f"Texture2D {name};\nSamplerState {name}Sampler;\n" for name in textures)
    return f"""{declared}{maps}{functions}
float3 custom(float2 UV) {{ {text} }}
float4 main(float4 position : SV_Position) : SV_Target
{{ float3 value = custom({place("float2", "position", size)}); return {shown}; }}"""


UNITY_CG = """
#define UNITY_MATRIX_VP 1
struct v2f_img { float4 pos : SV_POSITION; float2 uv : TEXCOORD0; };
struct appdata_base { float4 vertex : POSITION; float3 normal : NORMAL; float4 texcoord : TEXCOORD0; };
struct appdata_tan { float4 vertex : POSITION; float3 normal : NORMAL; float4 tangent : TANGENT; float4 texcoord : T; };
float4 unity_WorldTransformParams;
float4 UnityObjectToClipPos(float4 position) { return position; }
float3 UnityObjectToWorldDir(float3 direction) { return direction; }
float3 WorldSpaceViewDir(float4 position) { return position.xyz; }
float3 UnityObjectToWorldNormal(float3 normal) { return normal; }
"""


def test_unity_s_shaders_compile(model, tmp_path):
    exported = Exported(model, "unity", tmp_path)
    (tmp_path / "UnityCG.cginc").write_text(UNITY_CG)
    for file in ("FaceZipWeights.shader", "FaceZipHead.shader"):
        for program in unity_programs(exported, file):
            text = program.replace("float4 frag(", "float4 main(")
            hlsl_to_glsl("#extension GL_GOOGLE_include_directive : enable\n" + text, tmp_path, tmp_path)


def test_every_dialect_says_the_same(model, tmp_path):
    """One template: but for the words of the language, the text is the same."""
    write_pack(model, tmp_path / "me.facezip")
    (tile,) = read_source(tmp_path / "me.facezip").tiles
    glsl, hlsl = shader(tile, GLSL), shader(tile, HLSL)
    hlsl = hlsl.replace("SamplerState clamped, ", "").replace(", clamped, uv", ", uv").replace("Texture2D", "sampler2D")
    hlsl = re.sub(r"(\w+)\.Sample\(clamped, uv\)", r"texture(\1, uv)", hlsl)
    hlsl = re.sub(r"(weights|masks)\.Load\(int3\((.*), 0\)\)", r"texelFetch(\1, \2, 0)", hlsl)
    hlsl = re.sub(r"\bfloat(\d)", r"vec\1", re.sub(r"\bint2", "ivec2", hlsl))
    assert glsl == hlsl


def test_glsl_compiles_for_phones(model, tmp_path):
    exported = Exported(model, "gltf", tmp_path)
    head = "#version 300 es\nprecision highp float;\nprecision highp int;\nout vec4 result;\n"
    compile_glsl(head + exported.text("facezip.glsl") + "void main() { result = vec4(0.0); }", tmp_path)


@pytest.mark.parametrize("value", [0, 1, -1, 1e-9, 123456789, 0.1])
def test_numbers_are_floats_in_every_language(value):
    assert float(number(value)) == pytest.approx(value)
    assert "." in number(value) or "e" in number(value)


@pytest.mark.parametrize("name", ['"; rm -rf /', "</script>", "Größe", "", "9 lives", "a\u2028b"])
def test_identifiers_are_made_of_letters_and_digits(name):
    assert re.fullmatch(r"\w+", identifier(name), re.ASCII)

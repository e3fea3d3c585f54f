"""The text of every export is run, on the files that lie beside it, and gives what ``model.blend`` gives."""

import json
import re

import numpy as np
import pytest

from facezip import read_pack, write_pack
from facezip.export import TARGETS
from facezip.export.shaders import GLSL, HLSL, identifier, number, shader
from facezip.manifest import read_manifest
from facezip.textures import decode_srgb, read_texture_exactly
from tests.facezip.conftest import random_model
from tests.facezip.export.conftest import grey
from tests.facezip.export.gpu import Gpu, compile_glsl, hlsl_to_glsl

MODELS = {
    "four slots": random_model(meshes=True),
    "one slot": random_model(slots=1, meshes=True),
    "two layers": random_model(slots=5, expressions=7, meshes=True),
    "uniform weights": random_model(weights=(1, 1), meshes=True),
    "grey": grey(random_model(meshes=True)),
}
# Of values in [0, 1].
TOLERANCE = 1e-4


@pytest.fixture(scope="module")
def gpu():
    gpu = Gpu()
    yield gpu
    gpu.close()


class Exported:
    """An export, its textures in memory as its engine keeps them, and a blend to compare with."""

    def __init__(self, model, target, folder):
        write_pack(model, folder / "me.facezip")
        self.folder, self.model = folder / target, read_pack(folder / "me.facezip")
        TARGETS[target](folder / "me.facezip", self.folder)
        self.facts = json.loads((self.folder / "facezip.json").read_text())
        self.beta = np.random.default_rng(1).uniform(0, 1, len(self.model.expressions)).astype(np.float32)
        blend = dict(zip(self.model.expressions, map(float, self.beta), strict=True))
        self.encoded = self.model.blend(blend)
        self.size, self.weight_size = self.model.neutral.shape[:2], self.model.weights.shape[1:3]
        self.layers = -(-self.model.weights.shape[3] // 4)

    def text(self, file):
        return (self.folder / file).read_text(encoding="utf-8")

    def textures(self, gpu, upside_down=False):
        turn = -1 if upside_down else 1
        entries = self.facts["textures"].items()
        read = {name: read_texture_exactly(self.folder / entry["file"]) for name, entry in entries}
        return {name: gpu.texture(texels[::turn]) for name, texels in read.items()}

    def matches(self, drawn, linear, upside_down=False):
        expected = decode_srgb(self.encoded) if linear else self.encoded
        expected = np.broadcast_to(expected, (*self.size, 3))
        np.testing.assert_allclose(drawn[:: -1 if upside_down else 1, :, :3], expected, atol=TOLERANCE)


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]


def maps_of(exported):
    return ["neutral", *(f"difference_{i}" for i in range(len(exported.model.differences)))]


def test_glsl_gives_the_blend(model, gpu, tmp_path):
    exported = Exported(model, "gltf", tmp_path)
    core, textures, count = exported.text("facezip.glsl"), exported.textures(gpu), len(exported.beta)
    uniform = exported.weight_size == (1, 1)
    atlases = {f"atlas_{layer}": textures.get(f"weights_{layer}") for layer in range(exported.layers)}
    weights = {}
    for layer in range(exported.layers):
        atlas = "" if uniform else f"atlas_{layer}, "
        source = f"""#version 450
uniform sampler2D atlas_{layer};
uniform float values[{count}];
layout(location = 0) out vec4 result;
{core}
void main() {{ result = facezip_weights_{layer}({atlas}ivec2(gl_FragCoord.xy), values); }}"""
        weights[f"weights_{layer}"] = gpu.texture(gpu.draw(source, exported.weight_size, atlases, exported.beta))
    names = [f"map_{name}" for name in maps_of(exported)]
    sampled = [f"texture(map_{name}, uv)" for name in weights]
    source = f"""#version 450
{"".join(f"uniform sampler2D map_{name};" for name in (*maps_of(exported), *weights))}
layout(location = 0) out vec4 result;
{core}
void main() {{
    vec2 uv = gl_FragCoord.xy / vec2({exported.size[1]}, {exported.size[0]});
    result = vec4(facezip_encoded({", ".join([*names, *sampled])}, uv), 1.0);
}}"""
    bound = {f"map_{name}": texture for name, texture in (textures | weights).items()}
    exported.matches(gpu.draw(source, exported.size, bound), linear=False)
    exported.matches(gpu.draw(source.replace("facezip_encoded(map", "facezip_color(map"), exported.size, bound), True)


def test_godot_gives_the_blend(model, gpu, tmp_path):
    exported = Exported(model, "godot", tmp_path)
    textures = exported.textures(gpu)
    atlases = {f"atlas_{layer}": textures.get(f"weights_{layer}") for layer in range(exported.layers)}
    targets = {}
    for target in range(-(-exported.model.weights.shape[3] // 3)):
        source = as_glsl(exported.text("weights.gdshader"), exported.weight_size, "COLOR")
        source = source.replace("uniform int target = 0;", f"const int target = {target};")
        drawn = gpu.draw(source, exported.weight_size, atlases, exported.beta)
        assert (drawn[..., 3] == 1).all()
        targets[f"map_weights_{target}"] = gpu.texture(drawn)
    source = as_glsl(exported.text("head.gdshader"), exported.size, "vec4(ALBEDO, ROUGHNESS)")
    maps = {f"map_{name}": textures[name] for name in maps_of(exported)}
    exported.matches(gpu.draw(source, exported.size, maps | targets), linear=True)


def as_glsl(text, size, result):
    """Godot's language is GLSL with a few words more."""
    text = re.sub(r"^(shader_type|render_mode).*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"(uniform sampler2D \w+) : [\w, ]+;", r"\1;", text)
    text = re.sub(r"(uniform \w+ \w+) : hint_range\([^)]*\)", r"\1", text)
    return f"""#version 450
layout(location = 0) out vec4 result;
vec4 COLOR; vec3 ALBEDO; float ROUGHNESS;
vec2 UV = gl_FragCoord.xy / vec2({size[1]}, {size[0]});
{text}
void main() {{ fragment(); result = {result}; }}"""


UNITY_STUB = """float4 main(float4 position : SV_Position) : SV_Target {{ {body} }}"""


def test_unity_gives_the_blend_from_rows_that_lie_upside_down(model, gpu, tmp_path):
    exported = Exported(model, "unity", tmp_path)
    include, textures = exported.text("FaceZip.hlsl"), exported.textures(gpu, upside_down=True)
    bound = {f"_FaceZip{name.title().replace('_', '')}": texture for name, texture in textures.items()}
    for layer in range(exported.layers):
        call = re.search(rf"return (facezip_weights_{layer}\(.*\);)", exported.text("FaceZipWeights.shader")).group(1)
        body = f"int2 texel = int2(position.xy); return {call}"
        source = hlsl_to_glsl(f"{include}\nTexture2D _MainTex;\n" + UNITY_STUB.format(body=body), tmp_path)
        drawn = gpu.draw(source, exported.weight_size, {"_MainTex": textures.get(f"weights_{layer}")}, exported.beta)
        bound[f"_FaceZipWeights{layer}"] = gpu.texture(drawn)
    height, width = exported.size
    body = f"float3 color; FaceZip_float(position.xy / float2({width}, {height}), color); return float4(color, 1);"
    for keyword, linear in (("", True), ("#define UNITY_COLORSPACE_GAMMA\n", False)):
        source = hlsl_to_glsl(keyword + include + UNITY_STUB.format(body=body), tmp_path)
        exported.matches(gpu.draw(source, exported.size, bound, exported.beta), linear, upside_down=True)


def test_unreal_gives_the_blend(model, gpu, tmp_path):
    exported = Exported(model, "unreal", tmp_path)
    textures = {name.title().replace("_", ""): texture for name, texture in exported.textures(gpu).items()}
    declared = "#define Texture2DSample(t, s, uv) t.Sample(s, uv)\n"
    betas = "".join(f"#define B{n} values[{n}]\n" for n in range(len(exported.beta)))
    declared += f"float values[{len(exported.beta)}];\n{betas}"
    targets = {}
    for number_ in range(-(-exported.model.weights.shape[3] // 3)):
        names = [f"Weights{layer}" for layer in range(exported.layers)]
        source = node(declared, exported.text(f"weights_{number_}_node.hlsl"), names, exported.weight_size)
        drawn = gpu.draw(hlsl_to_glsl(source, tmp_path), exported.weight_size, textures, exported.beta)
        assert (drawn[..., :3] >= 0).all()
        targets[f"Weights{number_}"] = gpu.texture(drawn)
    bound = {name: texture for name, texture in textures.items() if not name.startswith("Weights")} | targets
    source = node(declared, exported.text("head_node.hlsl"), bound, exported.size)
    exported.matches(gpu.draw(hlsl_to_glsl(source, tmp_path), exported.size, bound, exported.beta), linear=True)


def node(declared, text, textures, size):
    """A Custom node is the body of a function whose parameters are its inputs."""
    # Unreal's compilers take functions in a structure within a function; glslang does not, it gets them bare.
    structure = re.search(r"struct FaceZip\n{\n(.*?)\n};\n", text, re.DOTALL)
    text = text.replace(structure.group(), "").replace("FaceZip face;", "").replace("face.facezip", "facezip")
    maps = "".join(f"Texture2D {name};\nSamplerState {name}Sampler;\n" for name in textures)
    return f"""{declared}{maps}{structure.group(1)}
float3 custom(float2 UV) {{ {text} }}
float4 main(float4 position : SV_Position) : SV_Target
{{ return float4(custom(position.xy / float2({size[1]}, {size[0]})), 1); }}"""


UNITY_CG = """
#define UNITY_MATRIX_VP 1
struct v2f_img { float4 pos : SV_POSITION; float2 uv : TEXCOORD0; };
struct appdata_base { float4 vertex : POSITION; float3 normal : NORMAL; float4 texcoord : TEXCOORD0; };
float4 UnityObjectToClipPos(float4 position) { return position; }
float3 UnityObjectToWorldNormal(float3 normal) { return normal; }
"""


def test_unity_s_shaders_compile(model, tmp_path):
    exported = Exported(model, "unity", tmp_path)
    (tmp_path / "UnityCG.cginc").write_text(UNITY_CG)
    for file in ("FaceZipWeights.shader", "FaceZipHead.shader"):
        programs = re.findall(r"HLSLPROGRAM(.*?)ENDHLSL", exported.text(file), re.DOTALL)
        assert programs
        for program in programs:
            text = re.sub(r"#pragma.*", "", program).replace("float4 frag(", "float4 main(")
            hlsl_to_glsl(
                "#extension GL_GOOGLE_include_directive : enable\n" + text, tmp_path, tmp_path, exported.folder
            )


def test_every_dialect_says_the_same(tmp_path):
    """One template: but for the words of the language, the text is the same."""
    write_pack(MODELS["two layers"], tmp_path / "me.facezip")
    manifest = read_manifest(tmp_path / "me.facezip")
    glsl, hlsl = shader(manifest, GLSL), shader(manifest, HLSL)
    hlsl = hlsl.replace("SamplerState clamped, ", "").replace(", clamped, uv", ", uv").replace("Texture2D", "sampler2D")
    hlsl = re.sub(r"(\w+)\.Sample\(clamped, uv\)", r"texture(\1, uv)", hlsl)
    hlsl = re.sub(r"weights\.Load\(int3\((.*), 0\)\)", r"texelFetch(weights, \1, 0)", hlsl)
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

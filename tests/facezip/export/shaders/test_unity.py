"""The shaders of the export to Unity are run, and give what ``model.blend`` gives."""

import re

from facezip.export.shaders import camel
from tests.facezip.export.gpu import hlsl_to_glsl
from tests.facezip.export.shaders.exported import Exported, hlsl_type, place

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

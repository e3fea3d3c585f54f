"""The nodes of the export to Unreal are run, and give what ``model.blend`` gives."""

import re

from facezip.export.shaders import camel, number
from facezip.files.decoding import decode
from tests.facezip.export.gpu import hlsl_to_glsl
from tests.facezip.export.shaders.exported import Exported, hlsl_type, place


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

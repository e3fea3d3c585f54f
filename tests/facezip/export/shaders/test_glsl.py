"""The text of the export to glTF is run, and gives what ``model.blend`` gives."""

from facezip.export.shaders import number
from tests.facezip.export.gpu import compile_glsl
from tests.facezip.export.shaders.exported import Exported, place


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


def test_glsl_compiles_for_phones(model, tmp_path):
    exported = Exported(model, "gltf", tmp_path)
    head = "#version 300 es\nprecision highp float;\nprecision highp int;\nout vec4 result;\n"
    compile_glsl(head + exported.text("facezip.glsl") + "void main() { result = vec4(0.0); }", tmp_path)

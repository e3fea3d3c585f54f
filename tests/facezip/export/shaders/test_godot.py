"""The shaders of the export to Godot are run, and give what ``model.blend`` gives."""

import re

from tests.facezip.export.conftest import layered_model
from tests.facezip.export.shaders.exported import Exported, place


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

"""What runs in Blender here has in common: heads built by their scripts, posed, and rendered in Cycles."""

import json
import runpy

import bpy


def build(folder, from_editor=False):
    """The head of an export in an empty scene, by the text editor's Run Script or as ``--python`` runs a file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    script = str(folder / "build_head.py")
    if from_editor:
        with bpy.context.temp_override(edit_text=bpy.data.texts.load(script)):
            bpy.ops.text.run_script()
    else:
        runpy.run_path(script, run_name="__main__")
    return next(thing for thing in bpy.data.objects if thing.type == "MESH")


def pose(head, weights, gains=None):
    for key in head.data.shape_keys.key_blocks[1:]:
        key.value = 0.0
    # Names as they are in the file, of which Blender may have kept the beginning only.
    names = json.loads(head["names"])
    for name, value in weights.items():
        head.data.shape_keys.key_blocks[1 + names.index(name)].value = value
    for name in [name for name in [*head.keys()] if name.startswith("gains.")]:
        head[name] = (gains or {}).get(name, 1.0)
    head.update_tag()
    bpy.context.view_layer.update()


def use_cycles(samples=1):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", samples, False
    scene.cycles.use_adaptive_sampling, scene.cycles.max_bounces = False, 0
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"


def render(file):
    bpy.context.scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)

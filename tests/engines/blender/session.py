"""Runs in Blender's own Python: builds exported heads with their scripts and renders what their node groups give.

    python session.py REQUEST.json

Each case of the request names a folder, poses, and where pictures go; ``answers.json`` beside them has the rest.
"""

import json
import sys
from pathlib import Path

import bpy
import numpy as np
from scene import build, pose, render, use_cycles

REQUEST = Path(sys.argv[1])


def show(material, name, span):
    """Let a material send out what a map's group gives, from 0 to 1 of its range."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    low, high = span
    value, light = nodes[f"FaceZip {name}"].outputs[0], nodes.new("ShaderNodeEmission")
    scaled = nodes.new("ShaderNodeVectorMath")
    scaled.operation = "MULTIPLY_ADD"
    links.new(value, scaled.inputs[0])
    scaled.inputs[1].default_value = [1 / (high - low)] * 3
    scaled.inputs[2].default_value = [-low / (high - low)] * 3
    links.new(scaled.outputs[0], light.inputs["Color"])
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    links.new(light.outputs[0], output.inputs["Surface"])


def texels(size, uv_map):
    """A sheet with a square for every texel, which has the UV of its centre everywhere: (0, 0) to (width, height)."""
    height, width = size
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(width), np.arange(height)))
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    vertices = np.zeros((len(x) * 4, 3), np.float32)
    vertices[:, :2] = (np.stack([x, y], 1)[:, None] + corners).reshape(-1, 2)
    mesh = bpy.data.meshes.new("texels")
    mesh.from_pydata(vertices, [], np.arange(len(vertices)).reshape(-1, 4).tolist())
    centres = (np.stack([x, y], 1) + 0.5) / [width, height]
    layer = mesh.uv_layers.new(name=uv_map)
    layer.uv.foreach_set("vector", np.repeat(centres, 4, axis=0).astype(np.float32).ravel())
    sheet = bpy.data.objects.new("texels", mesh)
    bpy.context.scene.collection.objects.link(sheet)
    return sheet


def camera(size):
    """It sees the sheet pixel by pixel."""
    height, width = size
    data = bpy.data.cameras.new("camera")
    data.type, data.ortho_scale = "ORTHO", max(size)
    thing = bpy.data.objects.new("camera", data)
    thing.location = width / 2, height / 2, 1
    scene = bpy.context.scene
    scene.collection.objects.link(thing)
    scene.camera = thing
    scene.render.resolution_x, scene.render.resolution_y = width, height


def materials(head):
    """By their tile."""
    return {str(slot.material.get("tile", 1001)): slot.material for slot in head.material_slots}


def pictures(case, head):
    """Every map of every tile in every pose at the centres of its texels."""
    use_cycles()
    sheet = texels(case["size"], head.data.uv_layers[0].name)
    camera(case["size"])
    head.hide_render = True
    for tile, material in materials(head).items():
        sheet.data.materials.clear()
        sheet.data.materials.append(material)
        for name, span in case["maps"].items():
            show(material, name, span)
            for number, (weights, gains) in enumerate(case["poses"]):
                pose(head, weights, gains)
                render(Path(case["output"]) / f"{tile}.{name}.{number}.exr")


def baked(case, head):
    """The albedo of a pose on the head itself, as Blender bakes it."""
    use_cycles()
    material = head.material_slots[0].material
    show(material, "albedo", (0, 1))
    height, width = case["size"]
    image = bpy.data.images.new("baked", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
    bpy.context.view_layer.objects.active = head
    head.hide_render = False
    head.select_set(True)
    for number, (weights, gains) in enumerate(case["poses"]):
        pose(head, weights, gains)
        bpy.ops.object.bake(type="EMIT", margin=0, use_clear=True)
        values = np.empty(height * width * 4, np.float32)
        image.pixels.foreach_get(values)
        np.save(Path(case["output"]) / f"baked.{number}.npy", values.reshape(height, width, 4)[::-1])


def facts(head):
    """What the head is like as Blender has it."""
    keys = head.data.shape_keys.key_blocks
    view = bpy.context.scene.view_settings
    basis = np.array([point.co for point in keys[0].data])
    return {
        "keys": [key.name for key in keys],
        "sliders": sorted({(key.slider_min, key.slider_max) for key in keys[1:]}),
        "view": [view.view_transform, view.look, view.exposure, view.gamma],
        "gains": {name: head[name] for name in [*head.keys()] if name.startswith("gains.")},
        "images": {image.name: [image.colorspace_settings.name, image.alpha_mode] for image in bpy.data.images},
        "broken": [curve.data_path for material in materials(head).values()
                   for curve in material.node_tree.animation_data.drivers if not curve.driver.is_valid],
        "vertices": basis.tolist(),
        "deltas": [(np.array([point.co for point in key.data]) - basis).tolist() for key in keys[1:]],
    }  # fmt: skip


def reopened(case, head):
    """What the node of weights is given after saving and loading with scripts off."""
    file = Path(case["output"]) / "head.blend"
    bpy.context.preferences.filepaths.use_scripts_auto_execute = False
    name = head.name
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    bpy.ops.wm.open_mainfile(filepath=str(file), use_scripts=False)
    head = bpy.data.objects[name]
    found = []
    for weights, gains in case["poses"]:
        pose(head, weights, gains)
        material = head.material_slots[0].material.evaluated_get(bpy.context.evaluated_depsgraph_get())
        inputs = material.node_tree.nodes["FaceZip weights"].inputs
        found.append([socket.default_value for socket in list(inputs)[1:]])
    return found


def main():
    request = json.loads(REQUEST.read_text(encoding="utf-8"))
    answers = {"version": bpy.app.version_string, "cases": {}}
    for case in request["cases"]:
        head = build(Path(case["folder"]), case["from_editor"])
        head["names"] = json.dumps(case["names"])
        answer = facts(head)
        for job in case["jobs"]:
            answer[job] = globals()[job](case, head)
        answers["cases"][case["name"]] = answer
    REQUEST.with_name("answers.json").write_text(json.dumps(answers), encoding="utf-8")


main()

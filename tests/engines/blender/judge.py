"""Runs in Blender's own Python: renders a head with the textures of a pack and with those of its originals, in Cycles.

    python judge.py REQUEST.json

Both are the same scene, nodes and random numbers: for the originals the images of the neutrals are exchanged, and the
gains of all maps are zero.
"""

import json
import sys
from math import radians
from pathlib import Path

import bpy
from mathutils import Matrix, Vector
from scene import build, pose, render, use_cycles

# glTF has y up, Blender z.
UPRIGHT = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def facing(origin, target):
    """Where a thing of Blender's is that looks from one point at another, both as in glTF."""
    origin, target = Vector(origin), Vector(target)
    back = (origin - target).normalized()
    right = Vector((0, 1, 0)).cross(back).normalized()
    axes = Matrix((right, back.cross(right), back)).transposed()
    return UPRIGHT @ Matrix.Translation(origin) @ axes.to_4x4()


def add_camera(facts, resolution):
    data = bpy.data.cameras.new("camera")
    data.angle = radians(facts["field_of_view"])
    camera = bpy.data.objects.new("camera", data)
    camera.matrix_world = facing(facts["origin"], facts["target"])
    distance = (Vector(facts["origin"]) - Vector(facts["target"])).length
    data.clip_start, data.clip_end = 0.01 * distance, 10 * distance
    scene = bpy.context.scene
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = resolution


def add_light(facts):
    """A square that shines to its front alone, as Mitsuba's do, and that the camera does not see."""
    mesh = bpy.data.meshes.new("light")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    light = bpy.data.objects.new("light", mesh)
    light.matrix_world = UPRIGHT @ Matrix(facts["to_world"])
    light.visible_camera = False
    material = bpy.data.materials.new("light")
    if not material.use_nodes:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shine, side = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeNewGeometry")
    mix, surface = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeOutputMaterial")
    shine.inputs["Color"].default_value = (*facts["radiance"], 1)
    links.new(side.outputs["Backfacing"], mix.inputs[0])
    links.new(shine.outputs[0], mix.inputs[1])
    links.new(mix.outputs[0], surface.inputs[0])
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(light)


def exchange(images, files):
    """Let images of the export, by their names, be read from other files."""
    for name, file in files.items():
        images[name].filepath = file
        images[name].reload()


def staged(request, add):
    """The head of a request before its camera, in its lights, of which ``add`` makes one from its facts."""
    head = build(Path(request["folder"]))
    head["names"] = json.dumps(request["names"])
    add_camera(request["camera"], request["resolution"])
    for facts in request["lights"]:
        add(facts)
    use_cycles(request["samples"])
    bpy.context.scene.render.film_transparent = True
    return head


def main():
    request = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    head = staged(request, add_light)
    images = {Path(image.filepath).name: image for image in bpy.data.images}
    own = {name: image.filepath for name, image in images.items()}
    silent = {name: 0.0 for name in [*head.keys()] if name.startswith("gains.maps.")}
    for shot in request["shots"]:
        bpy.context.scene.cycles.seed = shot["seed"]
        pose(head, shot["weights"])
        render(shot["pack"])
        pose(head, shot["weights"], silent)
        exchange(images, shot["originals"])
        render(shot["original"])
        exchange(images, own)
    Path(sys.argv[1]).with_name("answers.json").write_text(json.dumps({"version": bpy.app.version_string}))


if __name__ == "__main__":
    main()

"""Runs in Blender's own Python: one render of an exported head with a pose, in Cycles.

python portrait.py REQUEST.json
"""

import json
import sys
from math import pi
from pathlib import Path

import bpy
from judge import facing, staged
from scene import pose, render


def add_sun(facts):
    """A light as far away as the sun, without shadows; ``energy`` is what white reflects of it, face on."""
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.color, data.use_shadow = pi * facts["energy"], facts["colour"], False
    sun = bpy.data.objects.new("sun", data)
    sun.matrix_world = facing(facts["from"], (0, 0, 0))
    bpy.context.scene.collection.objects.link(sun)


def main():
    request = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    head = staged(request, add_sun)
    pose(head, request["weights"])
    render(request["picture"])
    Path(sys.argv[1]).with_name("answers.json").write_text(json.dumps({"version": bpy.app.version_string}))


if __name__ == "__main__":
    main()

"""Runs in Blender's own Python: one render of an exported head with a pose, in Cycles.

python portrait.py REQUEST.json
"""

import json
import sys
from pathlib import Path

import bpy
from judge import add_camera, add_light
from scene import build, pose, render, use_cycles


def main():
    request = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    head = build(Path(request["folder"]))
    head["names"] = json.dumps(request["names"])
    add_camera(request["camera"], request["resolution"])
    for facts in request["lights"]:
        add_light(facts)
    use_cycles(request["samples"])
    bpy.context.scene.render.film_transparent = True
    pose(head, request["weights"])
    render(request["picture"])
    Path(sys.argv[1]).with_name("answers.json").write_text(json.dumps({"version": bpy.app.version_string}))


if __name__ == "__main__":
    main()

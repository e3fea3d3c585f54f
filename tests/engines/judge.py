"""The second judge: the verdict's shots of a demo once more, in Blender's Cycles, beside Mitsuba's.

    python -m tests.engines.judge DEMO [VIEW LIGHT]

DEMO is what ``facezip demo`` wrote. The pack is shown by what ``facezip export --to blender`` makes of it, the original
by the same nodes with the scans' own textures. Expression, camera, lights and measures are the report's.
"""

import json
import sys
from collections import Counter
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

import numpy as np

from facezip.character.loading import load_character
from facezip.character.units import in_metres
from facezip.export import TARGETS
from render.exr import read_exr
from render.limits import DECIDING, DEFAULT_THRESHOLDS
from render.llvm import start
from render.metrics import Picture, compare, display, head_crop
from scenes.cameras import FIELD_OF_VIEW, View, frame_of, placement
from scenes.lights import RIGS
from tests.engines import cycles

SAMPLES = 16
SHOWN = ("image_rmse", "flip")


def camera(view, frame):
    origin, target = placement(view, frame)
    return {"origin": origin.tolist(), "target": target.tolist(), "field_of_view": FIELD_OF_VIEW}


def lights(rig, frame):
    """The squares of a rig: corners to the scene, and radiance."""
    start()
    return [
        {
            "to_world": np.array(light["to_world"].matrix, np.float64).reshape(4, 4).tolist(),
            "radiance": light["emitter"]["radiance"]["value"],
        }
        for light in RIGS[rig](frame).values()
    ]


def originals(folder, maps, expression):
    """The scans' textures of an expression, by what the export calls their neutrals."""
    names = {name: "neutral" if name == "albedo" else f"{name}_neutral" for name in maps}
    files = {
        f"{file}.png": folder / f"{expression}{'' if name == 'albedo' else f'.{name}'}.png"
        for name, file in names.items()
    }
    return {name: str(file.resolve()) for name, file in files.items()}


def shots(demo, folder, expressions, maps):
    """What to render: every expression, and the first once more with other random numbers."""
    for number, name in enumerate((*expressions, expressions[0])):
        yield {
            "expression": name,
            "weights": {} if name == "neutral" else {name: 1.0},
            "originals": originals(demo / "character", maps, name),
            "seed": int(number == len(expressions)),
            "pack": str(folder / f"{number}.pack.exr"),
            "original": str(folder / f"{number}.original.exr"),
        }


def pictures(*images):
    """Linear images ``(H, W, 4)`` as measures take them, by the coverage of the first."""
    head = images[0][..., 3] >= 0.5
    crop = head_crop(images[0][..., 3])
    return [Picture(display(image[..., :3])[crop], head[crop]) for image in images]


def judged(demo, view_name, light, samples=SAMPLES):
    """Rows: the expression, metrics of Mitsuba and of Cycles; the noise floor of Cycles; Blender's version."""
    report = json.loads((demo / "report" / "report.json").read_text(encoding="utf-8"))
    views = {view["name"]: View(**{**view, "aim": tuple(view["aim"])}) for view in report["conditions"]["views"]}
    scans = load_character(demo / "character")
    maps, frame = [kind.name for kind in scans.maps], frame_of(in_metres(scans.meshes).neutral)
    renders = {row["expression"]: row for row in report["renders"] if (row["view"], row["light"]) == (view_name, light)}
    with TemporaryDirectory() as place:
        folder = Path(place)
        TARGETS["blender"](demo / "character.facezip", folder / "face", maps="apart")
        asked = list(shots(demo, folder, list(renders), maps))
        request = {
            "folder": str(folder / "face"),
            "names": scans.expressions,
            "resolution": report["conditions"]["resolution"],
            "samples": samples,
            "camera": camera(views[view_name], frame),
            "lights": lights(light, frame),
            "shots": asked,
        }
        version = cycles.run("judge.py", folder, request, timeout=None)["version"]
        rows, agreement = [], []
        for shot in asked[:-1]:
            name = shot["expression"]
            original, pack = (cycles.picture(shot[side]) for side in ("original", "pack"))
            rows.append((name, renders[name]["packs"][0], vars(compare(*pictures(original, pack)))))
            theirs = read_exr(demo / "report" / renders[name]["exr"])["original"]
            agreement.append(compare(*pictures(original, theirs)).image_rmse)
        floor = compare(*pictures(*(cycles.picture(asked[at]["original"]) for at in (0, -1))))
    return rows, floor, fmean(agreement), version


def main():
    demo, (view, light) = Path(sys.argv[1]), sys.argv[2:4] or ("front", "studio")
    rows, floor, agreement, version = judged(demo, view, light)
    print(f"{view}, {light}; Blender {version}, Cycles, {SAMPLES} samples\n")
    print("| expression | RMSE: Mitsuba | Cycles | FLIP: Mitsuba | Cycles |\n|---|---|---|---|---|")
    for name, mitsuba, theirs in sorted(rows, key=lambda row: -row[1]["flip"]):
        print(f"| {name} | {line(mitsuba, theirs)} |")
    means = [{key: fmean(row[side][key] for row in rows) for key in SHOWN} for side in (1, 2)]
    print(f"| **mean** | {line(*means)} |")
    ranks = [np.argsort(np.argsort([row[side]["flip"] for row in rows])) for side in (1, 2)]
    print(f"\nrank correlation of FLIP {np.corrcoef(*ranks)[0, 1]:.2f}; RMSE between the renderers {agreement:.1f}")
    for judge, side in (("Mitsuba", 1), ("Cycles", 2)):
        levels = Counter(DEFAULT_THRESHOLDS.level(*(row[side][name] for name in DECIDING)) for row in rows)
        most = ", ".join(f"{name} {max(row[side][name] for row in rows):.3f}" for name in DECIDING)
        worst = max(rows, key=lambda row, side=side: row[side]["delta_e_p95"])[0]
        print(f"{judge}: {', '.join(f'{count} {level}' for level, count in levels.items())}; at most {most} ({worst})")
    print(f"noise floor of Cycles: RMSE {floor.image_rmse:.2f}, FLIP {floor.flip:.3f}")


def line(mitsuba, theirs):
    return f"{mitsuba['image_rmse']:.2f} | {theirs['image_rmse']:.2f} | {mitsuba['flip']:.4f} | {theirs['flip']:.4f}"


if __name__ == "__main__":
    main()

"""How far Cycles is from ``blend``: ``python -m tests.engines.figures PACK``; needs what ``make engines`` installs.

Of every map the largest error at the centres of texels, and of the albedo the RMSE of what is baked on the head; over
the neutral, every seventh expression and a blend; of 255, inside the chart.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from facezip.character.raster import covered
from facezip.export import TARGETS
from facezip.files.srgb import encode_srgb
from facezip.pack.read import read_pack
from tests.engines import cycles
from tests.engines.test_blender import Case, expected, seen


def poses(names):
    rng = np.random.default_rng(0)
    mixed = dict(zip(names, (rng.uniform(-0.5, 1, len(names)) / np.sqrt(len(names))).tolist(), strict=True))
    return [({}, {}), *(({name: 1.0}, {}) for name in names[::7]), (mixed, {})]


def main():
    surface = read_pack(Path(sys.argv[1]))
    with TemporaryDirectory() as place:
        folder = Path(place)
        TARGETS["blender"](Path(sys.argv[1]), folder / "face")
        case = Case("shapes", surface, folder / "face", folder, poses(surface.expressions))
        found = cycles.run("session.py", folder, {"cases": [case.request]}, timeout=None)
        print(f"Blender {found['version']}, {len(surface.expressions)} shapes")
        numbers = range(len(case.poses))
        chart = covered(surface.meshes.topology, case.request["size"])
        for kind in surface.maps:
            errors = [np.abs(seen(case, kind, 1001, n) - expected(case, kind, 1001, n))[chart].max() for n in numbers]
            print(f"{kind.name}: {255 * max(errors):.3f} of 255 at the centres of texels at most")
        errors = [baked(folder / f"baked.{n}.npy") - expected(case, surface.maps[0], 1001, n) for n in numbers]
        rmse = max(255 * np.sqrt(np.mean(np.square(error[chart]))) for error in errors)
        largest = max(255 * np.abs(error[chart]).max() for error in errors)
        print(f"baked on the head: RMSE {rmse:.3f} at most, largest {largest:.2f}")


def baked(file):
    """The encoded albedo of a bake."""
    return encode_srgb(np.clip(np.load(file)[..., :3], 0, 1))


if __name__ == "__main__":
    main()

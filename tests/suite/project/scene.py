"""Mitsuba's own Cornell box; a test a trial, each with random numbers of its own."""

import os

import mitsuba as mi
import pytest

mi.set_variant("llvm_ad_rgb")
DEFECT = os.environ.get("DEFECT", "")


def load():
    box = mi.cornell_box()
    box["sensor"]["film"] |= {"width": 32, "height": 32}
    if DEFECT == "light 3 % dimmer":
        box["light"]["emitter"]["radiance"]["value"] = [0.97 * value for value in (18.387, 13.9873, 6.75357)]
    if DEFECT == "box moved by a fiftieth of the room":
        box["small-box"]["to_world"] = mi.ScalarTransform4f().translate([0.04, 0, 0]) @ box["small-box"]["to_world"]
    if DEFECT == "light paths of 3 instead of 8":
        box["integrator"]["max_depth"] = 3
    return mi.load_dict(box)


BOX = load()


@pytest.mark.parametrize("trial", range(int(os.environ["TRIALS"])))
def test_box(facezip_image, trial):
    facezip_image(lambda seed: mi.render(BOX, spp=16, seed=seed + 2_000_000 * trial))

"""The error of a DDS export against the originals: ``python -m tests.facezip.export.figures CHARACTER PACK EXPORT``.

Everything is read as an engine would: blocks by OpenImageIO's decoder, numbers from facezip.json alone.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from facezip import load_character, read_pack
from facezip.measure import mean_rmse, texture_errors
from facezip.textures import to_float


def exported(pack, folder):
    """The model that an export holds."""
    textures = json.loads((folder / "facezip.json").read_text())["textures"]

    def texels(name):
        image = oiio.ImageBuf(str(folder / textures[name]["file"])).get_pixels(oiio.UINT8)
        return to_float(np.ascontiguousarray(image[..., : pack.neutral.shape[2]]))

    names = [name for name in textures if name.startswith("difference")]
    values = [(texels(name) - textures[name]["zero"]) * textures[name]["scale"] for name in names]
    return replace(pack, neutral=texels("neutral"), differences=np.stack(values).astype(np.float32))


def main(character, pack, folder):
    scans, model = load_character(character), read_pack(pack)
    for name, shown in (("pack", model), ("export", exported(model, Path(folder)))):
        print(f"{name:8s} RMSE {mean_rmse(texture_errors(scans, shown.reconstruct)):.3f} of 255 to the originals")


if __name__ == "__main__":
    main(*sys.argv[1:])

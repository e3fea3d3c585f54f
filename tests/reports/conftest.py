"""A small validation document with renders beside it."""

import numpy as np
import pytest

from render.exr import write_exr

METRICS = {"image_rmse": 1.5, "image_rmse_debiased": 1.25, "psnr": 44.6, "flip": 0.0123, "delta_e_mean": 0.37,
           "delta_e_p95": 0.93, "delta_e_local": 1.8, "ssim": 0.9876}  # fmt: skip
SIZE = 24


def head(value):
    """A linear premultiplied picture: a disc of one colour."""
    y, x = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    coverage = ((x / 8) ** 2 + (y / 10) ** 2 < 1).astype(np.float32)[..., None]
    return np.concatenate([np.full((SIZE, SIZE, 3), value, np.float32) * coverage, coverage], axis=2)


def numbers(scale):
    return {key: value * scale if key != "ssim" else 1 - (1 - value) * scale for key, value in METRICS.items()}


def make_document(folder, packs=("refined",), expressions=("smile", "frown"), views=("front", "side"), name="Ada"):
    """Write renders into ``folder`` and return their document; later packs and expressions are worse."""
    (folder / "renders").mkdir(parents=True)
    renders = []
    for e, expression in enumerate(expressions):
        for v, view in enumerate(views):
            file = f"renders/{e}.{v}.exr"
            parts = {"original": head(0.25)} | {f"{k} {p}": head(0.25 + 0.02 * k) for k, p in enumerate(packs, 1)}
            write_exr(folder / file, parts, {})
            measured = [numbers((1 + 0.1 * e + 0.01 * v) * (k + 1)) for k in range(len(packs))]
            renders.append({"expression": expression, "view": view, "light": "studio", "exr": file,
                            "noise_floor": {"image_rmse": 0.71 + 0.01 * e}, "packs": measured})  # fmt: skip
    return {
        "format": "facezip-validation/3",
        "character": {"name": name, "expressions": list(expressions), "resolution": [64, 128], "vertices": 4321,
                      "triangles": 8642, "channels": 3, "maps": [{"name": "albedo", "encoding": "srgb"}],
                      "tiles": [1001]},
        "conditions": {"spp": 16, "sampler": "multijitter", "seed": 3, "views": list(views), "lights": ["studio"],
                       "units": {"image_rmse": "0..255 over head pixels"}, "texture_region": "the character's mask"},
        "packs": [_pack(k, pack, expressions) for k, pack in enumerate(packs)],
        "renders": renders,
        "seconds": {"render": 1.25, "total": 2.5},
        "pairs_per_second": 4.75,
    }  # fmt: skip


def _pack(k, name, expressions):
    where = {"expression": expressions[-1], "view": "side", "light": "studio"}
    means = numbers(k + 1)
    return {
        "name": name, "method": "paper", "bytes_on_gpu": 4_260_000, "bytes_on_disk": 1_020_000,
        "bytes_raw": 16_520_000, "fetches": 6, "texture_rmse": 3.51 + k,
        "texture_rmse_per_expression": {e: 3.0 + k + i for i, e in enumerate(expressions)}, **means,
        "noise_floor": 0.75, "noise_floor_per_metric": {"image_rmse": 0.75, "flip": 0.0777},
        "worst": {metric: {"value": value, **where} for metric, value in means.items()},
        "level": "visible", "verdict": f"Visible side by side: verdict of {k}.",
    }  # fmt: skip


@pytest.fixture
def document(tmp_path):
    return make_document(tmp_path)


@pytest.fixture
def comparison(tmp_path):
    """Three packs and two rivals."""
    rivals = [
        {"name": "PCA(4)", "texture_rmse": 9.75, "texture_rmse_per_expression": {"smile": 9.5, "frown": 10.0},
         "bytes_on_gpu": 3_930_000, "fetches": 5},
        {"name": "unpermuted", "texture_rmse": 6.5, "texture_rmse_per_expression": {"smile": 6.25, "frown": 6.75}},
    ]  # fmt: skip
    document = make_document(tmp_path, packs=("refined", "paper", "tiny"))
    return document | {"baselines": rivals, "command": "facezip validate Ada a.facezip -o out"}

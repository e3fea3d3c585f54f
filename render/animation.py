"""An animated blend, original against compressed: every frame on the same light paths, and the worst one named."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.machine.progress import track
from facezip.rigging.originals import Originals
from facezip.rigging.sequences import Pose
from render.llvm import start
from render.metrics import UNITS, Picture, compare, display, head_crop
from render.paired import Images, PairedRenderer
from render.settings import Settings
from render.skins import SkinMaps, upload
from scenes.cameras import frame_of

FORMAT = "facezip-animation/1"
MEANS = ("texture_rmse", "image_rmse", "flip", "delta_e_mean", "delta_e_p95", "ssim")
Texture = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Film:
    """What was measured, and the frames themselves.

    Attributes
    ----------
    document : plain data (``facezip-animation/1``).
    images : of every frame, the original first and the compressed second.
    """

    document: dict[str, Any]
    images: list[Images]


def animate(
    originals: Originals, compressed: Callable[[dict[str, float]], Texture], frames: Sequence[Pose], settings: Settings
) -> Film:
    """Render every frame in the first view and light of the settings, and measure it.

    Every frame has the same random numbers, so that noise stands still.

    Parameters
    ----------
    originals : textures and geometry of blends.
    compressed : gives ``(H, W, C)`` float32 in [0, 1] for weights β.
    """
    settings.check()
    versions, begin = start(), perf_counter()
    view, light = settings.views[0], settings.lights[0]
    renderer = PairedRenderer(
        originals.character.topology,
        frame_of(originals.neutral),
        [light],
        settings.material,
        settings.resolution,
        settings.transport,
    )
    found: list[dict[str, Any]] = []
    images: list[Images] = []
    for pose in track(frames, "Rendering the animation", len(frames)):
        textures = originals.texture(pose.weights), compressed({**pose.weights})
        renderer.pose(originals.vertices(pose.weights))
        skins = [upload(SkinMaps(one)) for one in textures]
        images.append(renderer.render(skins, view, light, settings.spp, settings.seed))
        measured = {"texture_rmse": _texture_rmse(*textures, originals.character.mask), **_measured(images[-1])}
        found.append({"frame": len(found), "pose": pose.name, "weights": {**pose.weights}, **measured})
    document = {
        "format": FORMAT,
        "character": originals.character.facts,
        "original": originals.definition,
        "conditions": {**versions, **_conditions(settings)},
        "frames": found,
        "means": {key: float(np.mean([frame[key] for frame in found])) for key in MEANS},
        "worst": max(found, key=lambda frame: frame["image_rmse"])["frame"],
        "seconds": {"total": round(perf_counter() - begin, 2)},
    }
    return Film(document, images)


def _measured(images: Images) -> dict[str, float | None]:
    crop, head = head_crop(images.coverage), images.coverage >= 0.5
    return compare(*(Picture(display(linear[crop]), head[crop]) for linear in images.linear))


def _texture_rmse(one: Texture, other: Texture, mask: Texture | None) -> float:
    squares = np.square(one - other, dtype=np.float64).mean(axis=2)
    return float(255 * np.sqrt(np.average(squares, weights=mask)))


def _conditions(settings: Settings) -> dict[str, Any]:
    plain = settings.resolved
    kept = {key: plain[key] for key in ("spp", "seed", "resolution", "material", "transport")}
    return {**kept, "views": plain["views"][:1], "lights": plain["lights"][:1], "units": UNITS}

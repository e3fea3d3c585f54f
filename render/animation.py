"""An animated blend, original against compressed: every frame on the same light paths, and the worst one named."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from facezip.character.maps import ALBEDO
from facezip.machine.progress import track
from facezip.pack.errors import Errors, texture_errors
from facezip.pack.model import CompressedTextures
from facezip.rigging.originals import BLEND, Originals
from facezip.rigging.sequences import Pose
from render.llvm import start
from render.metrics import UNITS, Picture, compare, display, head_crop
from render.paired import Images, PairedRenderer
from render.presence import check_present, face_triangles
from render.settings import Settings
from render.skins import upload
from render.staging import Source, rendered_maps, staged, staged_topology
from scenes.cameras import frame_of

FORMAT = "facezip-animation/1"
MEANS = ("texture_rmse", "image_rmse", "flip", "delta_e_mean", "delta_e_p95", "ssim")


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


def animate(originals: Originals, model: CompressedTextures, frames: Sequence[Pose], settings: Settings) -> Film:
    """Render every frame in the first view and light of the settings, with all maps and tiles, and measure it.

    Every frame has the same random numbers, so that noise stands still.

    Parameters
    ----------
    originals : textures and geometry of blends.
    model : what they are compared with.
    frames : the blends.
    settings : how to look.

    Raises
    ------
    FaceZipError
        ``NOTHING_TO_SEE``: a frame shows no face.
    """
    settings.check()
    versions, begin = start(), perf_counter()
    view, light = settings.views[0], settings.lights[0]
    renderer = PairedRenderer(
        staged_topology(originals.character),
        frame_of(originals.neutral),
        [light],
        settings.material,
        settings.resolution,
        settings.transport,
    )
    face = face_triangles(originals.character)
    found: list[dict[str, Any]] = []
    images: list[Images] = []
    for pose in track(frames, "Rendering the animation", len(frames)):
        blend, compressed = originals.blended(pose.weights), _source(model, pose.weights)
        renderer.pose(blend.mesh_vertices(BLEND))
        skins = [upload(staged(blend, one)(BLEND)) for one in (blend.texels, compressed)]
        images.append(renderer.render(skins, view, light, settings.spp, settings.seed))
        triangles, where = renderer.triangles(view), f"frame {len(found)}, {view.name} view"
        for picture in images[-1].linear:
            check_present(picture, triangles, face, where)
        measured = {**_map_errors(texture_errors(blend, compressed)), **_measured(images[-1])}
        found.append({"frame": len(found), "pose": pose.name, "weights": {**pose.weights}, **measured})
    document = {
        "format": FORMAT,
        "character": originals.character.facts,
        "original": originals.definition,
        "conditions": {**versions, **_conditions(settings), "maps_rendered": rendered_maps(originals.character)},
        "frames": found,
        "means": _means(found),
        "worst": max(found, key=lambda frame: frame["image_rmse"])["frame"],
        "seconds": {"total": round(perf_counter() - begin, 2)},
    }
    return Film(document, images)


def _source(model: CompressedTextures, weights: Mapping[str, float]) -> Source:
    """The texels of a blend, whatever name is asked for."""
    return lambda _, key: model.texels(weights, key)


def _map_errors(errors: Errors) -> dict[str, Any]:
    """RMSE of the albedo, and of each map its RMSE or mean angle: there is one expression, so means are its own."""
    numbers = {
        name: {key: value for key, value in found.items() if not key.endswith("_per_expression")}
        for name, found in errors.items()
    }
    return {"texture_rmse": errors[ALBEDO]["rmse"], "map_errors": numbers}


def _means(frames: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Of every number of the frames."""
    errors = [frame["map_errors"] for frame in frames]
    maps = {
        name: {key: float(np.mean([one[name][key] for one in errors])) for key in found}
        for name, found in errors[0].items()
    }
    return {**{key: float(np.mean([frame[key] for frame in frames])) for key in MEANS}, "map_errors": maps}


def _measured(images: Images) -> dict[str, float | None]:
    crop, head = head_crop(images.coverage), images.coverage >= 0.5
    return compare(*(Picture(display(linear[crop]), head[crop]) for linear in images.linear))


def _conditions(settings: Settings) -> dict[str, Any]:
    plain = settings.resolved
    kept = {key: plain[key] for key in ("spp", "seed", "resolution", "material", "transport")}
    return {**kept, "views": plain["views"][:1], "lights": plain["lights"][:1], "units": UNITS}

"""An animated blend, original against compressed: every frame on the same light paths, and the worst one named."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from facezip.character.maps import ALBEDO
from facezip.machine.progress import track
from facezip.pack.errors import MapErrors, texture_errors
from facezip.pack.model import CompressedTextures
from facezip.rigging.originals import BLEND, Originals
from facezip.rigging.sequences import Pose
from render.documents.animation import AnimationConditions, AnimationDocument, Frame, FrameMeans, TotalSeconds
from render.documents.conditions import Versions
from render.documents.images import ImageMetrics
from render.llvm import start
from render.metrics import UNITS, Picture, compare, display, head_crop
from render.paired import Images, PairedRenderer
from render.presence import check_present, face_triangles
from render.settings import Settings
from render.skins import upload
from render.staging import Source, rendered_maps, staged, staged_topology
from scenes.cameras import frame_of

MEANS = ("texture_rmse", "image_rmse", "flip", "delta_e_mean", "delta_e_p95", "ssim")


@dataclass(frozen=True, eq=False)
class Film:
    """What was measured, and the frames themselves.

    Attributes
    ----------
    document : what was measured.
    images : of every frame, the original first and the compressed second.
    """

    document: AnimationDocument
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
    found: list[Frame] = []
    images: list[Images] = []
    for pose in track(frames, "Rendering the animation", len(frames)):
        blend, compressed = originals.blended(pose.weights), _source(model, pose.weights)
        renderer.pose(blend.mesh_vertices(BLEND))
        skins = [upload(staged(blend, one)(BLEND)) for one in (blend.texels, compressed)]
        images.append(renderer.render(skins, view, light, settings.spp, settings.seed))
        triangles, where = renderer.triangles(view), f"frame {len(found)}, {view.name} view"
        for picture in images[-1].linear:
            check_present(picture, triangles, face, where)
        errors = texture_errors(blend, compressed)
        found.append(
            Frame(
                **vars(_measured(images[-1])),
                texture_rmse=errors[ALBEDO].mean,
                # Of one expression: means are its own.
                map_errors={name: found.means for name, found in errors.items()},
                frame=len(found),
                pose=pose.name,
                weights=pose.weights,
            )
        )
    document = AnimationDocument(
        character=originals.character.facts,
        original=originals.definition,
        conditions=_conditions(settings, versions, rendered_maps(originals.character)),
        frames=found,
        means=_means(found),
        worst=max(found, key=lambda frame: frame.image_rmse).frame,
        seconds=TotalSeconds(total=round(perf_counter() - begin, 2)),
    )
    return Film(document, images)


def _source(model: CompressedTextures, weights: Mapping[str, float]) -> Source:
    """The texels of a blend, whatever name is asked for."""
    return lambda _, key: model.texels(weights, key)


def _means(frames: Sequence[Frame]) -> FrameMeans:
    """Of every number of the frames."""
    maps = {name: _mean_errors([frame.map_errors[name] for frame in frames]) for name in frames[0].map_errors}
    means = {key: float(np.mean([getattr(frame, key) for frame in frames])) for key in MEANS}
    return FrameMeans(**means, map_errors=maps)


def _mean_errors(errors: Sequence[MapErrors]) -> MapErrors:
    def mean(key: str) -> float | None:
        return None if getattr(errors[0], key) is None else float(np.mean([getattr(one, key) for one in errors]))

    return MapErrors(
        rmse=mean("rmse"), angular_error=mean("angular_error"), angular_error_rms=mean("angular_error_rms")
    )


def _measured(images: Images) -> ImageMetrics:
    crop, head = head_crop(images.coverage), images.coverage >= 0.5
    return compare(*(Picture(display(linear[crop]), head[crop]) for linear in images.linear))


def _conditions(settings: Settings, versions: Versions, maps: Sequence[str]) -> AnimationConditions:
    return AnimationConditions(
        **vars(versions),
        views=settings.views[:1],
        lights=settings.lights[:1],
        material=settings.material,
        transport=settings.transport,
        resolution=settings.resolution,
        spp=settings.spp,
        seed=settings.seed,
        units=UNITS,
        maps_rendered=maps,
    )

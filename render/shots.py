"""One shot: a pose from a view in a light, rendered with every skin and measured until its verdict is decided."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import NEUTRAL
from facezip.files.obj import Topology
from render.colour import delta_e_2000
from render.decision import judge, stream
from render.documents.images import ImageMetrics, PackRender, RmseFloor, Taken
from render.metrics import Picture, compare, display, head_crop
from render.noise import Halves, debiased_rmse, noise_floor
from render.paired import Images, PairedRenderer
from render.presence import check_present
from render.regions import face_regions, locate
from render.settings import Settings
from render.skins import Skin
from render.store import RENDERS
from scenes.cameras import View, frame_of


@dataclass(frozen=True)
class Shot:
    """One pose under one light, from one view."""

    expression: str
    view: View
    light: str

    @property
    def name(self) -> str:
        """The stem of its files."""
        return f"{self.expression}.{self.view.name}.{self.light}"


def looks(settings: Settings) -> Iterator[tuple[View, str]]:
    """Every view in every light."""
    return product(settings.views, settings.lights)


class Studio:
    """A head before the cameras: renders shots and measures them, and keeps the time of both.

    Parameters
    ----------
    topology, neutral : the geometry, with one square of UV, and vertices ``(V, 3)``.
    face : ``(F,)``, which triangles are of the face (:func:`render.presence.face_triangles`).
    settings : how to look.
    """

    def __init__(
        self,
        topology: Topology,
        neutral: NDArray[np.float32],
        face: NDArray[np.bool_],
        settings: Settings,
        pool: ThreadPoolExecutor,
    ) -> None:
        frame = frame_of(neutral)
        self._face = face
        self.seconds = {"render": 0.0, "metrics": 0.0}
        self._settings, self._pool = settings, pool
        self._renderer = PairedRenderer(
            topology,
            frame,
            settings.lights,
            settings.material,
            settings.resolution,
            settings.transport,
        )
        self._regions = face_regions(topology, neutral)

    def pose(self, vertices: NDArray[np.float32]) -> None:
        """Move the head."""
        self._renderer.pose(vertices)

    def take(self, shot: Shot, skins: Sequence[Skin]) -> tuple[Taken, Images]:
        """Render a posed shot with the original's and every candidate's skin, and measure it.

        Samples are doubled until no confidence interval of a deciding metric straddles a limit, or at their most.

        Returns
        -------
        What was measured, and the images with all samples.

        Raises
        ------
        FaceZipError
            ``NOTHING_TO_SEE``: the picture shows no face.
        """
        halves, spp = self._round(shot, skins, 0), self._settings.spp
        triangles = self._renderer.triangles(shot.view)
        for picture in halves.mean.linear:
            check_present(picture, triangles, self._face, f"{shot.expression}, {shot.view.name} view")
        regions = self._labels(triangles)
        packs = self._measured(halves, regions)
        while not all(pack.decided for pack in packs) and 2 * spp <= self._settings.most:
            halves, spp = halves.merged(self._round(shot, skins, spp)), 2 * spp
            packs = self._measured(halves, regions)
        head = halves.mean.coverage >= 0.5
        taken = Taken(
            expression=shot.expression,
            view=shot.view.name,
            light=shot.light,
            spp=spp,
            noise_floor=RmseFloor(image_rmse=noise_floor(halves, head)),
            packs=packs,
            exr=f"{RENDERS}/{shot.name}.exr",
        )
        return taken, halves.mean

    def floor(self, shot: Shot, skins: Sequence[Skin]) -> ImageMetrics:
        """What noise alone does to every metric: the original against itself with other random numbers."""
        images = [self._round(shot, skins[:1], 0, repeat).mean for repeat in range(2)]
        begin = perf_counter()
        crop, head = head_crop(images[0].coverage), images[0].coverage >= 0.5
        found = compare(*(Picture(display(image.linear[0][crop]), head[crop]) for image in images))
        self.seconds["metrics"] += perf_counter() - begin
        return found

    def _round(self, shot: Shot, skins: Sequence[Skin], before: int, repeat: int = 0) -> Halves:
        """Two independent halves, as many samples as there were ``before``, or the first ones."""
        begin = perf_counter()
        count = (before or self._settings.spp) // 2
        seeds = [stream(self._settings.seed, before, half, repeat) for half in range(2)]
        halves = Halves(*(self._renderer.render(skins, shot.view, shot.light, count, seed) for seed in seeds))
        self.seconds["render"] += perf_counter() - begin
        return halves

    def _labels(self, triangles: NDArray[np.int32]) -> NDArray[np.int32]:
        labels: NDArray[np.int32] = np.where(triangles >= 0, self._regions[triangles], -1).astype(np.int32)
        return labels

    def _measured(self, halves: Halves, regions: NDArray[np.int32]) -> list[PackRender]:
        begin = perf_counter()
        whole = halves.mean
        crop, head = head_crop(whole.coverage), whole.coverage >= 0.5
        shown = [
            list(self._pool.map(lambda linear: _prepared(linear[crop], head[crop]), image.linear))
            for image in (whole, halves.first, halves.second)
        ]

        def one(k: int) -> PackRender:
            (original, *_), (first, *_), (second, *_) = shown
            other, *parts = (pictures[k] for pictures in shown)
            metrics = compare(original, other)
            errors = np.zeros(original.head.shape, np.float32)
            errors[original.head] = delta_e_2000(original.lab, other.lab)
            by_region, worst = locate(errors, original.head, regions[crop])
            if worst:
                top, left, *size = worst.box
                worst = replace(worst, box=(top + crop[0].start, left + crop[1].start, *size))
            halves_of = list(zip((first, second), parts, strict=True))
            judged = vars(judge(metrics, halves_of, self._settings.thresholds))
            debiased = debiased_rmse(halves, k, head)
            return PackRender(**vars(metrics) | judged, image_rmse_debiased=debiased, regions=by_region, where=worst)

        packs = list(self._pool.map(one, range(1, len(whole.linear))))
        self.seconds["metrics"] += perf_counter() - begin
        return packs


def _prepared(linear: NDArray[np.float32], head: NDArray[np.bool_]) -> Picture:
    """A picture with everything that metrics make of it alone, so that threads share the work."""
    picture = Picture(display(linear), head)
    _ = picture.lab, picture.seen
    return picture


def repeat_of(view: View, light: str) -> Shot:
    """The shot that the noise floor of a view in a light is measured with."""
    return Shot(NEUTRAL, view, light)

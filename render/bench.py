"""What one persistent scene and shared light paths save, and how true few samples are: measured, in one run."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character
from facezip.files.srgb import decode_srgb
from facezip.machine.progress import track
from render.documents.bench import BothWays, RenderBench
from render.llvm import start
from render.mesh import HeadMesh
from render.paired import PairedRenderer
from render.settings import Settings
from render.skins import SkinMaps, upload
from scenes.cameras import View, camera, frame_of
from scenes.materials import MATERIALS
from scenes.stage import stage


@dataclass(frozen=True, eq=False)
class Pose:
    """What one shot of the benchmark renders: vertices, and the original's and every pack's texture."""

    vertices: NDArray[np.float32]
    textures: Sequence[NDArray[np.float32]]


def bench_render(character: Character, poses: Sequence[Pose], settings: Settings, repeats: int) -> RenderBench:
    """Render every pose, view and light both ways, in turn, and compare the times.

    The naive way is a Mitsuba scene and a call of ``mi.render`` for each image; the paired way one renderer whose mesh
    moves. Both have compiled their kernels before.
    """
    start()
    looks = [(view, light) for view in settings.views for light in settings.lights]
    packs = len(poses[0].textures) - 1
    ways: list[Callable[[Sequence[Pose]], None]] = [
        lambda poses: _naive(character, poses, looks, settings),
        _paired(character, looks, settings),
    ]
    for way in ways:
        way(poses[:1])
    runs = []
    for _ in track(range(repeats), "Rendering both ways", repeats):
        naive, paired = (_timed(way, poses) for way in ways)
        pairs = len(poses) * len(looks) * packs
        runs.append(BothWays(naive_s=naive, paired_s=paired, speedup=naive / paired, pairs_per_second=pairs / paired))
    middle = sorted(runs, key=lambda run: run.speedup)[(repeats - 1) // 2]
    return RenderBench(**vars(middle), images=len(poses) * len(looks) * (packs + 1), runs=runs)


def _paired(
    character: Character, looks: Sequence[tuple[View, str]], settings: Settings
) -> Callable[[Sequence[Pose]], None]:
    renderer = renderer_of(character, settings)

    def render(poses: Sequence[Pose]) -> None:
        for pose in poses:
            renderer.pose(pose.vertices)
            skins = [upload(SkinMaps(texture)) for texture in pose.textures]
            for view, light in looks:
                renderer.render(skins, view, light, settings.spp, settings.seed)

    return render


def renderer_of(character: Character, settings: Settings) -> PairedRenderer:
    """The paired renderer of a character as settings ask for it."""
    frame = frame_of(character.meshes.neutral)
    skin, size, transport = settings.material, settings.resolution, settings.transport
    return PairedRenderer(character.meshes.topology, frame, settings.lights, skin, size, transport)


def _naive(character: Character, poses: Sequence[Pose], looks: Sequence[tuple[View, str]], settings: Settings) -> None:
    for pose in poses:
        for texture in pose.textures:
            for view, light in looks:
                render_alone(character, pose.vertices, texture, view, light, settings)


def render_alone(
    character: Character,
    vertices: NDArray[np.float32],
    texture: NDArray[np.float32],
    view: View,
    light: str,
    settings: Settings,
) -> NDArray[np.float32]:
    """One image ``(H, W, 4)``, linear, by a scene of its own and Mitsuba's path integrator: the obvious way."""
    start()
    import mitsuba as mi

    colour = texture if texture.shape[2] == 3 else np.repeat(texture[:, :, :1], 3, axis=2)
    bitmap = {"type": "bitmap", "data": mi.TensorXf(decode_srgb(colour)), "raw": True, "wrap_mode": "clamp"}
    head = HeadMesh(character.meshes.topology, MATERIALS[settings.material](bitmap))
    frame, depth = frame_of(character.meshes.neutral), 2 if settings.transport == "direct" else -1
    scene = mi.load_dict(stage(head.shape, frame, light, depth) | {"sensor": camera(view, frame, settings.resolution)})
    head.move(mi.traverse(scene), vertices)
    return np.array(mi.render(scene, spp=settings.spp, seed=settings.seed), np.float32)


def _timed(work: Callable[[Sequence[Pose]], None], poses: Sequence[Pose]) -> float:
    begin = perf_counter()
    work(poses)
    return perf_counter() - begin

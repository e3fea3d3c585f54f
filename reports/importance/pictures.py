"""The importance as colours: on the rendered head from every view that it was made for, and in UV."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key
from facezip.character.scans import NEUTRAL, Character, Stack
from facezip.character.tiles import Atlas
from facezip.files.srgb import decode_srgb
from render.importance import Sight, face_means, posed, staged_albedo
from render.operator import ImageOperator
from reports.figures import nice_ticks
from reports.images import BACKDROP, ColourScale, Crop, data_uri, display, to_bytes
from reports.importance.documents import ImportanceFacts

QUALITY = 90
# More texels than a page shows.
LARGEST = 1024


@dataclass(frozen=True)
class Panel:
    """A picture as a data URI, its caption, what it says to those who do not see it, and its width over its height."""

    source: str
    caption: str
    note: str
    alternative: str
    aspect: float


def scale_of(importance: ImportanceFacts) -> ColourScale:
    """One scale for the page: from 0 to a round number at or above the 99th percentile; brighter is all above."""
    return ColourScale(nice_ticks(importance.p99)[-1])


def head_panels(
    character: Character, importance: Mapping[Key, NDArray[np.float32]], sight: Sight, scale: ColourScale
) -> list[tuple[Panel, Panel]]:
    """The neutral head and its albedo's importance, from each view under the first light of ``sight``."""
    rigs = dict(reversed(sight.looks))
    first = replace(sight, looks=tuple((view, rigs[view]) for view in reversed(rigs)))
    neutral = decode_srgb(staged_albedo(character, NEUTRAL))
    weights = Atlas.of(character.tiles).joined({tile: importance[ALBEDO, tile][:, :, None] for tile in character.tiles})
    renderer = first.renderer(character)
    operators = first.operators(renderer, posed(character, renderer, NEUTRAL))
    panels = []
    for (view, rig), operator in zip(first.looks, operators, strict=True):
        crop, name = Crop.around([operator.coverage]), view.name.replace("_", " ")
        render = np.concatenate([operator.image(neutral), operator.coverage[:, :, None]], axis=2)
        heat = scale.colours(_on_head(operator, weights))
        heat[operator.coverage < 0.5] = BACKDROP
        pictures = to_bytes(display(render)), heat
        notes = (f"{rig} light", f"rendered neutral head, {name}"), ("", f"importance on the head, {name}")
        width, height = crop.size
        made = [
            Panel(data_uri(np.ascontiguousarray(crop.of(picture)), QUALITY), name, note, words, width / height)  # type: ignore[arg-type]
            for picture, (note, words) in zip(pictures, notes, strict=True)
        ]
        panels.append((made[0], made[1]))
    return panels


def uv_panels(character: Character, importance: Mapping[Key, NDArray[np.float32]], scale: ColourScale) -> list[Panel]:
    """The importance in UV, a picture for each map and tile, on the backdrop where the mask leaves texels out.

    Each map in units of its own mean over the face.
    """
    means = face_means(importance, {key: character.stacks[key].weight for key in importance})
    panels = []
    for (name, tile), one in importance.items():
        words = [name] * (len(means) > 1) + [f"tile {tile}"] * (len(character.tiles) > 1)
        caption = ", ".join(["UV", *words])
        panels.append(_uv_panel(character.stacks[name, tile], one / np.float32(means[name]), scale, caption))
    return panels


def _uv_panel(stack: Stack, importance: NDArray[np.float32], scale: ColourScale, caption: str) -> Panel:
    step = -(-max(importance.shape) // LARGEST)
    shown = importance[::step, ::step]
    colours = scale.colours(shown)
    colours[stack.weight[::step, ::step] == 0] = BACKDROP
    height, width = shown.shape
    words = f"importance of every texel in {caption}"
    return Panel(data_uri(colours, QUALITY), caption, "face region", words, width / height)


def _on_head(operator: ImageOperator, importance: NDArray[np.float32]) -> NDArray[np.float32]:
    """The mean importance ``(h, w, 1)`` of the texels that a pixel sees, each by its share in the pixel: ``(H, W)``."""
    texels = np.repeat(importance, 3, axis=2)
    seen = operator.apply(np.ones_like(texels)).sum(axis=2)
    total = operator.apply(texels).sum(axis=2)
    mean: NDArray[np.float32] = np.divide(total, seen, out=np.zeros_like(total), where=seen > 0)
    return mean

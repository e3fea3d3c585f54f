"""MetaHuman: base colours CM1 to CM3 and normals WM1 to WM3 beside the neutral, the masks, and a curve for each mask.

What a head's material does is public in the shader for Maya that comes with Epic's DNA Calibration library
(``data/shaders/dx11_shd_head.fx`` of https://github.com/EpicGames/MetaHuman-DNA-Calibration): changes from the neutral
are added, colours as linear light, of normals x and y, each times a mask and a curve. RigLogic clamps curves to 0..1
(``ConditionalTable.cpp`` of https://github.com/EpicGames/OpenRigLogic).
"""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from facezip.character.maps import ALBEDO, Map
from facezip.documents.document import to_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.documents.layers import CurveImages, CurvesDocument, LayerCurve, LayersExport
from facezip.export.engine import write_text
from facezip.export.layered import (
    Layered,
    export_layered,
    read_layered,
    still_words,
    unfit,
    write_image,
    write_layers,
)
from facezip.export.layering import Weights
from facezip.export.mixing import Rule
from facezip.pack.masked import MaskedWeights

ENGINE, MOST = "MetaHuman", 3
RULE = Rule(in_turn=False, keeps_z=True)
CSV_FILE, JSON_FILE, MASKS = "curves.csv", "curves.json", "masks"
# The layers of a mask, as its name says them: head_wm13_… is of the first and the third.
_NAMED = re.compile(r"head_wm(?P<layers>[1-9]+)_.+")
# Of the files of masks, and of no curve.
_SUFFIX = "_msk"


@dataclass(frozen=True)
class Curve:
    """What drives a mask in a layer of a map.

    Attributes
    ----------
    kind : of the map.
    layer : its number, from 1 on.
    mask : the mask's number, from 0 on.
    mask_name : the mask's name.
    """

    kind: Map
    layer: int
    mask: int
    mask_name: str

    @property
    def name(self) -> str:
        """As the material's parameter is called, and the animation's curve: ``head_wm1_normal_head_wm1_jawOpen``."""
        return f"{_layer_name(self.kind, self.layer)}_{self.mask_name.removesuffix(_SUFFIX)}"


def export_metahuman(pack: Path, output: Path, *, overwrite: bool = False) -> LayersExport:
    """Export a pack of given masks as layers, masks and curves.

    Returns
    -------
    The content of ``facezip.json``, with ``output`` and the ``bytes`` of all files.

    Raises
    ------
    FaceZipError
        What :func:`facezip.export.layered.read_layered` and :mod:`facezip.files.writing` raise; ``BAD_VALUE`` where
        curves cannot hold what the pack does.
    """
    whole = read_layered(pack, ENGINE, MOST)
    masked = _checked(whole)
    curves = _curves(whole, masked)
    maps = masked[whole.tile]

    def write(folder: Path) -> LayersExport:
        textures, found = write_layers(whole, folder, Weights(maps, maps), RULE, image_name)
        for name, mask in zip(masked.names, masked.masks[whole.tile], strict=True):
            textures[f"{MASKS}/{name}"] = write_image(folder, f"{MASKS}/{name}.png", mask[..., None])
        _write_curves(folder, whole, masked, curves)
        words = {"slots": whole.slots, "maps": found, "masks": len(masked.names), "curves": len(curves)}
        height, width = masked.masks[whole.tile].shape[1:]
        write_text(folder, {"GUIDE.md": "metahuman/guide.j2"}, words | {"width": width, "height": height})
        return LayersExport(
            target="metahuman",
            name=whole.name,
            tile=whole.tile,
            textures=textures,
            maps=found,
            curves={
                curve.name: LayerCurve(map=curve.kind.name, layer=curve.layer, mask=curve.mask_name) for curve in curves
            },
            notes=[*still_words(whole, ENGINE), *_strange_words(masked)],
        )

    return export_layered(output, overwrite, write)


def image_name(kind: Map, layer: int) -> str:
    """As the files of a MetaHuman's source are called, layers from 1 on: ``head_color_map``, ``head_cm1_color_map``."""
    return f"{_layer_name(kind, layer)}_map"


def _layer_name(kind: Map, layer: int) -> str:
    """``head_cm1_color`` and ``head_wm1_normal``; without a number of layer 0, which is the neutral."""
    if kind.name == ALBEDO:
        return f"head_cm{layer}_color" if layer else "head_color"
    return f"head_wm{layer}_{kind.name}" if layer else f"head_{kind.name}"


def _checked(whole: Layered) -> MaskedWeights:
    """The masks; raises where curves cannot hold the activations, or the material has none for a mask."""
    masked = whole.model.masked
    if masked is None:
        reason = f"has a weight map for each expression, and {ENGINE} holds fixed masks and a number for each"
        raise unfit(whole.path, f"{reason}; compress with --given-masks DIR, those of the rig")
    if not masked.clamped:
        low, high = float(masked.activations.min()), float(masked.activations.max())
        reason = f"has activations from {low:.2f} to {high:.2f}, and curves are clamped to 0..1"
        raise unfit(whole.path, f'{reason}; say activations = "0..1" in masks.toml, and compress again')
    for k, i in _used(masked):
        named = _NAMED.fullmatch(masked.names[k])
        if named and str(i + 1) not in named["layers"]:
            layers = [int(digit) - 1 for digit in named["layers"]]
            reason = f"mask '{masked.names[k]}' acts in layer {i}, for which the material has no parameter"
            remedy = f"say {masked.names[k]} = {layers} under [layers] in masks.toml, and compress again"
            raise unfit(whole.path, f"{reason}; {remedy}")
    return masked


def _used(masked: MaskedWeights) -> Iterator[tuple[int, int]]:
    """The masks, and for each the layers in which some expression has it."""
    for k, i in np.argwhere((masked.activations > 0).any(axis=0)):
        yield int(k), int(i)


def _curves(whole: Layered, masked: MaskedWeights) -> list[Curve]:
    """Those that some expression moves, by map; raises where two would have one name."""
    curves = [Curve(kind, i + 1, k, masked.names[k]) for kind in whole.mixed for k, i in _used(masked)]
    names = [curve.name for curve in curves]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        reason = f"two masks would have the curve '{twice}'; rename one, and compress again"
        raise FaceZipError(ErrorCode.UNSAFE_NAME, f"{whole.path}: {reason}")
    return curves


def _write_curves(folder: Path, whole: Layered, masked: MaskedWeights, curves: list[Curve]) -> None:
    names = [curve.name for curve in curves]
    rows = {
        expression: [float(values[curve.mask, curve.layer - 1]) for curve in curves]
        for expression, values in zip(whole.model.expressions, masked.activations, strict=True)
    }
    with open(folder / CSV_FILE, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["expression", *names])
        table.writerows([name, *values] for name, values in rows.items())
    images = {
        curve.name: CurveImages(map=f"{image_name(curve.kind, curve.layer)}.png", mask=f"{MASKS}/{curve.mask_name}.png")
        for curve in curves
    }
    moved = {
        name: {curve: value for curve, value in zip(names, values, strict=True) if value}
        for name, values in rows.items()
    }
    document = CurvesDocument(curves=images, expressions=moved)
    (folder / JSON_FILE).write_text(f"{to_json(document)}\n", encoding="utf-8")


def _strange_words(masked: MaskedWeights) -> list[str]:
    strange = [name for name in masked.names if not _NAMED.fullmatch(name)]
    if not strange:
        return []
    reason = f"{len(strange)} masks are not named as those of a MetaHuman (head_wm1_…), such as '{strange[0]}'"
    return [f"{reason}: its material has no parameters for their curves; add them, or rename the masks"]

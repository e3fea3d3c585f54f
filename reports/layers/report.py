"""The page of ``facezip layers``: which layer does what in which expression."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.documents.document import to_json
from facezip.files.writing import write_whole
from facezip.pack.facts import PackFacts
from facezip.pack.model import CompressedTextures
from reports.conditions import words
from reports.images import data_uri, to_bytes
from reports.layers.documents import (
    ExpressionLevel,
    ExpressionLevels,
    LayerFacts,
    LayersDocument,
    MaskLevels,
    RegionShare,
)
from reports.layers.measure import Uses, measure_uses
from reports.layers.pictures import AMPLIFIED, LARGE, Pictures, signed, signed_gradient
from reports.page import write_page

PAGE, DATA = "index.html", "layers.json"
# Expressions named with a mask, lines listed beside a layer.
NAMED, LISTED = 2, 6


@dataclass(frozen=True)
class Share:
    """A name, its number as text, and the length of its bar, 0..1."""

    name: str
    text: str
    length: float


@dataclass(frozen=True)
class Layer:
    """One difference texture: what it is called, does, and looks like."""

    index: int
    title: str
    strongest: str
    expressions: tuple[Share, ...]
    regions: tuple[Share, ...]
    textures: tuple[tuple[str, str], ...]
    weights: str
    alone: str
    added: str


@dataclass(frozen=True)
class Line:
    """One expression: a small picture of each layer's weights, and how much each layer makes of it."""

    name: str
    main: int
    cells: tuple[tuple[str, str, float], ...]


@dataclass(frozen=True)
class Mask:
    """One mask: its name, where it is, the expressions that use it most, and its picture."""

    name: str
    region: str
    expressions: str
    picture: str


@dataclass(frozen=True)
class Activations:
    """The activations of one layer as a picture of K rows and N columns of pixels."""

    layer: int
    title: str
    picture: str


def describe(model: CompressedTextures, name: str) -> LayersDocument:
    """What the page says: layers, expressions and masks, sorted, with their numbers."""
    uses = measure_uses(model)
    levels = uses.levels
    order = np.argsort(-np.square(levels).sum(axis=0), kind="stable")
    layers = [_layer(uses, levels, int(i), model.expressions) for i in order]
    main = np.argmax(levels[:, order], axis=1)
    lines = sorted(range(len(main)), key=lambda n: (main[n], -levels[n, order[main[n]]]))
    rows = [ExpressionLevels(name=model.expressions[n], levels=levels[n, order].tolist()) for n in lines]
    return LayersDocument(name=name, layers=layers, expressions=rows, masks=_masks(model, uses))


def describe_and_write(model: CompressedTextures, facts: PackFacts, command: str, folder: Path) -> LayersDocument:
    """Write ``layers.json`` and the page ``index.html`` with the same numbers; returns what :func:`describe` does.

    Parameters
    ----------
    model, facts : the pack, and what :func:`facezip.pack.facts.pack_facts` says of it.
    command : which makes the page again.
    folder : where both files go, each whole or not at all.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    document, pictures = describe(model, facts.name), Pictures(model)
    write_whole(folder / DATA, to_json(document).encode())
    write_page(
        folder / PAGE,
        "layers.html",
        document=document,
        data_name=DATA,
        title=f"{facts.name} – layers, by FaceZip",
        facts=facts,
        amplified=AMPLIFIED,
        layers=[_pictured(model, pictures, layer) for layer in document.layers],
        lines=[_line(pictures, document, row) for row in document.expressions],
        masks=_pictured_masks(model, pictures, document),
        activations=_activations(model, document),
        gradient=signed_gradient(),
        made=_made(facts),
        command=command,
    )
    return document


def _made(facts: PackFacts) -> list[tuple[str, str]]:
    height, width = facts.resolution
    scale = f"1/{facts.weight_scale} as wide" if facts.weight_scale else "one number each"
    return [
        ("Pack", f"{len(facts.expressions)} expressions, {facts.differences} layers, {width} × {height}"),
        ("Maps", ", ".join(kind.name for kind in facts.maps)),
        ("Weight maps", scale),
        *((key.replace("_", " ").capitalize(), words(value)) for key, value in facts.made_with.items()),
    ]


def _layer(uses: Uses, levels: NDArray[np.float64], i: int, expressions: Sequence[str]) -> LayerFacts:
    regions = uses.regions_of(uses.squares[:, i].sum(axis=0))
    strongest = np.argsort(-levels[:, i], kind="stable")
    return LayerFacts(
        layer=i,
        name=uses.name_of(i),
        level=float(np.sqrt(np.square(levels[:, i]).mean())),
        regions=[RegionShare(name=name, share=share) for name, share in regions],
        expressions=[ExpressionLevel(name=expressions[n], level=float(levels[n, i])) for n in strongest],
    )


def _masks(model: CompressedTextures, uses: Uses) -> list[MaskLevels]:
    if model.masked is None:
        return []
    activations = np.square(model.masked.activations.astype(np.float64))
    # How much a mask does in each expression, its overlap with others aside.
    each = uses.root(np.einsum("nki,kig->nk", activations, uses.masks))
    total = np.sqrt(np.square(each).mean(axis=0))
    found = []
    for k in np.argsort(-total, kind="stable"):
        order = [n for n in np.argsort(-each[:, k], kind="stable") if each[n, k] > 0]
        regions = uses.regions_of(uses.masks[k].sum(axis=0))
        found.append(
            MaskLevels(
                mask=int(k),
                name=model.masked.names[k],
                region=regions[0][0] if regions else "",
                level=float(total[k]),
                expressions=[ExpressionLevel(name=model.expressions[n], level=float(each[n, k])) for n in order],
            )
        )
    return found


def _pictured(model: CompressedTextures, pictures: Pictures, layer: LayerFacts) -> Layer:
    index, strongest = layer.layer, layer.expressions[0].name
    regions, expressions = layer.regions[:LISTED], layer.expressions[:LISTED]
    most = max(expressions[0].level, 1e-12)
    return Layer(
        index=index,
        title=layer.name,
        strongest=strongest,
        expressions=tuple(Share(e.name, f"{e.level:.2f}", e.level / most) for e in expressions),
        regions=tuple(Share(r.name, f"{r.share:.0%}", r.share / regions[0].share) for r in regions),
        textures=tuple((kind.name, pictures.texture(kind, index)) for kind in model.maps),
        weights=pictures.weights(strongest, index, LARGE),
        alone=pictures.alone(strongest, index),
        added=pictures.added(strongest, index),
    )


def _line(pictures: Pictures, document: LayersDocument, row: ExpressionLevels) -> Line:
    most = max(max(other.levels) for other in document.expressions) or 1
    cells = tuple(
        (pictures.weights(row.name, layer.layer), f"{level:.2f}", level / most)
        for layer, level in zip(document.layers, row.levels, strict=True)
    )
    return Line(row.name, row.levels.index(max(row.levels)), cells)


def _pictured_masks(model: CompressedTextures, pictures: Pictures, document: LayersDocument) -> list[Mask]:
    return [
        Mask(
            mask.name,
            mask.region,
            ", ".join(expression.name for expression in mask.expressions[:NAMED]),
            pictures.mask(mask.mask),
        )
        for mask in document.masks
    ]


def _activations(model: CompressedTextures, document: LayersDocument) -> list[Activations]:
    """Masks down, expressions across, in the orders of the page; the largest of a layer at the ends of the colours."""
    if model.masked is None:
        return []
    masks = [mask.mask for mask in document.masks]
    columns = [model.expressions.index(row.name) for row in document.expressions]
    values = model.masked.activations.astype(np.float32)[columns][:, masks]
    found = []
    for layer in document.layers:
        one = values[:, :, layer.layer].T
        scaled = one / max(float(np.abs(one).max()), 1e-12)
        picture = data_uri(to_bytes(signed(scaled.astype(np.float32))))
        found.append(Activations(layer.layer, layer.name, picture))
    return found

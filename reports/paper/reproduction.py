"""All experiments in turn, each on what the others have made already, as one document."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from time import perf_counter

from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.machine.conditions import conditions
from facezip.machine.progress import track
from reports.paper.documents.figures import MasksFigure, ShapesFigure, TableRow
from reports.paper.documents.paper import PaperConditions, PaperDocument, PaperSeconds, PublishedFacts, PublishedRow
from reports.paper.experiments import (
    WEIGHT_SCALE,
    Settings,
    Trial,
    figure_6,
    figure_7_convergence,
    run_trial,
    table_1,
)
from reports.paper.findings import find
from reports.paper.mask_counts import figure_7_masks
from reports.paper.published import EXPRESSIONS, EXPRESSIONS_IN_MEMORY, MACHINE, TABLE_1
from reports.paper.sizes import reduced

# Figure 7, right, compresses hundreds of times; warming up, once for nothing but compiled kernels.
MASK_TEXELS, WARM_TEXELS = 512, 64
LIBRARIES = ("facezip", "numpy", "numba", "scikit-learn", "scipy")


def reproduce(
    characters: Iterable[Character],
    count: int,
    settings: Settings,
    origin: str,
    generated: Callable[[Character], ShapesFigure] | None = None,
) -> PaperDocument:
    """The paper's Table 1 and Figures 6, 7 and 8 on the albedo of all tiles, with our methods beside its own.

    Parameters
    ----------
    characters : one person at several texture sizes; the figures are of the first.
    count : how many they are.
    settings : what the experiments may be told.
    origin : where the sizes come from, in words.
    generated : measures Figure 8 on the first of them; None where there are no shapes to generate.

    """
    begin = perf_counter()
    rows, reference = [], None
    for character in track(map(_albedo, characters), "Table 1", count):
        if reference is None:
            # The first call of a kernel may compile it: not what a table of times is about.
            run_trial(reduced(character, WARM_TEXELS), Settings(masks=2, restarts=1))
        trial = run_trial(character, settings)
        rows.append(table_1(trial))
        reference = reference or trial
    if reference is None:
        raise ValueError("no character to measure")
    document = PaperDocument(
        character=reference.character.facts,
        conditions=_conditions(reference.character, settings, origin),
        published=_published(),
        table_1=sorted(rows, key=lambda row: row.resolution),
        figure_6=figure_6(reference),
        figure_7_convergence=figure_7_convergence(reference),
        figure_7_masks=_masks(reference, rows, settings),
        figure_8=generated(reference.character) if generated else None,
        seconds=PaperSeconds(total=round(perf_counter() - begin, 2)),
    )
    return replace(document, findings=find(document))


def _albedo(character: Character) -> Character:
    return character.only(ALBEDO)


def _masks(reference: Trial, rows: list[TableRow], settings: Settings) -> MasksFigure:
    """The mask experiment at no more than 512 texels, beside what does not depend on masks at that size."""
    character = reduced(reference.character, MASK_TEXELS)
    shared = reference if character is reference.character else None
    row = next((row for row in rows if row.resolution == character.first.resolution), None)
    row = row or table_1(run_trial(character, settings))
    others = {name: row.rmse[name] for name in ("refined", "pca_4")}
    return replace(figure_7_masks(character, settings, shared), without_masks=others)


def _conditions(character: Character, settings: Settings, origin: str) -> PaperConditions:
    tiles = len(character.tiles)
    return PaperConditions(
        **vars(conditions(LIBRARIES)),
        times="one run each, kernels compiled before, textures in memory; no reading, writing or quantising",
        errors="RMSE 0..255 of the maps as a pack stores them, 8 bits a channel, mean over expressions",
        maps=f"the albedo, as in the paper{f', of all {tiles} tiles' * (tiles > 1)}",
        texture_region="the character's mask" if character.masked else "whole texture",
        texture_sizes=origin,
        weight_scale=WEIGHT_SCALE,
        **vars(settings),
    )


def _published() -> PublishedFacts:
    rows = [PublishedRow(resolution=(side, side), **vars(row)) for side, row in TABLE_1.items()]
    return PublishedFacts(
        table_1=rows,
        machine=MACHINE,
        expressions=EXPRESSIONS,
        expressions_in_memory=EXPRESSIONS_IN_MEMORY,
    )

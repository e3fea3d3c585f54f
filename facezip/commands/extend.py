"""``facezip extend``: new expressions under the difference textures of a pack."""

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from facezip.commands import options
from facezip.commands.words import memory_words
from facezip.fit.documents import ExtendDocument
from facezip.fit.extending import extend_into
from facezip.machine.memory import beside, limited

# A smaller share of weights at the end of their range is not worth a word.
LEAST_CUT = 0.005


@click.command("extend")
@click.argument("pack", type=options.FOLDER)
@click.argument("character", type=options.FOLDER)
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="PACK", help="Folder NAME.facezip to write."
)
@click.option("--quick", is_flag=True, help="Skip the fit of all expressions, which tells what the new ones lose.")
@options.memory
@options.overwrite
@options.as_json
def command(
    pack: Path, character: Path, output: Path, quick: bool, memory: int | None, overwrite: bool, as_json: bool
) -> None:
    """Add the expressions of CHARACTER that PACK lacks, under the difference textures that it has.

    Only weights are fitted. Neutrals, difference textures and old weights keep every byte. head.glb gets a morph target
    for each new expression. CHARACTER has the neutral, mesh and maps that PACK was made from, and one expression or
    more. Expressions that PACK has already stay as they are.

    Textures made without an expression may not be able to show it. The command says what each new expression loses
    against a fit of all, and advises a new fit where that is much.
    """
    with limited(memory, beside(output)):
        document = extend_into(pack, character, output, overwrite, quick, lambda line: print(line, file=sys.stderr))
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: ExtendDocument) -> list[str]:
    added, kept = document.added, document.kept
    verb = "stays as it is" if len(kept) == 1 else "stay as they are"
    stay = f"; {', '.join(kept)} {verb}" if kept else ""
    blocks, _ = memory_words(document)
    return [
        f"{document.pack}: {len(added)} new of {len(document.expressions)} expressions{stay}, {document.seconds:.1f} s",
        *(f"  {name:<10} {_words(document, name)}" for name in added),
        *_advice(document.advised),
        f"  GPU        {blocks}",
    ]


def _words(document: ExtendDocument, name: str) -> str:
    """The errors of a new expression, map by map, beside those of a fit of all where there was one."""
    full, parts = document.full_fit, []
    for kind, found in document.errors.items():
        beside = f", {full[kind].per_expression[name]:.2f} with a fit of all" if full else ""
        parts.append(f"{kind} {found.per_expression[name]:.2f}{beside}")
    cut = document.cut[name]
    bounded = f"; {cut:.0%} of its weights at the end of the old ones' range" if cut >= LEAST_CUT else ""
    return "; ".join(parts) + bounded


def _advice(losing: Sequence[str]) -> list[str]:
    if not losing:
        return []
    some = ", ".join(losing[:3]) + (", …" if len(losing) > 3 else "")
    verb = "loses" if len(losing) == 1 else "lose"
    return [f"  advice     {some} {verb} much: compress all scans again once textures may change"]

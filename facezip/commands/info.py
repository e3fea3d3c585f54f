"""``facezip info``: what a pack holds and what it costs at run time."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import click

from facezip.commands import options
from facezip.commands.words import masks_words, megabytes, memory_words
from facezip.documents.document import Document
from facezip.pack.facts import PackFacts, pack_facts
from facezip.pack.parsing import read_manifest


@dataclass(frozen=True, kw_only=True)
class InfoDocument(PackFacts, Document):
    """What ``facezip info`` says of a pack.

    Attributes
    ----------
    pack : its folder.
    """

    format: Literal["facezip-info/1"] = "facezip-info/1"
    pack: str


@click.command("info")
@click.argument("pack", type=options.FOLDER)
@options.as_json
def command(pack: Path, as_json: bool) -> None:
    """Show what PACK holds, what it costs in memory and fetches, and how it was made.

    It reads the manifest alone; 'facezip verify' checks every byte.
    """
    facts = InfoDocument(pack=str(pack), **vars(pack_facts(pack, read_manifest(pack))))
    options.answer(facts, as_json, lambda: _lines(facts))


def _lines(facts: InfoDocument) -> list[str]:
    height, width = facts.resolution
    scaled = f"at 1/{facts.weight_scale}" if facts.weight_scale else "uniform"
    maps = ", ".join(f"{kind.name} ({kind.encoding}, {kind.channels})" for kind in facts.maps)
    blocks, plain = memory_words(facts)
    return [
        f"{facts.name}  {width}x{height}, method {facts.method}",
        f"  maps         {maps}; each has a neutral and {facts.differences} differences, weight maps {scaled}",
        f"  tiles        {', '.join(str(tile.tile) for tile in facts.tiles)}",
        f"  expressions  {len(facts.expressions)}: {', '.join(facts.expressions)}",
        *([f"  masks        {masks_words(facts.masks)}"] if facts.masks else []),
        f"  on the GPU   {blocks}",
        f"               {plain}",
        f"               {facts.bits_per_texel_channel:.2f} bits per texel and channel",
        f"  geometry     {facts.vertices} vertices, {megabytes(facts.bytes_geometry)}",
        f"  on disk      {megabytes(facts.bytes_on_disk)}",
        *(f"  {key:<12} {value}" for key, value in facts.made_with.items() if not isinstance(value, dict)),
    ]

"""``facezip info``: what a pack holds and what it costs at run time."""

from pathlib import Path
from typing import Any

import click

from facezip.commands import options
from facezip.commands.options import megabytes
from facezip.pack.facts import memory_words, pack_facts
from facezip.pack.surface_manifest import read_any_manifest


@click.command("info")
@click.argument("pack", type=options.FOLDER)
@options.as_json
def command(pack: Path, as_json: bool) -> None:
    """Show what PACK holds, what it costs in memory and fetches, and how it was made.

    Reads the manifest alone; 'facezip verify' checks every byte.
    """
    facts = {"pack": str(pack), **pack_facts(pack, read_any_manifest(pack))}
    options.answer(facts, as_json, lambda: _lines(facts))


def _lines(facts: dict[str, Any]) -> list[str]:
    height, width = facts["resolution"]
    maps = f"at 1/{facts['weight_scale']}" if facts["weight_scale"] else "uniform"
    blocks, plain = memory_words(facts)
    return [
        f"{facts['name']}  {width}x{height}, {facts['channels']} channels, method {facts['method']}",
        *_several(facts),
        f"  textures     1 neutral, {facts['differences']} differences, weight maps {maps}",
        f"  expressions  {len(facts['expressions'])}: {', '.join(facts['expressions'])}",
        f"  on the GPU   {blocks}",
        f"               {plain}",
        f"  on disk      {megabytes(facts['bytes_on_disk'])}",
        *(f"  {key:<12} {value}" for key, value in facts["made_with"].items() if not isinstance(value, dict)),
    ]


def _several(facts: dict[str, Any]) -> list[str]:
    """Maps and tiles, where there is more than an albedo."""
    if "maps" not in facts:
        return []
    maps = ", ".join(f"{kind['name']} ({kind['encoding']}, {kind['channels']})" for kind in facts["maps"])
    tiles = [f"  tiles        {', '.join(str(tile['tile']) for tile in facts['tiles'])}"]
    return [f"  maps         {maps}; each has neutral and differences, weight maps are shared", *tiles]

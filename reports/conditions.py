"""The conditions under which a document's numbers hold, as rows of a list."""

from collections.abc import Mapping
from typing import Any

from facezip.documents.document import Data
from facezip.pack.facts import maps_on_tiles
from reports.metrics import FLOOR, METRICS, measured

LABELS = {
    "spp": "Samples per pixel",
    "max_spp": "Where the verdict is close",
    "sampler": "Sampler",
    "seed": "Seed",
    "resolution": "Render size",
    "views": "Views",
    "lights": "Lights",
    "material": "Skin",
    "transport": "Light transport",
    "maps_rendered": "Maps that light meets",
    "importance_of": "Importance of",
    "thresholds": "Limits",
    "confidence": "Confidence intervals",
    "debiased": "Free of the bias of noise",
    "region": "Image metrics over",
    "texture_region": "Texture metrics over",
    "display": "Display",
    "pixels_per_degree": "Pixels per degree",
    "astc_effort": "Effort of ASTC",
    "bc": "Encoders of BC",
    "variant": "Mitsuba variant",
    "mitsuba": "Mitsuba",
    "drjit": "Dr.Jit",
    "llvm": "LLVM",
}


def condition_rows(document: Data) -> list[tuple[str, str]]:
    """Label and value of every condition of a document: character, rendering, versions, time; known ones first."""
    conditions = document["conditions"]
    others = [key for key in conditions if key not in LABELS and key != "units"]
    keys = [key for key in LABELS if key in conditions] + others
    character = document["character"]
    # A page about many sizes has no one character.
    rows = [("Character", _character(character))] if "resolution" in character else []
    rows += [(LABELS.get(key, key.replace("_", " ").capitalize()), words(conditions[key])) for key in keys]
    if "seconds" in document:
        rows.append(("Time", ", ".join(f"{key} {value:.1f} s" for key, value in document["seconds"].items())))
    if document.get("pairs_per_second") is not None:
        rows.append(("Speed", f"{document['pairs_per_second']:.2f} pairs of renders a second"))
    return rows


def _character(character: Data) -> str:
    height, width = character["resolution"]
    several = maps_on_tiles(len(character["maps"]), len(character["tiles"]))
    return (
        f"{character['name']}: {len(character['expressions'])} expressions{several}, {width} × {height} "
        f"texels, {character['channels']} channels, {character['vertices']:,} vertices, {character['triangles']:,} "
        "triangles"
    )


def glossary(document: Data) -> list[tuple[str, str, str]]:
    """Label, meaning and unit of every metric that a document's packs have, and of the noise floor."""
    units = document["conditions"].get("units", {})
    units = units if isinstance(units, Mapping) else {}
    shown = measured(METRICS, document["packs"])
    rows = [(metric.label, metric.meaning, units.get(metric.key, metric.unit)) for metric in shown]
    return [*rows, (*FLOOR, units.get("noise_floor", ""))]


def words(value: Any) -> str:
    """Plain data as a person reads it: a mapping with a name as ``front (azimuth 38, elevation 6)``."""
    if isinstance(value, Mapping):
        inner = ", ".join(f"{key} {words(item)}" for key, item in value.items() if key != "name")
        name = str(value.get("name", ""))
        return f"{name} ({inner})" if name and inner else name or inner
    if isinstance(value, list):
        separator = "; " if any(isinstance(item, Mapping) for item in value) else ", "
        return separator.join(words(item) for item in value)
    if isinstance(value, float):
        return f"{value:g}"
    return "none" if value is None else str(value)

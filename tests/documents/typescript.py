"""TypeScript of published schemas, for the viewer and for the module of ``export --to three``."""

import json

from facezip.documents.published import published
from facezip.viewer.build import SOURCES

FILE = SOURCES / "src" / "published.ts"
NAMES = ("scene", "export")
HEAD = "// Made by `python -m tests.documents.make` from the published schemas (docs/documents.md); do not edit.\n"
PLAIN = {"string": "string", "integer": "number", "number": "number", "boolean": "boolean", "null": "null"}


def types():
    """The file: an interface for every part of the documents of :data:`NAMES`."""
    parts = {}
    for name in NAMES:
        parts |= json.loads(published(name))["$defs"]
    return HEAD + "".join(f"\n{_interface(name, part)}" for name, part in sorted(parts.items()))


def _interface(name, part):
    fields = (_field(key, value, key in part["required"]) for key, value in part["properties"].items())
    return f"/** {part['description']} */\nexport interface {name} {{\n{''.join(fields)}}}\n"


def _field(key, schema, required):
    words = f"  /** {schema['description']} */\n" if "description" in schema else ""
    return f"{words}  {key}{'' if required else '?'}: {_type(schema)};\n"


def _type(schema):
    if "$ref" in schema:
        return schema["$ref"].rpartition("/")[2]
    if "enum" in schema:
        return " | ".join(json.dumps(value) for value in schema["enum"])
    if "anyOf" in schema:
        return " | ".join(map(_type, schema["anyOf"]))
    if "prefixItems" in schema:
        return f"[{', '.join(map(_type, schema['prefixItems']))}]"
    if schema.get("type") == "array":
        items = _type(schema["items"])
        return f"({items})[]" if " | " in items else f"{items}[]"
    if schema.get("type") == "object":
        return f"Record<string, {_type(schema['additionalProperties'])}>"
    return PLAIN[schema["type"]] if schema else "unknown"

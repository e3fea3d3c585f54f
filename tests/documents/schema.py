"""JSON Schema (2020-12) of a document, from its dataclass: types, what is always there, and what docstrings say."""

import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from importlib import import_module
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from facezip.documents.published import PUBLISHED

DIALECT = "https://json-schema.org/draft/2020-12/schema"
PLAIN = {str: "string", int: "integer", float: "number", bool: "boolean", NoneType: "null"}
_ENTRY = re.compile(r"^(\w+(?:, \w+)*) : ", re.MULTILINE)

# A schema, or a part of one.
Schema = dict[str, Any]


def kind_of(name: str) -> Any:
    """The type of a published document."""
    module, _, kind = PUBLISHED[name].partition(":")
    return getattr(import_module(module), kind)


def schema_of(kind: Any, name: str) -> Schema:
    """The schema of a type, which is called ``name``: a dataclass, or several of which a document is one."""
    parts: dict[str, Schema] = {}
    whole = _of(kind, parts)
    return {"$schema": DIALECT, "title": name, **whole, "$defs": dict(sorted(parts.items()))}


def _of(kind: Any, parts: dict[str, Schema]) -> Schema:
    origin, of = get_origin(kind), get_args(kind)
    if kind is Any:
        return {}
    if kind in PLAIN:
        return {"type": PLAIN[kind]}
    if is_dataclass(kind):
        return _reference(kind, parts)
    if origin is Literal:
        return {"enum": list(of)}
    if origin in (Union, UnionType):
        return {"anyOf": [_of(one, parts) for one in of]}
    if origin is tuple and of[-1] is not Ellipsis:
        items = [_of(one, parts) for one in of]
        return {"type": "array", "prefixItems": items, "items": False, "minItems": len(of)}
    if origin in (tuple, list, Sequence):
        return {"type": "array", "items": _of(of[0], parts)}
    if origin in (dict, Mapping):
        return {"type": "object", "additionalProperties": _of(of[1], parts)}
    raise TypeError(f"no JSON stands for {kind}")


def _reference(kind: Any, parts: dict[str, Schema]) -> Schema:
    name = kind.__name__
    if name not in parts:
        # A part may hold itself.
        parts[name] = {}
        parts[name] |= _object(kind, parts)
    return {"$ref": f"#/$defs/{name}"}


def _object(kind: Any, parts: dict[str, Schema]) -> Schema:
    hints, said = get_type_hints(kind), _attributes(kind)
    properties, required = {}, []
    for field in fields(kind):
        hint = hints[field.name]
        if field.default is None:
            # Left out where there is nothing to say.
            hint = Union[tuple(one for one in get_args(hint) if one is not NoneType)]  # noqa: UP007
        else:
            required.append(field.name)
        properties[field.name] = _of(hint, parts)
        if field.name in said:
            properties[field.name]["description"] = said[field.name]
    summary = _words((inspect.getdoc(kind) or "").partition("\n\n")[0])
    return {"description": summary, "type": "object", "properties": properties, "required": required}


def _attributes(kind: type) -> dict[str, str]:
    """What docstrings of a dataclass, and of those that it is made of, say of its fields."""
    found: dict[str, str] = {}
    for one in reversed(kind.__mro__):
        _, _, section = inspect.cleandoc(one.__dict__.get("__doc__") or "").partition("Attributes\n----------\n")
        _, *entries = _ENTRY.split(section)
        for names, words in zip(entries[::2], entries[1::2], strict=True):
            found |= dict.fromkeys(names.split(", "), _words(words))
    return found


def _words(text: str) -> str:
    """Prose of a docstring in one line, without the markup of names."""
    return " ".join(re.sub(r":\w+:`(?:[\w.]*\.)?(\w+)`|``([^`]+)``", r"\1\2", text).split())

"""Documents as JSON, and back."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, TypeVar

D = TypeVar("D")
# A document as :func:`plain` gives it, for pages that show what is written.
Data = Mapping[str, Any]
# A TOML file as people wrote it, or a table of it: whoever reads it checks it.
Toml = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Document:
    """What one verb answers or one report writes.

    Parts of documents are frozen dataclasses as well. A field whose default is None is left out of the JSON where it is
    None; all others are always there.

    Attributes
    ----------
    format : ``facezip-NAME/VERSION``. A version may gain fields; one that loses or changes a field has another number.
    """

    format: str


def plain(value: Any) -> Any:
    """A copy of a document, or of a part, of dictionaries, lists, strings and Python's numbers alone.

    NaN and infinities, which JSON has no words for, become None.
    """
    if is_dataclass(value):
        pairs = ((field, getattr(value, field.name)) for field in fields(value))
        return {field.name: plain(item) for field, item in pairs if item is not None or field.default is not None}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        # numpy's arrays and numbers, without importing it.
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def to_json(document: Any, indent: int | None = 1) -> str:
    """A document as ASCII text, in the order of its fields; in one line where ``indent`` is None."""
    return json.dumps(plain(document), indent=indent, allow_nan=False)


def from_json(text: str | bytes, kind: type[D]) -> D:
    """The document or part of a kind that a text holds; ``ValueError``, which says where, where it holds none."""
    # Only what reads documents again waits for the import.
    import msgspec

    try:
        return msgspec.json.decode(text, type=kind)
    except msgspec.MsgspecError as error:
        raise ValueError(str(error)) from None


def from_plain(value: Any, kind: type[D]) -> D:
    """The same of plain data."""
    import msgspec

    try:
        return msgspec.convert(value, kind)
    except msgspec.MsgspecError as error:
        raise ValueError(str(error)) from None

"""What ``facezip export`` answers, by what takes it."""

from dataclasses import dataclass
from typing import Literal

from facezip.documents.document import Document
from facezip.export.documents.layers import LayersExport
from facezip.export.documents.tiles import ExportDocument, TilesDocument


@dataclass(frozen=True, kw_only=True)
class WebDocument(Document):
    """The viewer as one page.

    Attributes
    ----------
    output, bytes : the file.
    originals : whether the original textures are in it.
    """

    format: Literal["facezip-export-web/1"] = "facezip-export-web/1"
    output: str
    bytes: int
    originals: bool


Export = ExportDocument | TilesDocument | LayersExport

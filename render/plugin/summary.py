"""The results of a run as one document, and as the page that shows it."""

import json
from typing import Any

from facezip.files.writing import write_whole
from render.plugin.settings import Settings

FORMAT = "facezip-images/1"
JSON_FILE, HTML_FILE = "results.json", "index.html"


def write_summaries(results: list[dict[str, Any]], settings: Settings) -> None:
    """Write ``results.json`` and ``index.html`` as asked for; raises ``FaceZipError`` (``CANNOT_WRITE``)."""
    document = {"format": FORMAT, "results": sorted(results, key=lambda result: (result["name"], result["test"]))}
    settings.results.mkdir(parents=True, exist_ok=True)
    if "json" in settings.summaries:
        write_whole(settings.results / JSON_FILE, json.dumps(document, indent=1, allow_nan=False).encode())
    if "html" in settings.summaries:
        # The one place where rendering reaches for the pages that people read.
        from reports.regression import write_regression_report

        write_regression_report(document, settings.results / HTML_FILE)

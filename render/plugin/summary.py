"""The results of a run as one document, and as the pages that show it."""

from facezip.documents.document import to_json
from facezip.files.writing import write_whole
from render.plugin.results import ImagesDocument
from render.plugin.run import Run

JSON_FILE, HTML_FILE = "results.json", "index.html"


def write_summaries(run: Run) -> None:
    """Write ``results.json``, ``index.html`` and Markdown as asked for; raises ``FaceZipError`` (``CANNOT_WRITE``)."""
    settings = run.settings
    results = sorted(run.results, key=lambda result: (result.name, result.test))
    document = ImagesDocument(results=results, stale=run.stale, idle=run.idle)
    if settings.summaries:
        settings.results.mkdir(parents=True, exist_ok=True)
    if "json" in settings.summaries:
        write_whole(settings.results / JSON_FILE, to_json(document).encode())
    # The one place where rendering reaches for the pages that people read.
    if "html" in settings.summaries:
        from reports.regression import write_regression_report

        write_regression_report(document, settings.results / HTML_FILE)
    if settings.markdown:
        from reports.comment import write_comment

        write_comment(document, settings.markdown)

"""``facezip schema``: the JSON Schema of what other verbs answer with ``--json``."""

import click

from facezip.documents.published import PUBLISHED, published


@click.command("schema")
@click.argument("name", type=click.Choice(list(PUBLISHED)), required=False, metavar="[NAME]")
def command(name: str | None) -> None:
    """Print the JSON Schema of documents called NAME, or all names.

    NAME is what stands in a document's "format", between "facezip-" and "/". A document of that version has all that
    its schema requires; it may gain fields. One that loses or changes a field has another version.
    """
    print(published(name) if name else "\n".join(PUBLISHED), end="" if name else "\n")

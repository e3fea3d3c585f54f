"""``python -m tests.documents.make``: write schemas and their TypeScript anew, after a document has changed."""

import json

from facezip.documents.published import PUBLISHED, SCHEMAS
from tests.documents.schema import kind_of, schema_of
from tests.documents.typescript import FILE, types


def made(name):
    """The text of the schema of a document, as its type is now."""
    return json.dumps(schema_of(kind_of(name), name), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    for path in SCHEMAS.glob("*.json"):
        path.unlink()
    for name in PUBLISHED:
        (SCHEMAS / f"{name}.json").write_text(made(name), encoding="utf-8")
    FILE.write_text(types(), encoding="utf-8")

"""Docstrings of this project as the API reference of the site reads them: an extension of Griffe (``zensical.toml``).

Here a parameter is ``name : what it is``, and types stand in the signature. NumPy's style would take those words for
the type. Google's style, into which this turns them, has a place for each.
"""

import re
from typing import Any

import griffe

SECTIONS = {"Parameters": "Args", "Attributes": "Attributes", "Returns": "Returns", "Raises": "Raises"}
HEADING = re.compile(rf"^({'|'.join(SECTIONS)})\n-+\n", re.MULTILINE)
ROLE = re.compile(r":\w+:`~?([\w.]+)`")


class HouseStyle(griffe.Extension):
    """Turns every docstring into Google's style before it is parsed."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Change the docstring of a module, class, function or attribute."""
        if obj.docstring is not None:
            obj.docstring.value = google(obj.docstring.value)


def google(text: str) -> str:
    """A docstring of this project, in Google's style.

    Parameters
    ----------
    text : without the indentation of the code.

    """
    before, *sections = HEADING.split(ROLE.sub(lambda role: f"`{role[1].rsplit('.', 1)[-1]}`", text))
    parts = [before.rstrip()]
    for heading, content in zip(sections[::2], sections[1::2], strict=True):
        entries = [" ".join(content.split())] if heading == "Returns" else list(_entries(content))
        parts.append("\n".join([f"{SECTIONS[heading]}:", *(f"    {entry}" for entry in entries)]))
    return "\n\n".join(parts)


def _entries(content: str) -> list[str]:
    """``name: words`` for each of a section; words of two names stand at both."""
    entries: list[tuple[str, list[str]]] = []
    for line in content.strip().splitlines():
        if line.startswith(" "):
            entries[-1][1].append(line.strip())
        elif line:
            names, _, words = line.partition(" : ")
            entries.append((names, [words] if words else []))
    return [f"{name.strip()}: {' '.join(words)}" for names, words in entries for name in names.split(",")]

"""The lock file pins what is bundled and names no place that it came from; the head is for any page."""

import json
import re

from facezip.viewer.build import SOURCES

LOCK = json.loads((SOURCES / "package-lock.json").read_text())
PACKAGE = json.loads((SOURCES / "package.json").read_text())


def test_every_package_is_pinned_by_version_and_checksum():
    packages = {name: entry for name, entry in LOCK["packages"].items() if name}
    assert packages
    for name, entry in packages.items():
        assert entry["version"], name
        assert entry["integrity"].startswith("sha512-"), name
    for name, version in (PACKAGE["dependencies"] | PACKAGE["devDependencies"]).items():
        assert packages[f"node_modules/{name}"]["version"] == version


def test_no_download_address_is_recorded():
    assert "resolved" not in (SOURCES / "package-lock.json").read_text()
    assert "://" not in (SOURCES / "package.json").read_text()


def test_the_head_knows_nothing_of_the_page_around_it():
    sources = [*(SOURCES / "src" / "head").glob("*.ts")]
    assert sources
    for source in sources:
        text = source.read_text()
        # Types of the published document are of Python's, and gone once compiled.
        places = re.findall(r'from "(.*?)"', re.sub(r'import type [^;]* from "\.\./published";', "", text))
        assert all(re.match(r"three(/|$)|\./", place) for place in places), source.name
        # A document there is what Python wrote, not the browser's.
        assert not re.search(r"\b(window|globalThis|getElementById|querySelector|createElement)\b", text), source.name

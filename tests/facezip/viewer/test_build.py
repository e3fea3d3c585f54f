"""The lock file pins what is bundled and names no place that it came from."""

import json

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

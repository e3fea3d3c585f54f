"""Commands that reports record: a shell takes them apart into what was called, whatever the names are."""

import shlex
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from facezip.commands import animate, paper
from facezip.commands.words import call
from reports.paper.experiments import Settings

names = st.text(st.characters(exclude_characters="\0/"), min_size=1).map(lambda name: f"x{name}")


@given(st.lists(names))
def test_a_shell_takes_a_call_apart(words):
    assert shlex.split(call(*words)) == ["facezip", *words]


@given(names, names)
def test_records_name_scans_and_packs_of_any_name(scans, pack):
    words = shlex.split(animate._call(Path(scans), Path(pack), 3, {"resolution": 32}))
    assert words == ["facezip", "animate", scans, pack, "-o", "DIR", "--frames", "3", "--resolution", "32"]
    words = shlex.split(paper._call(Path(scans), None, Path(pack), 20, [64], Settings()))
    assert words[:7] == ["facezip", "paper", scans, "-o", pack, "--resolution", "64"]

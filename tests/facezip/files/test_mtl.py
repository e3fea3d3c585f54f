"""Images that material libraries name are found behind any options, in any folder, whatever their names hold."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip.files.mtl import images_by_material, read_mtl
from facezip.names import folded

WORD = st.text("abcXYZ019_.é<>", min_size=1, max_size=8)
FILE = st.lists(WORD, min_size=1, max_size=3).map(" ".join).map(lambda name: f"n{name}.png")
PLACE = st.sampled_from(["", "maps/", "C:\\scans\\", "../", "a b/"])
OPTION = st.sampled_from(
    [
        *("-blendu on", "-clamp off", "-bm 0.5", "-imfchan r", "-texres 512", "-mm 0 1", "-type sphere"),
        *("-s 1 1 1", "-o 0.5", "-o -.5 1e-2", "-t 0 0 0", "-s 2 2"),
    ]
)
KEY = st.sampled_from(["map_Kd", "map_Ka", "map_Bump", "bump", "norm", "disp", "map_kd", "MAP_KD"])
LINE = st.tuples(KEY, st.lists(OPTION, max_size=3), PLACE, FILE)
MATERIAL = st.tuples(WORD, st.lists(LINE, max_size=3))


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("mtl")


@settings(deadline=None)
@given(
    st.lists(st.tuples(WORD, st.lists(LINE, max_size=3)), max_size=3), st.sampled_from(["\n", "\r\n"]), st.booleans()
)
def test_every_image_is_found(place, materials, end, marked):
    text = ["# by hand", ""]
    for name, lines in materials:
        text += [f"newmtl {name}", "Kd 1 1 1", "illum 2"]
        text += [" ".join([f"\t{key}", *options, folder + file]) for key, options, folder, file in lines]
    content = end.join(text).encode("utf-8-sig" if marked else "utf-8")
    (place / "head.mtl").write_bytes(content)
    expected = [(name, key.lower(), file) for name, lines in materials for key, _, _, file in lines]
    assert list(read_mtl(place / "head.mtl")) == expected
    found = images_by_material(place)
    assert {(name, folded(file)) for name, _, file in expected} == {(n, file) for n in found for file in found[n]}

"""Published schemas are current, and describe what verbs answer (every test that runs a verb with --json checks it)."""

import json
from dataclasses import dataclass, fields
from itertools import product
from pathlib import Path
from typing import Literal, get_args, get_type_hints

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from jsonschema import Draft202012Validator, ValidationError

from facezip.character.loading import save_character
from facezip.cli import VERBS
from facezip.documents.document import Document, from_json, plain, to_json
from facezip.documents.published import PUBLISHED, SCHEMAS, published
from facezip.export import TARGETS
from facezip.fit.methods import compress
from facezip.pack.write import write_pack
from facezip.viewer.scene import read_scene
from tests.documents.checked import check
from tests.documents.make import made
from tests.documents.schema import kind_of, schema_of
from tests.documents.typescript import FILE, types
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface
from tests.test_layered_commands import run


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_schema_is_that_of_its_document_and_says_its_format(name):
    """After a change that is meant: python -m tests.documents.make."""
    assert published(name) == made(name)
    Draft202012Validator.check_schema(json.loads(published(name)))
    kind = kind_of(name)
    for one in get_args(kind) or (kind,):
        (said,) = get_args(get_type_hints(one)["format"])
        assert said.startswith(f"facezip-{name}/")
        assert one.format == said


def test_the_viewer_s_types_are_those_of_its_documents():
    """``make viewer`` checks the viewer against them."""
    assert FILE.read_text(encoding="utf-8") == types()


def test_nothing_else_is_published():
    assert {path.stem for path in SCHEMAS.iterdir()} == {*PUBLISHED}


@pytest.mark.parametrize("name", PUBLISHED)
def test_every_field_of_a_document_says_what_it_is(name):
    whole = json.loads(published(name))["$defs"]
    kind = kind_of(name)
    for one in get_args(kind) or (kind,):
        properties = whole[one.__name__]["properties"]
        assert [field for field, schema in properties.items() if "description" not in schema] == []


def test_a_schema_is_printed_and_all_are_listed():
    assert run("schema", "compress").stdout == published("compress")
    assert run("schema").stdout.split() == list(PUBLISHED)
    assert run("schema", "nothing").returncode == 2


@dataclass(frozen=True, kw_only=True)
class Part:
    """A part of a document, with a field of each kind."""

    word: str
    number: float | None
    numbers: tuple[int, ...]
    pair: tuple[int, float]
    by_name: dict[str, bool]
    one_of: Literal["a", "b"]
    rest: float | None = None


@dataclass(frozen=True, kw_only=True)
class Whole(Document):
    """A document that is none of ours."""

    format: Literal["facezip-whole/1"] = "facezip-whole/1"
    part: Part
    parts: list[Part]
    more: Part | None = None


# Letters that JSON escapes, and some that it does not.
_text = some.text('a"\\\n\u00e9\U0001f600', max_size=4)
_finite = some.floats(allow_nan=False, allow_infinity=False)
PARTS = some.builds(
    Part,
    word=_text,
    number=some.none() | _finite,
    numbers=some.lists(some.integers(-(2**53), 2**53), max_size=3).map(tuple),
    pair=some.tuples(some.integers(0, 9), _finite),
    by_name=some.dictionaries(_text, some.booleans(), max_size=3),
    one_of=some.sampled_from(["a", "b"]),
    rest=some.none() | _finite,
)
WHOLES = some.builds(Whole, part=PARTS, parts=some.lists(PARTS, max_size=3), more=some.none() | PARTS)


@given(WHOLES)
def test_what_is_written_is_described_and_reads_back_as_the_same(document):
    text = to_json(document)
    Draft202012Validator(schema_of(Whole, "whole")).validate(json.loads(text))
    assert from_json(text, Whole) == document
    assert ("more" in json.loads(text)) == (document.more is not None)


@given(WHOLES, some.sampled_from([field.name for field in fields(Part) if field.name != "rest"]))
def test_a_document_without_a_field_is_refused(document, name):
    data = plain(document)
    del data["part"][name]
    with pytest.raises(ValidationError):
        Draft202012Validator(schema_of(Whole, "whole")).validate(data)
    with pytest.raises(ValueError, match=name):
        from_json(json.dumps(data), Whole)


def test_numbers_of_numpy_are_numbers_and_what_is_not_finite_is_null():
    given = {"a": np.float32(0.5), 3: np.arange(2), "c": [np.inf, float("nan")], "d": (np.bool_(True),)}
    assert plain(given) == {"a": 0.5, "3": [0, 1], "c": [None, None], "d": [True]}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("documents")
    save_character(random_surface(expressions=4, tiles=(2, 1)), folder / "tiled")
    save_character(random_character(side=64), folder / "plain")
    write_pack(compress(random_character(side=64), "masks", masks=5, differences=2), folder / "masks.facezip")
    clamped = compress(random_character(side=64), "masks", masks=5, differences=2, nonnegative=True)
    write_pack(clamped, folder / "clamped.facezip")
    write_pack(compress(random_surface(expressions=4, tiles=(2, 1)), differences=2), folder / "tiled.facezip")
    return folder


def answers(place, *words):
    done = run(*(place / word[1:] if word.startswith("@") else word for word in words), "--json")
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("alignment", "check @plain"),
        ("alignment", "check @plain -o @checked --register @moved"),
        ("compress", "compress @plain -o @a.facezip --target-rmse 9 --clean all"),
        ("decompress", "decompress @masks.facezip -o @textures"),
        ("doctor", "doctor @tiled"),
        ("doctor", "doctor @masks.facezip"),
        ("error", "info @nothing"),
        ("error", "info"),
        ("info", "info @masks.facezip"),
        ("layers", "layers @masks.facezip -o @page"),
        ("verify", "verify @tiled.facezip"),
    ],
)
def test_a_verb_answers_as_published(place, name, line):
    assert check(answers(place, *line.split())) == name


ENGINES = ("gltf", "unity", "unreal", "godot", "three", "blender", "usd")
OF_LAYERS = ("metahuman", "o3de")


@pytest.mark.parametrize(
    ("target", "pack"),
    [*product(ENGINES, ("masks", "tiled")), *product(OF_LAYERS, ("clamped",))],
)
def test_an_export_is_as_published_and_so_is_its_record(place, target, pack):
    out = f"{target}-{pack}"
    answer = answers(place, "export", f"@{pack}.facezip", "--to", target, "-o", f"@{out}")
    record = json.loads((place / out / "facezip.json").read_bytes())
    assert check(answer) == check(record) == "export"
    assert {**record, "output": answer["output"], "bytes": answer["bytes"]} == answer


@pytest.mark.parametrize("pack", ["masks", "tiled"])
def test_a_manifest_and_a_scene_are_as_published(place, pack):
    path = place / f"{pack}.facezip"
    assert check(json.loads((path / "manifest.json").read_bytes())) == "pack"
    assert check(plain(read_scene(path).document)) == "scene"


def test_exports_to_every_target_are_tried():
    assert {*TARGETS} == {*ENGINES, *OF_LAYERS, "web"}


def test_every_verb_is_in_the_page_of_documents():
    page = (Path(__file__).parents[2] / "docs/documents.md").read_text(encoding="utf-8")
    assert [verb for verb in VERBS if f"`{verb}`" not in page and f"`{verb} " not in page] == []
    assert [name for name in PUBLISHED if f"`{name}`" not in page] == []

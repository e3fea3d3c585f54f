"""Which characters a batch is asked for."""

import pytest

from facezip.batch.jobs import find_jobs
from facezip.errors import ErrorCode, FaceZipError


@pytest.fixture
def library(tmp_path):
    for name in ("anna", "bert"):
        (tmp_path / "library" / name).mkdir(parents=True)
        (tmp_path / "library" / name / "neutral.obj").touch()
    (tmp_path / "library" / "cleo.glb").touch()
    (tmp_path / "library" / "notes").mkdir()
    return tmp_path / "library"


def names(*sources):
    return [job.name for job in find_jobs(sources)]


def listed(library, text):
    path = library.parent / "jobs.toml"
    path.write_text(text)
    return find_jobs([path])


def test_a_folder_of_characters_is_the_same_as_naming_each(library):
    assert names(library) == ["anna", "bert", "cleo"]
    assert names(library) == names(library / "anna", library / "bert", library / "cleo.glb")


@pytest.mark.parametrize("mesh", ["Neutral.OBJ", "base.obj", "000_neutral.obj"])
def test_a_character_is_one_however_its_neutral_is_called(library, mesh):
    (library / "anna" / "neutral.obj").rename(library / "anna" / mesh)
    (library / "notes" / "._neutral.obj").touch()
    assert names(library) == ["anna", "bert", "cleo"]


def test_a_character_may_have_its_meshes_in_a_folder_of_their_own(library):
    (library / "dora" / "geo").mkdir(parents=True)
    (library / "dora" / "geo" / "neutral.obj").touch()
    assert names(library) == ["anna", "bert", "cleo", "dora"]


def test_what_is_left_out_of_a_library_is_said_but_for_packs_and_exports(library, caplog):
    (library / "packs" / "anna.facezip").mkdir(parents=True)
    (library / "packs" / "anna.facezip" / "manifest.json").touch()
    (library / "shipped").mkdir()
    (library / "shipped" / "facezip.json").touch()
    assert names(library) == ["anna", "bert", "cleo"]
    (message,) = caplog.messages
    assert message.startswith(f"{library / 'notes'}: no character, and left out")


def test_what_is_no_character_is_left_to_fail_alone(library):
    assert names(library / "anna", library / "notes", library / "nobody") == ["anna", "notes", "nobody"]


def test_a_list_gives_names_and_settings_and_what_stands_above_holds_for_all(library):
    text = (
        'seed = 1\n[[character]]\npath = "library/anna"\n[[character]]\npath = "library/anna"\nname = "b"\nseed = 2\n'
    )
    jobs = listed(library, text)
    assert [(job.name, job.character, job.settings) for job in jobs] == [
        ("anna", library / "anna", {"seed": 1}),
        ("b", library / "anna", {"seed": 2}),
    ]


@pytest.mark.parametrize(
    "text",
    [
        *("", "[[character]]\n", "character = 3", "[character]\npath = 'a'", "[[character]]\npath = 3", "[["),
        "[[character]]\npath = ''",
        pytest.param("a = " + "[" * 9999, id="nested without end"),
    ],
)
def test_a_list_without_paths_is_refused(library, text):
    with pytest.raises(FaceZipError, match=r"jobs\.toml: .*docs/batch\.md"):
        listed(library, text)


@pytest.mark.parametrize("name", ["anna", "ANNA", "../anna", "neutral", ".hidden"])
def test_names_are_different_file_names(library, name):
    text = f'[[character]]\npath = "library/anna"\n[[character]]\npath = "library/bert"\nname = "{name}"\n'
    with pytest.raises(FaceZipError) as caught:
        listed(library, text)
    assert caught.value.code is ErrorCode.BAD_VALUE

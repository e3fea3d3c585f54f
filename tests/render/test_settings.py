import pytest

from facezip import FaceZipError
from facezip.documents.document import plain
from facezip.errors import ErrorCode
from render.limits import Limit, Thresholds
from render.settings import Settings, read_settings
from scenes.cameras import VIEWS, View

FILE = """
views = ["front", { name = "ear", azimuth = 75, extent = 0.3, aim = [0.1, 0] }]
lights = ["daylight"]
material = "diffuse"
transport = "full"
resolution = 256
spp = 8
max_spp = 32
seed = 5
[thresholds]
indistinguishable = { delta_e = 0.5, flip = 0.02, local = 1.5 }
visible = { delta_e = 2 }
"""


def written(folder, text):
    path = folder / "look.toml"
    path.write_text(text)
    return path


def test_without_a_file_there_are_defaults():
    assert read_settings(None, {}) == Settings()


def test_a_file_says_everything(tmp_path):
    limits = Thresholds(Limit(0.5, 1.5, 0.02), Limit(2.0, 6.0, 0.10))
    views = (VIEWS[0], View("ear", azimuth=75.0, extent=0.3, aim=(0.1, 0.0)))
    expected = Settings(views, ("daylight",), "diffuse", "full", 256, 8, 32, 5, limits)
    assert read_settings(written(tmp_path, FILE), {}) == expected


def test_the_command_line_goes_before_the_file(tmp_path):
    settings = read_settings(written(tmp_path, FILE), {"views": 3, "spp": 4})
    assert (settings.views, settings.spp, settings.seed) == (VIEWS[:3], 4, 5)


def test_what_is_resolved_reads_back_as_the_same(tmp_path):
    settings = read_settings(written(tmp_path, FILE), {})
    assert read_settings(None, plain(settings.resolved)) == settings.resolved


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("view = 2", "'view' is no setting"),
        ("views = 0", "views 0"),
        ('views = ["behind"]', "'behind'"),
        ("views = []", "at least one"),
        ("views = 1.5", "views 1.5"),
        ('views = [{ name = "a/b" }]', "a/b"),
        ('views = [{ name = "a", zoom = 2 }]', "zoom"),
        ('views = ["front", { name = "front" }]', "one name"),
        ("lights = 99", "lights 99"),
        ('lights = "studio"', "lights 'studio'"),
        ("spp = 3", "spp 3"),
        ("spp = 14", "16 does"),
        ('spp = "many"', "spp 'many'"),
        ("resolution = 1", "resolution 1"),
        ('material = "chrome"', "chrome"),
        ('transport = "photon"', "photon"),
        ("seed = -1", "seed -1"),
        ("[thresholds]\nfine = { flip = 1 }", "'fine'"),
        ("[thresholds]\nvisible = { delta_e = 0.5 }", "not below"),
        ("spp =", "not TOML"),
    ],
)
def test_what_is_wrong_is_said_in_one_line_with_the_file(tmp_path, text, named):
    path = written(tmp_path, text)
    with pytest.raises(FaceZipError, match=str(path)) as caught:
        read_settings(path, {})
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FaceZipError, match=r"nowhere\.toml"):
        read_settings(tmp_path / "nowhere.toml", {})

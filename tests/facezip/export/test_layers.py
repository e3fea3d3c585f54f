"""Layers, masks and curves for engines that mix pictures, held against the pack by the engines' own rules."""

import csv
import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from facezip import FaceZipError
from facezip.character.maps import KNOWN, Map, angles
from facezip.errors import ErrorCode, ExitCode
from facezip.export import TARGETS
from facezip.export.examination import examine_export
from facezip.export.mixing import Rule, mixed_of, stored_of
from facezip.files.glb import Glb
from facezip.files.images import read_texture_exactly, write_texture
from facezip.machine import memory
from facezip.pack.masked import MaskedWeights
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.documents.checked import check
from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import KINDS, files_of, grey, layered_model, smooth_model
from tests.facezip.export.layers import MetaHuman, O3de, encoded, image, linear
from tests.facezip.export.wrinkled import COUNT, LAYERS, NAMES, write_wrinkled
from tests.test_layered_commands import run

# One step of 8 bits: of a colour in 255 levels, and of a normal whose x or y is off by it.
STEP, STEP_ANGLE = 1.0, np.degrees(2 / 255)
BLENDS = [{"expr_1": 0.5, "expr_2": 0.5}, {"expr_1": 0.3, "expr_2": 0.2, "expr_4": 0.4}]
ENGINES = {"metahuman": MetaHuman, "o3de": O3de}


@pytest.fixture(scope="module")
def wrinkles(tmp_path_factory):
    """Scans and masks on disk, compressed and exported by the command line, as a technical artist does."""
    folder = tmp_path_factory.mktemp("wrinkles")
    write_wrinkled(folder)
    options = ("--given-masks", folder / "masks", "--differences", 3)
    done = run("compress", folder / "scans", "-o", folder / "me.facezip", *options)
    assert done.returncode == 0, done.stderr
    for target in ENGINES:
        done = run("export", folder / "me.facezip", "--to", target, "-o", folder / target, "--json")
        assert done.returncode == 0, done.stderr
        stored = json.loads((folder / target / "facezip.json").read_text(encoding="utf-8"))
        assert json.loads(done.stdout).items() > stored.items()
    return folder


def gaps(wrinkles, target, map, blend):
    """Between what the engine shows of the exported files and what the pack shows: levels of 255, or degrees."""
    seen = getattr(ENGINES[target](wrinkles / target), map)(blend)
    wanted = read_pack(wrinkles / "me.facezip").blend(blend, map=map)
    return angles(seen.astype(np.float32), wanted) if map == "normal" else 255 * np.abs(seen - wanted)


def rmse(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_metahumans_material_shows_the_pack_within_a_step_of_8_bits(wrinkles):
    """Three layers and twelve masks that overlap: albedo and normals, of every expression and of blends.

    The neutral and each layer are rounded once, to half a step; a texel mixes them with shares whose sizes add up to
    1 + 2 (Σ_i w_i - 1) at most where masks overlap. What is left is the mixing of light where the pack adds encoded
    values, which the layers are fitted to.
    """
    for blend in ({}, *({f"expr_{n}": 1.0} for n in range(COUNT)), *BLENDS):
        assert gaps(wrinkles, "metahuman", "albedo", blend).max() <= STEP
        assert gaps(wrinkles, "metahuman", "normal", blend).max() <= STEP_ANGLE


def test_o3des_material_shows_the_packs_expressions_within_8_bits(wrinkles):
    """Masks are rounded too, and laid on in turn layers multiply what is sampled; sums of expressions hide more."""
    for blend in ({}, *({f"expr_{n}": 1.0} for n in range(COUNT))):
        colour, angle = (gaps(wrinkles, "o3de", map, blend) for map in ("albedo", "normal"))
        assert rmse(colour) <= STEP / 2
        assert colour.max() <= 4 * STEP
        assert angle.mean() <= STEP_ANGLE / 2
        assert angle.max() <= 4 * STEP_ANGLE
    for blend in BLENDS:
        assert rmse(gaps(wrinkles, "o3de", "albedo", blend)) <= STEP
        assert gaps(wrinkles, "o3de", "normal", blend).mean() <= STEP_ANGLE


@pytest.mark.parametrize("target", ENGINES)
def test_what_is_stated_is_what_the_engine_shows(wrinkles, target):
    maps = json.loads((wrinkles / target / "facezip.json").read_text(encoding="utf-8"))["maps"]
    names = [f"expr_{n}" for n in range(COUNT)]
    colours = {name: gaps(wrinkles, target, "albedo", {name: 1.0}) for name in names}
    turns = {name: gaps(wrinkles, target, "normal", {name: 1.0}) for name in names}
    mixed = [rmse(gaps(wrinkles, target, "albedo", {one: 0.5, other: 0.5})) for one, other in pairwise(names)]
    found = maps["albedo"]
    assert found["rmse_per_expression"] == pytest.approx({name: rmse(gap) for name, gap in colours.items()}, rel=1e-3)
    assert found["rmse"] == pytest.approx(np.mean([rmse(gap) for gap in colours.values()]), rel=1e-3)
    assert found["rmse_blends"] == pytest.approx(np.mean(mixed), rel=1e-3)
    assert found["rmse_largest"] == pytest.approx(max(gap.max() for gap in colours.values()), rel=1e-3)
    assert maps["normal"]["angular_error"] == pytest.approx(np.mean([gap.mean() for gap in turns.values()]), rel=1e-3)
    assert maps["normal"]["angular_error_largest"] == pytest.approx(max(gap.max() for gap in turns.values()), rel=1e-2)


@pytest.mark.parametrize("change", [0.5, 0.3])
def test_a_layer_is_not_the_neutral_and_its_difference(change, tmp_path):
    """Light is mixed and encoded values are added: such a layer would show another colour at a weight of 0.4."""
    model, half = clamped(names=("head_wm1_a",), activation=0.4), np.float32(0.5)
    part = model.parts["albedo", 1001]
    flat = replace(part, neutral=half + 0 * part.neutral, differences=change + 0 * part.differences)
    document = export(replace(model, parts={("albedo", 1001): flat}), tmp_path, "metahuman")
    wanted = read_pack(tmp_path / "me.facezip").reconstruct("expr_0")
    neutral, layer = linear(read_pack(tmp_path / "me.facezip").parts["albedo", 1001].neutral), linear(0.5 + change)
    plain = 255 * np.abs(encoded(neutral + activation_of(0.4) * (layer - neutral)) - wanted)
    assert document.maps["albedo"].rmse <= STEP / 2
    assert plain.min() > 4 * STEP


def activation_of(value):
    return float(np.float16(value))


def test_the_neutral_is_the_packs(wrinkles):
    part = read_pack(wrinkles / "me.facezip").parts["albedo", 1001]
    for target, name in (("metahuman", "head_color_map"), ("o3de", "head_basecolor")):
        stored = read_texture_exactly(wrinkles / target / f"{name}.png")
        np.testing.assert_array_equal(stored, np.rint(255 * part.neutral))


def test_curves_are_named_after_the_masks_and_drive_the_layers_that_masks_toml_says(wrinkles):
    folder = wrinkles / "metahuman"
    document = json.loads((folder / "curves.json").read_text(encoding="utf-8"))
    driven = {
        f"head_{prefix}{layer + 1}_{what}_{name}": {
            "map": f"head_{prefix}{layer + 1}_{what}_map.png",
            "mask": f"masks/{name}.png",
        }
        for prefix, what in (("cm", "color"), ("wm", "normal"))
        for name, layers in LAYERS.items()
        for layer in layers
    }
    assert check(document) == "curves"
    assert document["curves"] == driven
    stated = json.loads((folder / "facezip.json").read_text(encoding="utf-8"))
    assert stated["curves"].keys() == driven.keys()
    assert stated["notes"] == []
    assert stated["curves"]["head_wm3_normal_head_wm13_region0"] == {"map": "normal", "layer": 3, "mask": NAMES[0]}


def test_curves_are_the_activations_in_both_files(wrinkles):
    folder, weights = wrinkles / "metahuman", read_pack(wrinkles / "me.facezip").masked
    document = json.loads((folder / "curves.json").read_text(encoding="utf-8"))
    with open(folder / "curves.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["expression"] for row in rows] == [f"expr_{n}" for n in range(COUNT)]
    for n, row in enumerate(rows):
        values = {name: float(value) for name, value in row.items() if name != "expression"}
        assert document["expressions"][f"expr_{n}"] == {name: value for name, value in values.items() if value}
        for k, name in enumerate(weights.names):
            for layer in LAYERS[name]:
                curves = (f"head_cm{layer + 1}_color_{name}", f"head_wm{layer + 1}_normal_{name}")
                assert {values[curve] for curve in curves} == {weights.activations[n, k, layer]}
    for name, mask in zip(weights.names, weights.masks[1001], strict=True):
        np.testing.assert_array_equal(read_texture_exactly(folder / "masks" / f"{name}.png")[..., 0], mask)


def test_the_ending_of_a_masks_file_is_in_no_curve(tmp_path):
    export(clamped(names=("head_wm1_jawOpen_msk",)), tmp_path, "metahuman")
    curves = json.loads((tmp_path / "out" / "curves.json").read_text(encoding="utf-8"))["curves"]
    assert curves.keys() == {"head_cm1_color_head_wm1_jawOpen"}


def test_o3de_finds_everything_by_name(wrinkles):
    folder = wrinkles / "o3de"
    values = json.loads((folder / "head.material").read_text(encoding="utf-8"))["propertyValues"]
    textures = {value for name, value in values.items() if name.split(".")[1].rstrip("1234") in TEXTURES}
    images = {file.name for file in folder.glob("*.png")}
    assert textures == images
    assert len(images) == 2 * (1 + 3)
    assert values["wrinkleLayers.count"] == 3
    assert all(value == "Tiled" for name, value in values.items() if name.endswith("Uv"))
    document = Glb.read(folder / "head.glb").document
    (mesh,) = document["meshes"]
    masks = [f"{name}_wrinklemask.tif" for name in mesh["extras"]["targetNames"]]
    assert sorted(file.name for file in (folder / "head_wrinklemasks").iterdir()) == sorted(
        [*masks, *(f"{mask}.assetinfo" for mask in masks)]
    )
    assert all(read_texture_exactly(folder / "head_wrinklemasks" / mask).shape == (8, 8, 4) for mask in masks)


TEXTURES = {"textureMap", "baseColorMap", "normalMap"}


@pytest.mark.parametrize("target", ENGINES)
def test_an_export_is_the_same_each_time_and_in_any_memory(wrinkles, target, tmp_path, monkeypatch):
    TARGETS[target](wrinkles / "me.facezip", tmp_path / "again")
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(10**6, tmp_path):
        TARGETS[target](wrinkles / "me.facezip", tmp_path / "streamed")
    assert files_of(tmp_path / "again") == files_of(tmp_path / "streamed") == files_of(wrinkles / target)


@pytest.mark.parametrize("target", ENGINES)
def test_doctor_knows_every_file_of_it(wrinkles, target, tmp_path):
    TARGETS[target](wrinkles / "me.facezip", tmp_path / "out")
    sound = examine_export(tmp_path / "out")
    assert (sound.refusals, sound.notes) == ((), ())
    files = {file.relative_to(tmp_path / "out").as_posix() for file in (tmp_path / "out").rglob("*") if file.is_file()}
    assert {row.file for row in sound.rows} == files - {"facezip.json"}
    colours = [row for row in sound.rows if "color" in row.file and row.file.endswith(".png")]
    assert {row.encoding for row in colours} == {"sRGB"}
    mask = next(file for file in sorted(files) if file.endswith((".tif", "region1.png")))
    texels = read_texture_exactly(tmp_path / "out" / mask)
    write_texture(tmp_path / "out" / mask, texels, compression=0)
    assert not any(note.asks for note in examine_export(tmp_path / "out").notes)
    write_texture(tmp_path / "out" / mask, texels ^ 1)
    (note,) = examine_export(tmp_path / "out").notes
    assert (note.file, note.asks) == (mask, True)
    (tmp_path / "out" / mask).unlink()
    (refusal,) = examine_export(tmp_path / "out").refusals
    assert mask in refusal.words


def test_a_person_reads_what_mixing_adds_and_what_stays_behind(tmp_path):
    model = layered_model(smooth_model, (KINDS[0], KINDS[2], KINDS[3]), side=32, weights=4, slots=2)
    model = replace(model, weights={1001: np.abs(model.weights[1001])})
    write_pack(model, tmp_path / "me.facezip")
    done = run("export", tmp_path / "me.facezip", "--to", "o3de", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert "  albedo: the engine's mixing adds" in done.stdout
    assert "degrees to the expressions" in done.stdout
    assert "  roughness: O3DE mixes colours and normals alone" in done.stdout
    assert (tmp_path / "out" / "head_roughness.png").is_file()
    material = json.loads((tmp_path / "out" / "head.material").read_text(encoding="utf-8"))["propertyValues"]
    assert material["roughness.textureMap"] == "head_roughness.png"


def test_masks_of_other_names_are_exported_and_said(tmp_path):
    document = export(clamped(names=("brow", "head_wm1_jawOpen")), tmp_path, "metahuman")
    (note,) = document.notes
    assert note.startswith("1 masks are not named as those of a MetaHuman (head_wm1_…), such as 'brow'")


def test_values_that_images_cannot_hold_are_counted(tmp_path):
    """A layer that a small weight shows has to be far away: where it is beyond black, it is cut, and that is stated."""
    model = clamped(names=("head_wm1_a",), activation=0.25)
    part = model.parts["albedo", 1001]
    far = replace(part, neutral=np.full_like(part.neutral, 0.5), differences=np.full_like(part.differences, -2.0))
    document = export(replace(model, parts={("albedo", 1001): far}), tmp_path, "metahuman")
    assert document.maps["albedo"].beyond == 1
    assert (image(tmp_path / "out" / "head_cm1_color_map.png") == 0).all()
    near = replace(far, differences=np.full_like(part.differences, -0.2))
    again = export(replace(model, parts={("albedo", 1001): near}), tmp_path, "metahuman", overwrite=True)
    assert again.maps["albedo"].beyond == 0


def clamped(names, slots=1, activation=1.0):
    """A pack of masks that act everywhere, in the first layer."""
    model = random_model(size=(16, 16), weights=(4, 4), slots=slots)
    activations = np.zeros((3, len(names), slots), np.float16)
    activations[..., 0] = activation
    masks = np.full((len(names), 4, 4), 255, np.uint8)
    return replace(model, weights=MaskedWeights(tuple(names), {1001: masks}, activations))


def export(model, folder, target, **options):
    write_pack(model, folder / "me.facezip", overwrite=True)
    return TARGETS[target](folder / "me.facezip", folder / "out", **options)


def positive(**options):
    model = random_model(**options)
    return replace(model, weights={tile: np.abs(maps) for tile, maps in model.weights.items()})


REFUSED = {
    "no masks": ("metahuman", lambda: positive(slots=3), "--given-masks DIR"),
    "free activations": ("metahuman", lambda: masked(random_model(slots=3)), 'activations = "0..1" in masks.toml'),
    "more layers": ("metahuman", lambda: clamped(("head_wm1_a",), slots=4), "compress with --differences 3"),
    "another layer": ("metahuman", lambda: clamped(("head_wm23_a",)), r"head_wm23_a = \[1, 2\] under \[layers\]"),
    "one curve": ("metahuman", lambda: clamped(("head_wm1_a", "head_wm1_a_msk")), "rename one"),
    "tiles": ("metahuman", lambda: layered_model(kinds=KINDS[:1], tiles=(1001, 1002)), "tiles 1001, 1002"),
    "negative weights": ("o3de", random_model, "compress with --nonnegative"),
    "five layers": ("o3de", lambda: positive(slots=5), "compress with --differences 4"),
    "dots": ("o3de", lambda: replace(positive(), expressions=("a.b", "c", "d")), "'a.b'"),
    "map of a taken name": (
        "o3de", lambda: layered_model(positive, (KINDS[0], Map("basecolor", "data"))), "map 'basecolor'"
    ),
    "no albedo": ("o3de", lambda: layered_model(kinds=KINDS[1:2]), "no albedo"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_pack_that_an_engine_cannot_show_is_refused_before_anything_is_written(case, tmp_path):
    target, make, words = REFUSED[case]
    with pytest.raises(FaceZipError, match=words) as caught:
        export(make(), tmp_path, target)
    assert caught.value.code in (ErrorCode.BAD_VALUE, ErrorCode.UNSAFE_NAME)
    assert str(tmp_path / "me.facezip") in str(caught.value)
    assert [entry.name for entry in tmp_path.iterdir()] == ["me.facezip"]


@pytest.mark.parametrize("target", ENGINES)
@pytest.mark.parametrize(
    "option",
    ["--textures png", "--maps apart", "--region chin=a.png", "--animation a.csv", "--character scans"],
)
def test_options_that_say_nothing_are_refused(wrinkles, target, option, tmp_path):
    done = run("export", wrinkles / "me.facezip", "--to", target, *option.split(), "-o", tmp_path / "x")
    assert done.returncode == ExitCode.USAGE
    assert option.split()[0] in done.stderr
    assert not (tmp_path / "x").exists()


def test_a_pack_without_meshes_has_no_head(tmp_path):
    export(positive(), tmp_path, "o3de")
    assert not (tmp_path / "out" / "head.glb").exists()
    assert "face_wrinklemasks" in (tmp_path / "out" / "GUIDE.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("make", [lambda: grey(positive()), lambda: positive(weights=(1, 1))], ids=["grey", "uniform"])
def test_o3de_takes_grey_skin_and_uniform_weights(make, tmp_path):
    document = export(make(), tmp_path, "o3de")
    engine = O3de(tmp_path / "out")
    wanted = read_pack(tmp_path / "me.facezip").reconstruct("expr_1")
    found = document.maps["albedo"].rmse_per_expression["expr_1"]
    assert rmse(255 * (engine.albedo({"expr_1": 1.0}) - wanted)) == pytest.approx(found, rel=1e-3)


@given(arrays(np.float32, (5, 4), elements=st.floats(0, 1, width=32)), st.floats(0.1, 1))
def test_strengths_in_turn_give_the_shares_that_they_are_made_of(raw, whole):
    rule = Rule(in_turn=True, keeps_z=False)
    shares = raw / np.maximum(raw.sum(axis=1, keepdims=True), 1) * np.float32(whole)
    strengths = rule.strengths(shares)
    assert strengths.min() >= 0
    assert strengths.max() <= 1
    np.testing.assert_allclose(rule.shares(strengths), shares, atol=2e-5)
    # Laid on one after the other.
    value, layers = np.zeros(5), np.arange(1, 5)
    for i, layer in enumerate(layers):
        value += strengths[:, i] * (layer - value)
    np.testing.assert_allclose(value, shares @ layers, atol=2e-4)


@pytest.mark.parametrize("name", ["albedo", "normal"])
def test_every_byte_comes_back_from_what_engines_mix(name):
    kind = KNOWN[name]
    stored = np.repeat(np.arange(256, dtype=np.uint8)[:, None, None], 3, axis=2)
    stored[..., 1:] = 128
    again = stored_of(kind, mixed_of(kind, stored))
    channels = slice(0, 2) if kind.is_normal else slice(None)
    np.testing.assert_array_equal(again[..., channels], stored[..., channels])

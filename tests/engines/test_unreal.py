"""The script of Unreal exports runs against the names, arguments and properties of the engine's own stubs."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from facezip.export import TARGETS
from facezip.pack.write import write_pack
from tests.engines.unreal_editor import Editor
from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import KINDS, layered_model
from tests.facezip.export.gains import REGIONS, regions_in

PLUGINS = {None, "PythonScriptPlugin", "Interchange", "InterchangeEditor"}


@pytest.fixture(scope="module")
def stubs():
    spec = find_spec("unreal")
    if spec is None:
        pytest.skip("Unreal's stubs are not installed: pip install unreal-stub")
    return Path(spec.origin).with_name("unreal.py").read_text(encoding="utf-8-sig")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("unreal")
    write_pack(layered_model(kinds=KINDS, tiles=(1001, 1002), slots=5), path / "me.facezip")
    TARGETS["unreal"](path / "me.facezip", path / "face", region=regions_in(path, (1001, 1002)))
    return path / "face"


def run(stubs, folder, head="SkeletalMesh"):
    """The editor after the script."""
    imported = {}

    def import_tasks(tasks):
        for task in tasks:
            file = Path(task.get_editor_property("filename"))
            assert file.is_file()
            imported[file.stem] = getattr(editor, head if file.suffix == ".glb" else "Texture2D")()
            task.values["imported_object_paths"] = [file.stem]

    answers = {"import_asset_tasks": import_tasks, "load_asset": lambda name: imported[name]}
    editor = Editor(stubs, {**answers, "does_asset_exist": lambda path: True})
    script = folder / "setup_facezip.py"
    text = script.read_text(encoding="utf-8")
    exec(compile(text.replace("import unreal\n", ""), script, "exec"), {"unreal": editor, "__file__": str(script)})
    return editor


def calls(editor, name):
    return [list(given.values()) for called, given in editor.calls if called == name]


def test_every_name_argument_and_property_exists(stubs, folder):
    editor = run(stubs, folder)
    assert calls(editor, "save_directory") == [["/Game/FaceZip/face"]]
    assert calls(editor, "log_warning") == []
    # Of each tile three sheets of six textures, two weight maps and an image of regions; materials for two targets and
    # the head.
    assert len(calls(editor, "save_loaded_asset")) == 2 * (3 * 6 + 2 + 1)
    assert len(calls(editor, "recompile_material")) == 2 * 3


def test_nothing_is_of_a_plug_in_that_the_guide_does_not_name(stubs, folder):
    editor = run(stubs, folder)
    assert {kind.plugin for kind in editor.classes.values()} <= PLUGINS


def test_textures_are_plain_numbers_and_not_virtual(stubs, folder):
    for (texture,) in calls(run(stubs, folder), "save_loaded_asset"):
        assert texture.values["srgb"] is False
        assert texture.values["virtual_texture_streaming"] is False


def test_nodes_are_connected_by_the_names_of_their_inputs(stubs, folder):
    editor = run(stubs, folder)
    joints = calls(editor, "connect_material_expressions")
    nodes = {id(node): node for _, _, node, _ in joints}
    assert len(nodes) == 6
    for node in nodes.values():
        inputs = [socket.values["input_name"] for socket in node.values["inputs"]]
        assert inputs == [name for _, _, other, name in joints if other is node]
        assert all(name in node.values["code"] for name in inputs)


def test_gains_are_parameters_by_their_names_that_change_nothing_at_first(stubs, folder):
    made = calls(run(stubs, folder), "connect_material_expressions")
    scalars = {}
    for source, _, _, _ in made:
        if type(source).__name__ == "MaterialExpressionScalarParameter":
            scalars[source.values["parameter_name"]] = source.values["default_value"]
    expressions = [f"expr_{n}" for n in range(3)]
    gains = [f"gains.maps.{kind.name}" for kind in KINDS] + [f"gains.expressions.{name}" for name in expressions]
    gains += [f"gains.regions.{name}" for name in REGIONS]
    assert scalars == dict.fromkeys(expressions, 0.0) | dict.fromkeys(gains, 1.0)


@pytest.fixture(scope="module")
def masked_folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("unreal")
    write_pack(masked(random_model(slots=5, meshes=True), 9), path / "me.facezip")
    TARGETS["unreal"](path / "me.facezip", path / "face", region=regions_in(path))
    return path / "face"


def test_of_masks_one_material_has_the_expressions_and_draws_what_the_others_take(stubs, masked_folder):
    editor = run(stubs, masked_folder)
    joints = calls(editor, "connect_material_expressions")
    nodes = {id(node): node for _, _, node, _ in joints}
    inputs = [[name for _, _, other, name in joints if other is node] for node in nodes.values()]
    of_expressions = [f"{letter}{n}" for n in range(3) for letter in "BG"]
    of_weights = ["UV", "Masks", "Activations", "Regions", *(f"R{k}" for k in range(len(REGIONS)))]
    assert [{*names} for names in inputs[:3]] == [{"UV", "Activations", *of_expressions}, {*of_weights}, {*of_weights}]


def test_render_targets_have_a_texel_for_every_mask_and_three_slots(stubs, masked_folder):
    """Nine masks take three fours, and five slots two targets."""
    sizes = {}
    for source, _, _, name in calls(run(stubs, masked_folder), "connect_material_expressions"):
        texture = source.values.get("texture")
        if "size_x" in getattr(texture, "values", {}):
            sizes[name] = texture.values["size_y"], texture.values["size_x"]
    assert sizes == {"Activations": (2, 12), "Weights0": (3, 5), "Weights1": (3, 5)}


def test_a_head_without_morph_targets_is_warned_of(stubs, folder):
    (warning,) = calls(run(stubs, folder, head="StaticMesh"), "log_warning")
    assert "skeletal" in warning[0]

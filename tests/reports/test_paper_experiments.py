"""The experiments give what the methods themselves give, and share what they can."""

import numpy as np
import pytest

from facezip import compress
from facezip.documents.document import plain
from facezip.fit.paper.stitching import stitching_cost
from facezip.pack.errors import albedo_errors, mean_rmse
from facezip.pack.footprint import Footprint, Texture
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from reports.paper import mask_counts, reproduction
from reports.paper.experiments import Settings, figure_6, figure_7_convergence, run_trial, table_1
from reports.paper.mask_counts import figure_7_masks
from reports.paper.published import EXPRESSIONS_IN_MEMORY, TABLE_1
from reports.paper.steps import stored_errors
from tests.facezip.conftest import random_character, with_albedo
from tests.facezip.surfaces import random_surface

SETTINGS = Settings(masks=7, restarts=6, starts=3, mask_counts=(3, 90, 5))
PAPER = {"masks": 7, "restarts": 6}


@pytest.fixture(scope="module")
def trial():
    mask = np.zeros((64, 64), np.float32)
    mask[8:56, 4:60] = 1
    return run_trial(with_albedo(random_character(side=64), mask=mask), SETTINGS)


def test_errors_are_those_of_the_written_pack_read_back(trial, tmp_path):
    for method, settings in (("paper", PAPER), ("refined", {}), ("pca", {"differences": 4})):
        write_pack(compress(trial.character, method, **settings), tmp_path / "a.facezip", overwrite=True)
        expected = albedo_errors(trial.character, read_pack(tmp_path / "a.facezip"))
        assert trial.errors["pca_4" if method == "pca" else method] == pytest.approx(expected, rel=1e-4)


def test_the_table_adds_the_steps_up_and_counts_the_bytes(trial):
    row = table_1(trial)
    seconds = row.seconds
    steps = [seconds[step] for step in ("masks", "clustering", "stitching", "factorisation")]
    assert min(steps) >= 0
    assert seconds["paper"] == pytest.approx(sum(steps))
    assert row.bytes_on_gpu["paper"] == row.bytes_on_gpu["refined"] == 15 * 64**2 + 5 * 4 * 8**2
    assert row.bytes_on_gpu["raw"] == 6 * 3 * 64**2
    assert row.bytes_on_gpu_of_51["raw"] == 52 * 3 * 64**2
    assert row.rmse["paper"] == pytest.approx(mean_rmse(trial.errors["paper"]))


@pytest.mark.parametrize("side", TABLE_1)
def test_the_papers_memory_follows_from_the_sizes(side):
    cost = Footprint(((Texture(side, side, 3),),), ((side // 8, side // 8),), 4, EXPRESSIONS_IN_MEMORY)
    published = TABLE_1[side].megabytes
    assert cost.bytes_on_gpu / 1e6 == pytest.approx(published["paper"], abs=0.01)
    assert cost.bytes_raw / 1e6 == pytest.approx(published["raw"], abs=0.01)


def test_figure_6_is_of_the_methods_by_their_names(trial):
    figure = figure_6(trial)
    for method in ("paper-unpermuted", "paper-optimised"):
        expected = stored_errors(trial.character, compress(trial.character, method, **PAPER))
        assert figure.rmse_per_expression[method.replace("-", "_")] == pytest.approx(expected, rel=1e-6)
    for name, errors in figure.rmse_per_expression.items():
        assert list(errors) == list(trial.character.expressions)
        assert figure.rmse[name] == pytest.approx(np.mean(list(errors.values())))


def test_costs_never_rise_and_the_best_start_is_the_papers_choice(trial):
    figure = figure_7_convergence(trial)
    history = np.array(figure.history)
    assert len(history) == SETTINGS.restarts
    assert (np.diff(history, axis=1) <= 1e-9 * history[:, :1]).all()
    assert figure.cost["paper"] == pytest.approx(history[:, -1].min())
    for name, stitching in trial.stitchings.items():
        assert figure.cost[name] == pytest.approx(stitching_cost(trial.fragments.table, stitching.permutation))


def test_our_search_ends_between_the_bound_and_the_papers_choice(trial):
    figure = figure_7_convergence(trial)
    cost, gap = figure.cost, figure.gap
    assert figure.lower_bound <= cost["paper_optimised"] <= cost["paper"] * (1 + 1e-12)
    assert 0 <= gap["paper_optimised"] < 0.05
    assert gap["paper"] == pytest.approx((cost["paper"] - figure.lower_bound) / cost["paper"])
    assert set(figure.seconds) == {*cost, "lower_bound"}


def test_masks_share_the_trial_and_leave_out_what_the_face_does_not_hold(trial, monkeypatch):
    made = []

    def counted(character, count, seed, make=mask_counts.make_fragments):
        made.append(count)
        return make(character, count, seed)

    monkeypatch.setattr(mask_counts, "make_fragments", counted)
    figure = figure_7_masks(trial.character, SETTINGS, trial)
    counts = [row.masks for row in figure.counts]
    assert counts == [3, 5, 7]
    assert made == [3, 5, 90]
    for row in figure.counts:
        assert len(row.rmse) == len(row.costs) == SETTINGS.starts
    seven = figure.counts[2]
    assert seven.chosen["paper"].rmse == pytest.approx(mean_rmse(trial.errors["paper"]))
    assert figure == figure_7_masks(trial.character, SETTINGS)


def test_everything_is_in_one_document_and_the_first_size_is_the_figures():
    first, second = (random_character(side=side, expressions=3) for side in (32, 16))
    document = plain(reproduction.reproduce(iter([first, second]), 2, SETTINGS, "both made for a test"))
    assert [row["resolution"] for row in document["table_1"]] == [[16, 16], [32, 32]]
    for figure in ("figure_6", "figure_7_convergence", "figure_7_masks"):
        assert document[figure]["resolution"] == [32, 32]
    assert document["conditions"]["texture_sizes"] == "both made for a test"
    assert document["figure_7_masks"]["without_masks"]["refined"] == document["figure_6"]["rmse"]["refined"]
    assert document["findings"]
    assert document["conditions"]["maps"] == "the albedo, as in the paper"


def test_it_is_measured_on_the_albedo_of_all_tiles():
    """Of a character with more maps: as of one that has nothing else; and as of one whose chart was never cut."""
    whole, tiled = (random_surface(side=64, expressions=6, tiles=tiles) for tiles in ((1, 1), (2, 1)))
    settings = Settings(masks=4, restarts=3, starts=2, mask_counts=())
    first, alone, uncut = (
        plain(reproduction.reproduce([one], 1, settings, "for a test")) for one in (tiled, tiled.only("albedo"), whole)
    )
    assert first["figure_6"] == alone["figure_6"]
    assert first["character"]["maps"] == [{"name": "albedo", "encoding": "srgb"}]
    assert first["conditions"]["maps"] == "the albedo, as in the paper, of all 2 tiles"
    assert first["table_1"][0]["bytes_on_gpu"] == uncut["table_1"][0]["bytes_on_gpu"]
    # Uniform weights do not know of tiles.
    assert first["figure_6"]["rmse"]["pca_4"] == pytest.approx(uncut["figure_6"]["rmse"]["pca_4"], rel=0.02)
    assert first["figure_6"]["rmse"]["paper"] == pytest.approx(uncut["figure_6"]["rmse"]["paper"], rel=0.2)
    assert "memory" not in {finding["key"] for finding in first["findings"]}

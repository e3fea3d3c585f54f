"""The contact sheet of ``facezip check``: the worst first, whatever is wrong with it, and one scale for all tiles."""

import numpy as np
import pytest

from facezip.character.alignment import Alignment, severity
from facezip.character.displacement import GRID
from facezip.character.features import Feature
from reports.alignment import contact_sheet
from tests.facezip.conftest import random_character


def lying(texels, unit=1.0, known=1.0, **wrong):
    """All of a texture as far off."""
    displacement = np.full((GRID, GRID, 2), texels / np.sqrt(2), np.float32)
    return Alignment(displacement, np.full((GRID, GRID), known, np.float32), known, unit, **wrong)


def shown(found):
    """Names of the panels in their order, with what they say in words."""
    axes = [axis for axis in contact_sheet(random_character(expressions=len(found)), found).axes if axis.get_title()]
    return {axis.get_title().split()[0]: " ".join(axis.texts[0].get_text().split()) for axis in axes}


def test_what_slipped_or_turned_comes_before_what_is_registered():
    slipped, turned = Feature("slipped", 9.0, 0.5, 0.25), "upside down"
    found = [lying(0.9), lying(0.0, turned=turned), lying(0.0, known=0.0), lying(3.0), lying(0.1, feature=slipped)]
    names = [f"expr_{n}" for n in (3, 4, 1, 2, 0)]
    sheet = shown({f"expr_{n}": {1001: one} for n, one in enumerate(found)})
    assert list(sheet) == names
    assert [sheet[f"expr_{n}"] for n in (0, 1, 4)] == ["", turned, found[4].why]


def test_texels_count_by_the_size_of_their_tile():
    small, large = lying(1.5), lying(4.0, unit=8.0)
    assert list(shown({"expr_0": {1001: large}, "expr_1": {1001: small}})) == ["expr_1", "expr_0"]


@pytest.mark.parametrize("unit", [1.0, 8.0])
def test_one_scale_holds_for_tiles_of_all_sizes(unit):
    """What is as far on the skin has the same colour."""
    found = {"expr_0": {1001: lying(1.5)}, "expr_1": {1001: lying(1.5 * unit, unit)}}
    axes = contact_sheet(random_character(expressions=2), found).axes
    heats = [axis.images[1] for axis in axes if axis.get_title()]
    seen = [heat.norm(heat.get_array()) for heat in heats]
    np.testing.assert_allclose(seen[0], seen[1], rtol=1e-6)


def test_severity_puts_states_before_displacements():
    assert severity("misregistered", 0.0) > severity("unknown", 9.0) > severity("registered", 0.9)
    assert severity("registered", 0.9) > severity("registered", 0.1)

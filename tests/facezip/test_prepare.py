"""Preparing compiles kernels for textures of 8 bits and of 16: both are the same face."""

import numpy as np
import pytest

from facezip.commands.prepare import of_type
from facezip.files.images import to_float
from scenes.character import make_character


@pytest.fixture(scope="module")
def made():
    return make_character(64, 2, maps=("normal", "roughness"))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_textures_of_every_map_keep_their_values_in_the_type_that_is_prepared(made, dtype):
    assert {stack.neutral.dtype.type for stack in made.stacks.values()} == {np.uint8, np.uint16}
    for key, stack in of_type(made, dtype).stacks.items():
        for ours, theirs in ((stack.neutral, made.stacks[key].neutral), (stack.textures, made.stacks[key].textures)):
            assert ours.dtype == dtype
            np.testing.assert_allclose(to_float(ours), to_float(theirs), atol=0.51 / 255)

"""What setting up compiles kernels with: the head as it is, of 8 and of 16 bits."""

import numpy as np
import pytest

from facezip.commands.prepare import of_bits
from facezip.files.images import to_float
from scenes.character import make_character
from scenes.face.capture import MAPS


@pytest.mark.parametrize("bits", [8, 16])
def test_all_maps_have_the_bits_and_look_the_same(bits):
    head = make_character(64, 2, maps=MAPS[:2])
    found = of_bits(head, bits)
    assert {stack.neutral.dtype for stack in head.stacks.values()} == {np.dtype(np.uint8), np.dtype(np.uint16)}
    for key, stack in found.stacks.items():
        for ours, before in ((stack.neutral, head.stacks[key].neutral), (stack.textures, head.stacks[key].textures)):
            assert ours.dtype == np.dtype(f"uint{bits}")
            np.testing.assert_allclose(to_float(ours), to_float(before), atol=0.5 / 255 + 1e-6)

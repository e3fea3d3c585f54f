"""Frames are those of Zstandard, smaller where there is something to save, and the same wherever arrays live."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from zstandard import ZstdDecompressor, frame_content_size

from facezip.blocks import supercompression
from facezip.blocks.supercompression import supercompress


@given(arrays(np.uint8, st.integers(0, 3000)), st.integers(1, 4000))
def test_a_frame_holds_what_went_in_in_pieces_of_any_size(blocks, piece):
    whole = supercompress(blocks)
    before, supercompression.PIECE = supercompression.PIECE, piece
    try:
        frame = supercompress(blocks)
    finally:
        supercompression.PIECE = before
    assert frame.tobytes() == whole.tobytes()
    # Loaders ask the frame itself for the size to come.
    assert frame_content_size(frame.tobytes()) == len(blocks)
    assert ZstdDecompressor().decompress(frame.tobytes()) == blocks.tobytes()


def test_noise_stays_as_large_and_repetition_nearly_vanishes():
    noise = np.random.default_rng(0).integers(0, 256, 10**6, np.uint8)
    assert len(noise) < len(supercompress(noise)) < 1.001 * len(noise)
    assert len(supercompress(np.tile(noise[:1000], 1000))) < 2000

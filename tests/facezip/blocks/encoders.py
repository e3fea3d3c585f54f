"""What other encoders of BC1 and BC7 would leave: figures of docs/comparison.md.

``pip install bc7enc-py ispc-texcomp quicktex``, then ``python -m tests.facezip.blocks.encoders CHARACTER``: RMSE of 255
inside the mask and processor time, of a texture and of a difference that fills 8 bits, beside those of etcpak.
"""

import ctypes
import sys
from pathlib import Path
from time import process_time

import bc7enc
import ispc_texcomp
import numpy as np
import quicktex
import texture2ddecoder
from quicktex.s3tc.bc1 import BC1Encoder

from facezip.blocks.codecs import bc1, bc7, of_library
from facezip.character.loading import load_character

BC7_PROFILES, BC1_LEVELS = ("fast", "basic", "slow"), (5, 10, 18)


def main(place):
    scans = load_character(Path(place))
    key = next(iter(scans.stacks))
    covered = scans.stacks[key].weight > 0
    neutral, texture = (scans.texels(name, key).astype(np.float32) for name in ("neutral", scans.expressions[0]))
    difference = texture - neutral
    span = np.abs(difference[covered]).max(axis=0)
    images = [texture, np.clip(np.rint(difference / span * 127), -127, 127) + 128]
    for name, codec in encoders():
        print(f"{name:24}", *(f"{error:7.3f} {seconds:6.2f} s" for error, seconds in measured(codec, images, covered)))


def measured(codec, images, covered):
    for image in images:
        texels = image.astype(np.uint8)
        codec.round_trip(texels[:32, :32])
        begin = process_time()
        stored = codec.store(texels)
        seconds = process_time() - begin
        gap = codec.load(stored, texels.shape).astype(np.float32) - texels
        yield np.sqrt(np.square(gap[covered]).mean()), seconds


def encoders():
    yield "BC1: etcpak", bc1()
    yield "BC1: ispc-texcomp", of_library("bc1", (4, 4), 8, ispc("bc1"), texture2ddecoder.decode_bc1)
    for level in BC1_LEVELS:
        yield f"BC1: quicktex {level}", of_library("bc1", (4, 4), 8, rgbcx(level), texture2ddecoder.decode_bc1)
    yield "BC7: etcpak", bc7()
    yield "BC7: bc7enc-py", of_library("bc7", (4, 4), 16, block_by_block, texture2ddecoder.decode_bc7)
    for profile in BC7_PROFILES:
        settings = ispc_texcomp.BC7EncSettings.from_profile(profile)
        codec = of_library("bc7", (4, 4), 16, ispc("bc7", settings), texture2ddecoder.decode_bc7)
        yield f"BC7: ispc-texcomp {profile}", codec


def ispc(name, *settings):
    compress = getattr(ispc_texcomp, f"compress_blocks_{name}")
    size = 8 if name == "bc1" else 16
    # Of BC1 twice the bytes come back, the second half of them zeros.
    return lambda rgba, width, height: compress(ispc_texcomp.RGBASurface(rgba, width, height), *settings)[
        : size * width * height // 16
    ]


def rgbcx(level):
    encoder = BC1Encoder(level)
    return lambda rgba, width, height: encoder.encode(quicktex.RawTexture.frombytes(rgba, width, height)).tobytes()


def block_by_block(rgba, width, height):
    """bc7enc-py has no more than a function of its library for one block."""
    parameters = bc7enc.bc7enc_compress_block_params_init()
    parameters.m_perceptual, parameters.m_uber_level, parameters.m_weights = False, 4, (ctypes.c_uint * 4)(1, 1, 1, 1)
    texels = np.frombuffer(rgba, np.uint8).reshape(height // 4, 4, width // 4, 4, 4).swapaxes(1, 2).reshape(-1, 64)
    return b"".join(bc7enc.pack_bc7(block.tobytes(), parameters) for block in texels)


if __name__ == "__main__":
    main(*sys.argv[1:])

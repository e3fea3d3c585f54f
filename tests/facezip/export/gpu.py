"""Runs shader text: OpenGL in software where there is such; HLSL by way of SPIR-V."""

import os
import re
import shutil
import subprocess
from contextlib import contextmanager

import numpy as np
import pytest

from facezip.errors import FaceZipError
from facezip.export.opengl import devices, opened

PREFIX = "SPIRV_Cross_Combined"
CORNERS = "#version 450\nvoid main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0, 1); }"


def tool(name):
    """Path of a program, or the test skips."""
    return shutil.which(name) or pytest.skip(f"{name} is not installed")


def checked(*command, text=None):
    done = subprocess.run([*map(str, command)], input=text, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def compile_glsl(text, folder):
    file = folder / "shader.frag"
    file.write_text(text)
    checked(tool("glslangValidator"), "-S", "frag", file)


def hlsl_to_glsl(text, folder, *includes):
    """A fragment shader with entry ``main``, as GLSL."""
    file, spirv = folder / "shader.hlsl", folder / "shader.spv"
    file.write_text(text)
    where = [f"-I{include}" for include in includes]
    checked(tool("glslangValidator"), "-D", "-e", "main", "-S", "frag", "-V", *where, "-o", spirv, file)
    return checked(tool("spirv-cross"), spirv, "--version", 450, "--no-es")


@contextmanager
def software():
    """OpenGL of the processor where there is such, or the test skips.

    Texture units of hardware interpolate with a few bits only.
    """
    os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")
    try:
        with opened(next((device.index for device in devices() if device.is_software), None)) as (_, context):
            yield context
    except FaceZipError as error:
        pytest.skip(str(error))


class Gpu:
    def __init__(self, context):
        self._context = context

    def texture(self, texels):
        """``(H, W, C)`` uint8 or float32, the first row first in memory, sampled bilinearly and clamped."""
        height, width, channels = texels.shape
        kind = "f1" if texels.dtype == np.uint8 else "f4"
        content = np.ascontiguousarray(texels).tobytes()
        texture = self._context.texture((width, height), channels, content, dtype=kind, alignment=1)
        texture.repeat_x = texture.repeat_y = False
        return texture

    def draw(self, fragment, size, textures, floats=(), corners=CORNERS):
        """``(*size, 4)`` float32 that a fragment shader writes, first row first.

        ``floats``, numbers or vectors of four, fill its one array.
        """
        program = self._context.program(vertex_shader=corners, fragment_shader=fragment)
        target = self._context.texture(size[::-1], 4, dtype="f4")
        frame = self._context.framebuffer([target])
        frame.use()
        # Those that are not read are optimised away.
        samplers, members = re.findall(r"uniform (?:highp |mediump )?sampler2D (\w+)", fragment), {*program}
        for unit, name in enumerate(name for name in samplers if name in members):
            key = name.removeprefix(PREFIX)
            best = max((known for known in textures if key.startswith(known)), key=len)
            textures[best].use(unit)
            program[name].value = unit
        self._fill(program, np.asarray(floats, np.float32))
        self._context.vertex_array(program, []).render(vertices=3)
        return np.frombuffer(target.read(), np.float32).reshape(*size, 4)

    def _fill(self, program, floats):
        for name in program:
            member = program[name]
            if type(member).__name__ == "UniformBlock":
                # Arrays of floats take sixteen bytes an element there.
                numbers = floats.reshape(len(floats), -1)
                block = np.zeros((len(floats), 4), np.float32)
                block[:, : numbers.shape[1]] = numbers
                self._buffer = self._context.buffer(block.tobytes())
                self._buffer.bind_to_uniform_block(member.binding)
            elif getattr(member, "array_length", 1) > 1 or name.rstrip("[0]") in ("beta", "activations", "values"):
                # What no element of is read at the end is optimised away.
                member.write(floats[: member.array_length].tobytes())

"""What all dialects of shaders share: the template, numbers and names."""

import re

import pytest

from facezip.export.shaders import GLSL, HLSL, identifier, number, shader
from facezip.export.source import read_source
from facezip.pack.write import write_pack


def test_every_dialect_says_the_same(model, tmp_path):
    """One template: but for the words of the language, the text is the same."""
    write_pack(model, tmp_path / "me.facezip")
    (tile,) = read_source(tmp_path / "me.facezip").tiles
    glsl, hlsl = shader(tile, GLSL), shader(tile, HLSL)
    hlsl = hlsl.replace("SamplerState clamped, ", "").replace(", clamped, uv", ", uv").replace("Texture2D", "sampler2D")
    hlsl = re.sub(r"(\w+)\.Sample\(clamped, uv\)", r"texture(\1, uv)", hlsl)
    hlsl = re.sub(r"(weights|masks)\.Load\(int3\((.*), 0\)\)", r"texelFetch(\1, \2, 0)", hlsl)
    hlsl = re.sub(r"\bfloat(\d)", r"vec\1", re.sub(r"\bint2", "ivec2", hlsl))
    assert glsl == hlsl


@pytest.mark.parametrize("value", [0, 1, -1, 1e-9, 123456789, 0.1])
def test_numbers_are_floats_in_every_language(value):
    assert float(number(value)) == pytest.approx(value)
    assert "." in number(value) or "e" in number(value)


@pytest.mark.parametrize("name", ['"; rm -rf /', "</script>", "Größe", "", "9 lives", "a\u2028b"])
def test_identifiers_are_made_of_letters_and_digits(name):
    assert re.fullmatch(r"\w+", identifier(name), re.ASCII)

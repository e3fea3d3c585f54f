"""``facezip bench shader``: what a blend costs on the GPU of this machine."""

import click

from facezip.commands import options
from facezip.commands.words import megabytes
from facezip.export.timing import DeviceFacts, ShaderDocument, bench_shader


def _multiple(context: click.Context, option: click.Parameter, value: int) -> int:
    if value % 8:
        raise click.BadParameter(f"{value} is no multiple of 8, the texels a texel of a weight map")
    return value


@click.command("shader")
@click.option(
    "--resolution",
    type=click.IntRange(64, 8192),
    callback=_multiple,
    default=2048,
    show_default=True,
    metavar="TEXELS",
    help="A side of the textures, and of the picture.",
)
@click.option(
    "--expressions",
    "counts",
    type=click.IntRange(min=2),
    multiple=True,
    default=(20, 52),
    show_default=True,
    metavar="N",
    help="How many; give it once for each number.",
)
@click.option("--device", type=click.IntRange(min=0), metavar="I", help="EGL's device.  [default: the first GPU]")
@click.option("--repeats", type=click.IntRange(min=1), default=9, show_default=True, metavar="N")
@options.as_json
def command(resolution: int, counts: tuple[int, ...], device: int | None, repeats: int, as_json: bool) -> None:
    """Measure GPU time: pre-pass and six fetches, against a fetch of every expression's texture.

    It draws with OpenGL without a window (EGL), with the shader of the exports, and reads the GPU's own timer. Without
    a GPU the processor draws, and the answer says so. It needs moderngl: pip install 'facezip[gpu]'.
    """
    document = bench_shader(resolution, counts, repeats, device)
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: ShaderDocument) -> list[str]:
    device, few, about = document.device, document.few, document.conditions
    kind = "software, on the processor: no GPU was measured" if device.software else "GPU"
    lines = [f"{device.renderer} ({kind}), OpenGL {device.version}, EGL's device {device.index}"]
    others = [one for one in document.devices if one.index != device.index]
    lines += [f"  also here: device {one.index}, {_state(one)}" for one in others]
    lines.append(f"{document.resolution}² pixels, one texel each; {about.statistic}, by {about.timer}")
    for row in document.rows:
        ours, theirs = megabytes(row.bytes), megabytes(row.bytes_textures)
        some = min(few, row.expressions)
        lines += [
            f"  {row.expressions} expressions, {ours} instead of {theirs}",
            f"    pre-pass and {row.fetches} fetches  {row.facezip_ms:10.4f} ms  "
            f"({row.prepass_ms:.4f} and {row.blend_ms:.4f})",
            f"    every texture at work   {row.textures_ms:10.4f} ms  FaceZip takes {row.ratio:.2f} of it",
            f"    {some} of them at work     {row.textures_few_ms:10.4f} ms  {row.ratio_few:.2f}",
        ]
    return lines


def _state(device: DeviceFacts) -> str:
    return f"which cannot be used: {device.fault}" if device.fault else device.renderer

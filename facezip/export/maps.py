"""The textures of an export: as PNG, or as blocks with fitted mip-maps in DDS or KTX2 files."""

import shutil
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from facezip.codecs import Codec, bc7, raw
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.basis import uastc
from facezip.export.containers import BC7_UNORM, BLOCK_SIDE, UASTC, dds, ktx2
from facezip.export.levels import Level, averaged_levels, fitted_levels
from facezip.export.measured import codec_errors, mip_errors
from facezip.export.mips import Pyramid, targets
from facezip.export.source import Source
from facezip.quantise import ZERO
from facezip.textures import write_texture

Container = Callable[[tuple[int, int], Sequence[bytes], str], bytes]


@dataclass(frozen=True)
class Format:
    """How textures are stored.

    Attributes
    ----------
    name : of the codec, as documents state it.
    suffix : of the files.
    container : size, levels and name of a map to the file's content; None for PNG.
    """

    name: str
    suffix: str
    container: Container | None = None


PNG = Format("png", ".png")
DDS = Format("bc7", ".dds", lambda size, levels, name: dds(size, levels))
KTX2 = Format("bc7", ".ktx2", lambda size, levels, name: ktx2(size, levels, BC7_UNORM))
# glTF knows no BC7; its loaders transcode UASTC. The neutral is also shown on its own, as colour.
BASIS = Format("uastc", ".ktx2", lambda size, levels, name: ktx2(size, levels, UASTC, name == "neutral"))


def write_maps(source: Source, folder: Path, form: Format, upside_down: bool = False) -> dict[str, Any]:
    """Write neutral, differences and weight maps into ``folder``.

    Parameters
    ----------
    source : the pack.
    form : of neutral and differences; weight maps are PNGs always, since they are small and blocks would show.
    upside_down : whether blocks begin with the last row, as in Unity's memory.

    Returns
    -------
    ``textures``: by name the file, and the numbers that turn its texels t in [0, 1] back into values; ``codec``: the
    errors that it adds; ``mips``: how far the levels are from the light of the blend, averaged.
    """
    names = ["neutral", *(f"difference_{i}" for i in range(len(source.difference_scale)))]
    if form.container and any(side % BLOCK_SIDE for side in source.manifest.size):
        height, width = source.manifest.size
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"{source.path}: textures of {width}x{height}; GPUs take blocks of whole {BLOCK_SIDE} texels a side: "
            "use --textures png",
        )
    pyramid = Pyramid(source.covered)
    plain = list(averaged_levels(source, pyramid, raw(source.manifest.channels)))
    if form.container is None:
        texels = [source.neutral_texels, *source.difference_texels]
        for name, image in zip(names, texels, strict=True):
            write_texture(folder / f"{name}.png", image)
        measured = {"codec": {"name": form.name}, "mips": mip_errors(source, pyramid, plain)}
    else:
        with uastc() if form is BASIS else nullcontext(bc7()) as codec:
            levels = list(fitted_levels(source, pyramid, plain, targets(source, pyramid), codec, upside_down))
            measured = _measured(source, pyramid, codec, plain, levels)
        for name in names:
            content = form.container(source.manifest.size, [level.stored[name] for level in levels], name)
            (folder / f"{name}{form.suffix}").write_bytes(content)
    return {"textures": _described(source, names, form.suffix) | _weights(source, folder), **measured}


def _measured(
    source: Source, pyramid: Pyramid, codec: Codec, plain: list[Level], levels: list[Level]
) -> dict[str, Any]:
    averaged = list(averaged_levels(source, pyramid, codec))
    afterwards = codec_errors(source, pyramid, averaged[0])["rmse"]
    return {
        "codec": {"name": codec.name, **codec_errors(source, pyramid, levels[0]), "rmse_without_fit": afterwards},
        "mips": mip_errors(source, pyramid, plain, averaged=averaged, fitted=levels),
    }


def _described(source: Source, names: list[str], suffix: str) -> dict[str, Any]:
    entries: dict[str, Any] = {name: {"file": f"{name}{suffix}"} for name in names}
    for entry, scale in zip(list(entries.values())[1:], source.manifest.difference_scale, strict=True):
        entry |= {"scale": list(scale), "zero": ZERO / 255}
    return entries


def _weights(source: Source, folder: Path) -> dict[str, Any]:
    """Copies the pack's weight maps; uniform weights are constants in the shader."""
    manifest = source.manifest
    entries: dict[str, Any] = {}
    for layer, file in enumerate(sorted(source.path.glob("weights*.png"))):
        shutil.copyfile(file, folder / f"weights_{layer}.png")
        slots = slice(4 * layer, 4 * layer + 4)
        entries[f"weights_{layer}"] = {
            "file": f"weights_{layer}.png",
            "columns": manifest.weight_columns,
            "size": list(manifest.weight_size),
            "scale": list(manifest.weight_scale[slots]),
            "offset": list(manifest.weight_offset[slots]),
        }
    return entries

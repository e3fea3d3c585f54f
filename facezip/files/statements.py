"""From a file's header to what it states (:class:`facezip.files.facts.Facts`), or the refusal of what it is."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from facezip.files.colour_statements import stated_space
from facezip.files.facts import Facts, Window
from facezip.files.layers import Layer, LayerFault, chosen_layer
from facezip.files.opening import MAX_PARTS, check_claims, opened, unreadable
from facezip.files.png_statements import chunks
from facezip.files.tiff_tags import ORIENTATION, exif_tags

_TYPES = {
    **{name: name for name in ("uint8", "uint16")},
    **{"uint": "uint32", "half": "float16", "float": "float32", "double": "float64"},
}
# Of TIFF's kinds of colours, those that come as grey or RGB: white or black is zero, RGB, palettes, YCbCr.
_WHITE_IS_ZERO, _PHOTOMETRIC = 0, (0, 1, 2, 3, 6)
_MODELS = {5: "CMYK", 8: "CIE L*a*b*", 9: "ICC L*a*b*", 10: "ITU L*a*b*"}
# A page that is no picture of its own: a smaller one of the first, or a mask of it.
_BESIDE = 1 | 4
# TGA's kind of alpha that is multiplied into colours.
_PREMULTIPLIED = 4


def stated(path: Path) -> Facts:
    """What an image states about itself, by its header alone.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``UNREADABLE_IMAGE`` or ``TOO_LARGE``.
    """
    with opened(path) as image:
        return facts_of(path, image)


def facts_of(path: Path, image: Any) -> Facts:
    """As :func:`stated`, of an open image, which stands at the part that is read from then on."""
    try:
        return _facts(path, image)
    except (LayerFault, ValueError) as fault:
        raise unreadable(path, str(fault)) from None


def _facts(path: Path, image: Any) -> Facts:
    is_exr = path.suffix.lower() == ".exr"
    found = chunks(path) if path.suffix.lower() == ".png" else {}
    parts = _parts(image) if is_exr else [("", image.spec().channelnames)]
    layer = chosen_layer(parts) if is_exr else _first_channels(image.spec())
    _check_pages(image)
    image.seek_subimage(layer.part, 0)
    spec = image.spec()
    check_claims(path, spec)
    photometric = spec.getattribute("tiff:PhotometricInterpretation")
    _check_model(spec, photometric)
    kind, orientation = _type(spec, layer, is_exr), _orientation(spec, found)
    if photometric == _WHITE_IS_ZERO and kind.startswith("float"):
        raise ValueError("it says that white is zero, of floats")
    alpha = _alpha(spec, layer, is_exr)
    rows, columns = spec.full_height, spec.full_width
    return Facts(
        path=path,
        size=(columns, rows) if orientation > 4 else (rows, columns),
        type=kind,
        channels=tuple(spec.channelnames[number] for number in layer.channels),
        alpha=alpha,
        orientation=orientation,
        window=_window(spec, is_exr),
        layer=layer,
        white_is_zero=photometric == _WHITE_IS_ZERO and kind in ("uint16", "uint32"),
        left_out=_left_out(parts, layer),
        stated_space=partial(stated_space, path, spec, len(layer.channels) - bool(alpha), found),
    )


def _parts(image: Any) -> list[tuple[str, tuple[str, ...]]]:
    """The name and the channels' names of every part of an OpenEXR file."""
    parts: list[tuple[str, tuple[str, ...]]] = []
    while len(parts) < MAX_PARTS and image.seek_subimage(len(parts), 0):
        spec = image.spec()
        parts.append((str(spec.getattribute("name") or ""), spec.channelnames))
    image.geterror()
    if len(parts) == MAX_PARTS:
        raise ValueError(f"it has {MAX_PARTS} parts or more")
    return parts


def _first_channels(spec: Any) -> Layer:
    """Of a format whose channels have an order: grey or RGB, and an alpha, or what may be one."""
    count, alpha = spec.nchannels, spec.alpha_channel
    colours = 3 if count > 2 and spec.channelnames[:3] == ("R", "G", "B") else 2 if count == 2 and alpha < 0 else 1
    behind = alpha if alpha >= colours else colours
    has_alpha = behind < count
    return Layer(0, "", (*range(colours), *([behind] if has_alpha else [])), has_alpha, colours == 3)


def _alpha(spec: Any, layer: Layer, is_exr: bool) -> str:
    """Alpha as :class:`Facts` has it: multiplied into colours by OpenEXR, and where TIFF and TGA say so."""
    if not layer.has_alpha:
        return ""
    if is_exr:
        return "associated"
    if layer.channels[-1] != spec.alpha_channel:
        return "unspecified"
    if spec.getattribute("tiff:PhotometricInterpretation") is None:
        multiplied = spec.getattribute("targa:alpha_type") == _PREMULTIPLIED
    else:
        multiplied = not spec.getattribute("oiio:UnassociatedAlpha")
    return "associated" if multiplied else "unassociated"


def _check_pages(image: Any) -> None:
    """A second picture may be the one that is meant."""
    if image.spec().getattribute("oiio:Movie"):
        raise ValueError("an animation")
    if image.spec().getattribute("tiff:PhotometricInterpretation") is None:
        return
    page = 1
    while page < MAX_PARTS and image.seek_subimage(page, 0):
        if not int(image.spec().getattribute("tiff:subfiletype") or 0) & _BESIDE:
            raise ValueError("it has several pages")
        page += 1
    image.geterror()


def _check_model(spec: Any, photometric: int | None) -> None:
    """What the image library would make RGB of by a rule of thumb, or take for RGB."""
    if photometric is not None and photometric not in _PHOTOMETRIC:
        raise ValueError(f"its colours are {_MODELS.get(photometric, f'of the kind {photometric} of TIFF')}, not RGB")
    if spec.getattribute("jpeg:ColorSpace"):
        raise ValueError(f"its colours are {spec.getattribute('jpeg:ColorSpace')}, not RGB")


def _type(spec: Any, layer: Layer, is_exr: bool) -> str:
    formats = spec.channelformats or (spec.format,) * spec.nchannels
    kinds = [str(formats[channel]) for channel in layer.channels]
    kind = max(kinds, key=lambda kind: [*_TYPES].index(kind) if kind in _TYPES else -1)
    if any(kind not in _TYPES for kind in kinds) or (is_exr and "uint" in kinds):
        raise ValueError(f"holds {', '.join(sorted({*kinds}))}")
    return _TYPES[kind]


def _orientation(spec: Any, found: Mapping[bytes, bytes]) -> int:
    stated_one = spec.getattribute("Orientation")
    if stated_one is None and b"eXIf" in found:
        # It may stand behind the pixels, where OpenImageIO does not look for it.
        stated_one = next(iter(exif_tags(found[b"eXIf"]).get(ORIENTATION, ())), None)
    return int(stated_one) if stated_one in range(1, 9) else 1


def _window(spec: Any, is_exr: bool) -> Window | None:
    """Of a page, TIFF and PNG may state where on paper it lies, which is nothing to a texture."""
    top, left = spec.y - spec.full_y, spec.x - spec.full_x
    bottom, right = top + spec.height, left + spec.width
    is_whole = (bottom - top, right - left) == (spec.full_height, spec.full_width)
    if is_whole and (not is_exr or (top, left) == (0, 0)):
        return None
    if min(bottom, right) <= 0 or top >= spec.full_height or left >= spec.full_width:
        raise ValueError("its data window lies beside its display window")
    return Window(top, left, bottom, right)


def _left_out(parts: list[tuple[str, tuple[str, ...]]], layer: Layer) -> tuple[str, ...]:
    return tuple(
        f"{part}: {name}" if len(parts) > 1 and part else name
        for number, (part, names) in enumerate(parts)
        for channel, name in enumerate(names)
        if number != layer.part or channel not in layer.channels
    )

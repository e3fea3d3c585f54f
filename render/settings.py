"""How to look at a character: views, lights, skin, transport, samples and limits, from a TOML file or defaults."""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from facezip.documents.document import Toml
from facezip.errors import ErrorCode, FaceZipError
from render.limits import DEFAULT_THRESHOLDS, Limit, Thresholds
from render.paired import TRANSPORTS, stratified
from scenes.cameras import VIEWS, View
from scenes.lights import RIGS
from scenes.materials import MATERIALS


@dataclass(frozen=True)
class Settings:
    """How to look.

    Attributes
    ----------
    views : where cameras stand.
    lights : keys of :data:`scenes.lights.RIGS`.
    material : a key of :data:`scenes.materials.MATERIALS`.
    transport : a key of :data:`render.paired.TRANSPORTS`.
    resolution : width and height of the images in pixels.
    spp : samples per pixel, an even number: two independent halves.
    max_spp : where noise hides the verdict, samples are doubled up to this number; None for four times ``spp``.
    seed : of all random numbers.
    thresholds : the limits of the verdict.
    """

    views: tuple[View, ...] = VIEWS[:2]
    lights: tuple[str, ...] = tuple(RIGS)[:2]
    material: str = "skin"
    transport: str = "direct"
    resolution: int = 512
    spp: int = 16
    max_spp: int | None = None
    seed: int = 0
    thresholds: Thresholds = DEFAULT_THRESHOLDS

    @property
    def most(self) -> int:
        """Samples per pixel at which a render ends, decided or not."""
        return 4 * self.spp if self.max_spp is None else max(self.max_spp, self.spp)

    def check(self) -> None:
        """Raise ``BAD_VALUE`` for the first setting outside its range."""
        ranges = {"resolution": (16, 8192), "spp": (2, 65536), "max_spp": (2, 2**20), "seed": (0, 2**31)}
        for name, (low, high) in ranges.items():
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise _bad(f"{name} {value}: must lie in {low}..{high}")
        if self.spp % 2 or stratified(self.spp // 2) * 2 != self.spp:
            nearest = 2 * stratified(self.spp // 2)
            raise _bad(f"spp {self.spp}: must be two halves that tile a pixel's square; {nearest} does")
        choices: dict[str, tuple[str, ...]] = {"material": tuple(MATERIALS), "transport": tuple(TRANSPORTS)}
        for name, known in choices.items():
            if getattr(self, name) not in known:
                raise _bad(f"{name} '{getattr(self, name)}': must be one of {', '.join(known)}")
        for name in ("views", "lights"):
            if not getattr(self, name):
                raise _bad(f"{name}: at least one is needed")

    @property
    def resolved(self) -> "Settings":
        """Every setting, as documents state it."""
        return replace(self, max_spp=self.most)


def read_settings(path: Path | None, given: Mapping[str, Any]) -> Settings:
    """Settings of a TOML file, or the defaults, with what was ``given`` on the command line in their place.

    ``views`` and ``lights`` are a number, taken in their order, or names; a view may be a table: a camera of your own.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, or ``BAD_VALUE`` that names the file, the key and what it may be.
    """
    found = {} if path is None else _parsed(path)
    try:
        settings = replace(Settings(), **{key: _value(key, value) for key, value in {**found, **given}.items()})
        settings.check()
    except FaceZipError as error:
        raise FaceZipError(error.code, f"{path}: {error}" if path else str(error)) from None
    return settings


def _parsed(path: Path) -> Toml:
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such settings; write them or leave --config out")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise _bad(f"{path}: not TOML ({error}); see docs/verdict.md for an example") from None


def _value(key: str, value: Any) -> Any:
    """What a key of the file stands for."""
    readers: dict[str, Callable[[Any], Any]] = {"views": _views, "lights": _lights, "thresholds": _thresholds}
    if key in readers:
        return readers[key](value)
    kinds = {"material": str, "transport": str, "resolution": int, "spp": int, "max_spp": int, "seed": int}
    if key not in kinds:
        raise _bad(f"'{key}' is no setting; there are {', '.join(sorted([*kinds, *readers]))}")
    return _typed(key, value, kinds[key])


def _typed(key: str, value: Any, kind: type) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise _bad(f"{key} {value!r}: must be a {'number' if kind in (int, float) else 'text'}")
    return value


def _views(value: Any) -> tuple[View, ...]:
    if isinstance(value, int):
        return VIEWS[: _count("views", value, len(VIEWS))]
    known = {view.name: view for view in VIEWS}
    entries = _listed("views", value)
    views = tuple(_camera(entry) if isinstance(entry, dict) else _named("views", entry, known) for entry in entries)
    names = [view.name for view in views]
    if len({*names}) < len(names):
        raise _bad("views: two of them have one name")
    return views


def _camera(entry: Mapping[str, Any]) -> View:
    kinds = {"name": str, "azimuth": float, "elevation": float, "extent": float}
    unknown = [key for key in entry if key not in {*kinds, "aim"}]
    name = str(entry.get("name", ""))
    if unknown or not name.replace("_", "").replace("-", "").isalnum():
        wrong = f"'{unknown[0]}'" if unknown else f"name '{name}'"
        raise _bad(f"views: {wrong} in a view; it has name (letters, digits, - and _), {', '.join([*kinds][1:])}, aim")
    values = {key: _typed(f"views: {key}", entry[key], kind) for key, kind in kinds.items() if key in entry}
    aim = tuple(_typed("views: aim", number, float) for number in entry.get("aim", (0.0, 0.0)))
    if len(aim) != 2 or not 0.01 <= values.get("extent", 1.0) <= 100:
        raise _bad(f"views: {name}: aim is two numbers, extent lies in 0.01..100")
    return View(**values, aim=(aim[0], aim[1]))


def _lights(value: Any) -> tuple[str, ...]:
    if isinstance(value, int):
        return tuple(RIGS)[: _count("lights", value, len(RIGS))]
    return tuple(
        dict.fromkeys(_named("lights", entry, {name: name for name in RIGS}) for entry in _listed("lights", value))
    )


def _listed(key: str, value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise _bad(f"{key} {value!r}: must be a number, or a list of names")
    return value


def _count(key: str, value: int, most: int) -> int:
    if not 1 <= value <= most:
        raise _bad(f"{key} {value}: must lie in 1..{most}")
    return value


def _named(key: str, name: Any, known: Mapping[str, Any]) -> Any:
    if name not in known:
        raise _bad(f"{key} '{name}': must be one of {', '.join(known)}")
    return known[name]


def _thresholds(value: Any) -> Thresholds:
    levels = asdict(DEFAULT_THRESHOLDS)
    for level, limits in value.items():
        if level not in levels or not isinstance(limits, dict) or {*limits} - {"delta_e", "flip", "local"}:
            raise _bad(f"thresholds: '{level}' must be {' or '.join(levels)}, each with delta_e, flip and local")
        levels[level] |= {key: _typed(f"thresholds: {level}.{key}", number, float) for key, number in limits.items()}
    low, high = Limit(**levels["indistinguishable"]), Limit(**levels["visible"])
    if not (0 < low.delta_e <= high.delta_e and 0 < low.flip <= high.flip and 0 < low.local <= high.local):
        raise _bad("thresholds: must be above 0, and those of visible not below those of indistinguishable")
    return Thresholds(low, high)


def _bad(message: str) -> FaceZipError:
    return FaceZipError(ErrorCode.BAD_VALUE, message)

"""The main job as one call: load, fit, check, write, and measure what was written."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

from facezip.character.alignment import alignments, misregistered, undecided
from facezip.character.loading import load_character
from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.cleaning.steps import clean
from facezip.files.packs import is_pack
from facezip.files.values import read_values
from facezip.files.writing import check_target
from facezip.fit.choice import Choice, choose
from facezip.fit.documents import ChoiceFacts, CompressDocument, MeasuredPack, Registration
from facezip.fit.extension import beside_neutral_of
from facezip.fit.given import GivenMasks
from facezip.fit.importance import Importance, importance_files
from facezip.fit.kept import KeptRegion
from facezip.fit.kept_errors import kept_facts
from facezip.fit.kept_files import Keeping, read_kept
from facezip.fit.locks import read_locks
from facezip.fit.mask_folder import read_masks
from facezip.fit.methods import compress
from facezip.fit.painted_files import read_painted
from facezip.fit.settings import Settings, made_with
from facezip.names import printable
from facezip.pack.errors import pack_errors
from facezip.pack.facts import pack_facts
from facezip.pack.manifest import MadeWith
from facezip.pack.model import CompressedTextures
from facezip.pack.parsing import read_manifest
from facezip.pack.write import write_pack


@dataclass(frozen=True)
class Request:
    """What is asked for besides a character and a place for its pack.

    Attributes
    ----------
    method, settings : how to fit.
    target_rmse, budget_mb : choose ``differences`` and ``weight_scale``, where one is given.
    importance : an image of how much a texel's error counts, or a folder of them, by map and tile.
    map_weights : how much a map counts.
    keep_floats : whether floats outside [0, 1] are kept, with their range.
    clean : those of :data:`facezip.cleaning.steps.STEPS` that are taken before the fit.
    given_masks : a folder of masks (:func:`facezip.fit.mask_folder.read_masks`), or None.
    locks : images of difference textures that stay as they are, by name (:func:`facezip.fit.locks.read_locks`).
    painted : images of weight maps that do (:func:`facezip.fit.painted_files.read_painted`).
    keeping : regions that stay as they are in an older pack (:func:`facezip.fit.kept_files.read_kept`), or None.
    """

    method: str = "refined"
    settings: Settings = field(default_factory=Settings)
    target_rmse: float | None = None
    budget_mb: float | None = None
    importance: Path | None = None
    map_weights: Mapping[str, float] = field(default_factory=dict)
    keep_floats: bool = False
    clean: tuple[str, ...] = ()
    given_masks: Path | None = None
    locks: Mapping[str, Path] = field(default_factory=dict)
    painted: Mapping[str, Path] = field(default_factory=dict)
    keeping: Keeping | None = None

    @property
    def goals(self) -> dict[str, float]:
        """Those of target and budget that are given."""
        goals = {"target_rmse": self.target_rmse, "budget_mb": self.budget_mb}
        return {name: value for name, value in goals.items() if value is not None}

    @property
    def stated(self) -> MadeWith:
        """What a pack says of how it was made."""
        stated = made_with(self.method, asdict(self.settings)) | self.goals
        if self.map_weights:
            stated["map_weights"] = dict(self.map_weights)
        if self.locks:
            stated["locked"] = sorted(self.locks)
        if self.painted:
            stated["locked_weights"] = sorted(self.painted)
        if self.keeping:
            stated["kept"] = self.keeping.stated
        if self.given_masks is not None:
            # As many as there are in the folder; nothing of them is random.
            stated = {name: value for name, value in stated.items() if name not in ("masks", "seed")}
            stated["given_masks"] = self.given_masks.name
        if self.clean:
            stated["clean"] = list(self.clean)
        return stated if self.importance is None else {**stated, "importance": self.importance.name}


def compress_into(
    character: Path,
    output: Path,
    request: Request,
    overwrite: bool = False,
    warn: Callable[[str], None] = lambda _: None,
) -> CompressDocument:
    """Load, clean, fit and check side by side, write, measure; what was written.

    Errors are those to the scans as they were fitted: clean ones, where that was asked for.

    Parameters
    ----------
    character, output, overwrite : as on the command line.
    request : what else is asked for.
    warn : is told, while the fit runs, which expressions are misregistered, if any; from another thread.

    Raises
    ------
    FaceZipError
        For what is wrong with the input, and ``CANNOT_WRITE``.
    """
    start = perf_counter()
    request.settings.check(request.method)
    check_target(output, overwrite, is_pack)
    given = None if request.given_masks is None else read_masks(request.given_masks)
    cleaned = clean(load_character(character, keep_floats=request.keep_floats), request.clean)
    scans = cleaned.character
    with ThreadPoolExecutor(1) as beside:
        # It waits for the interpreter as long as for a core; a fit seldom needs the one, and leaves gaps on the other.
        checked = beside.submit(check_registration, scans, scans.expressions, character, warn)
        fit = _fitted(scans, request, given)
        registration = checked.result()
    measured = write_measured(fit.scans, fit.model, output, overwrite, fit.stated)
    return CompressDocument(
        **vars(measured),
        **vars(registration),
        pack=str(output),
        seconds=round(perf_counter() - start, 3),
        kept=kept_facts(fit.scans, fit.kept, output) if fit.kept else None,
        choice=ChoiceFacts(reason=fit.choice.reason, tried=fit.choice.tried) if fit.choice else None,
        cleaning=cleaned.facts if request.clean else None,
    )


@dataclass(frozen=True)
class _Fitted:
    """A model, the scans that it was fitted to, what its pack says of its making, and what was chosen or kept."""

    scans: Character
    model: CompressedTextures
    stated: MadeWith
    choice: Choice | None = None
    kept: KeptRegion | None = None


def _fitted(scans: Character, request: Request, given: GivenMasks | None) -> _Fitted:
    importance = None if request.importance is None else read_importance(request.importance, scans)
    if request.goals:
        choice = _chosen(scans, request, importance)
        found = {"differences": choice.trial.differences, "weight_scale": choice.trial.weight_scale}
        return _Fitted(scans, choice.model, request.stated | found, choice)
    settings, kept, stated = request.settings, None, request.stated
    slots = min(settings.differences, len(scans.expressions))
    locks = read_locks(request.locks, scans, slots)
    painted = read_painted(request.painted, scans, slots, settings.weight_scale)
    if request.keeping:
        kept = read_kept(request.keeping, scans, slots, settings.weight_scale)
        scans = beside_neutral_of(kept.stored, scans)
        stated |= {"nonnegative": True} if kept.nonnegative else {}
    model = compress(
        scans,
        request.method,
        **asdict(settings),
        given_masks=given,
        locks=locks,
        painted=painted,
        kept=kept,
        importance=importance,
        map_weights=request.map_weights,
    )
    return _Fitted(scans, model, stated, kept=kept)


def write_measured(
    scans: Character, model: CompressedTextures, output: Path, overwrite: bool, stated: Mapping[str, Any]
) -> MeasuredPack:
    """Write the pack, read it back, and describe it; ``stated`` is what the pack says of how it was made."""
    write_pack(model, output, made_with=stated, overwrite=overwrite)
    errors = pack_errors(scans, output)
    return MeasuredPack(
        **vars(pack_facts(output, read_manifest(output))),
        rmse=errors[ALBEDO].mean,
        rmse_per_expression=errors[ALBEDO].per_expression,
        errors=errors,
        region="mask" if scans.masked else "whole texture",
    )


def check_registration(
    scans: Character, names: Sequence[str], folder: Path, warn: Callable[[str], None]
) -> Registration:
    """Tell ``warn`` which of some expressions are off the neutral, if any; what documents say of them."""
    found = alignments(scans, names)
    off, unknown = misregistered(found), undecided(found)
    if off or unknown:
        warn(registration_warning(folder, off, unknown))
    return Registration(misregistered=off, unknown=unknown)


def registration_warning(character: str | Path, off: Mapping[str, float], unknown: Sequence[str] = ()) -> str:
    """One line about expressions, how many texels they are off at the worst place, and those that cannot be told."""
    parts = []
    if off:
        worst = sorted(off, key=off.__getitem__, reverse=True)[:3]
        some = ", ".join(f"{name} by {off[name]:.1f} texels" if off[name] else name for name in worst)
        more = ", ..." if len(off) > len(worst) else ""
        parts.append(f"{len(off)} of the expressions {'is' if len(off) == 1 else 'are'} off the neutral ({some}{more})")
    if unknown:
        some = ", ".join(unknown[:3]) + (", ..." if len(unknown) > 3 else "")
        have = "has" if len(unknown) == 1 else "have"
        parts.append(f"{len(unknown)} {have} too little in common with the neutral to tell ({some})")
    remedy = f"textures may blur; see 'facezip check {character}'"
    return printable(f"facezip: warning: {'; '.join(parts)}; {remedy}")


def read_importance(path: Path, scans: Character) -> Importance:
    """One image, or those of a folder as ``facezip importance`` writes it: by map and tile, the albedo's at least."""
    if not path.is_dir():
        return read_values(path)
    first, names = scans.maps[0].name, importance_files(scans)
    there = {key: path / name for key, name in names.items() if key[0] == first or (path / name).exists()}
    return {key: read_values(file) for key, file in there.items()}


def _chosen(scans: Character, request: Request, importance: Importance | None) -> Choice:
    budget = None if request.budget_mb is None else request.budget_mb * 1e6
    return choose(
        scans,
        target_rmse=request.target_rmse,
        budget_bytes=budget,
        importance=importance,
        map_weights=request.map_weights,
    )

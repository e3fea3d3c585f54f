"""The rig as one call: load scans and a template, fit the shapes, compress, and write shapes, pack and record."""

from collections.abc import Callable
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from time import perf_counter

from facezip.character.loading import load_character
from facezip.character.scans import NEUTRAL, Character
from facezip.cleaning.steps import clean
from facezip.documents.document import to_json
from facezip.files.obj import write_obj
from facezip.files.packs import is_pack
from facezip.files.writing import check_target, whole_folder
from facezip.fit.methods import compress
from facezip.fit.settings import Settings, made_with
from facezip.machine.progress import track
from facezip.pack.facts import pack_facts
from facezip.pack.parsing import read_manifest
from facezip.pack.write import write_pack
from facezip.rigging.documents import Evidence, RigDocument, RigFit, RigPack, RigRequest, RigSeconds, ScanFit
from facezip.rigging.fit import Rig, fit_rig
from facezip.rigging.originals import RIG
from facezip.rigging.rigged import Rigged, rigged
from facezip.rigging.shown import shown
from facezip.rigging.template import Template, load_template
from facezip.rigging.weightmaps import Examples

SHAPES, PICTURE = "shapes", "evidence.png"


def rig_into(
    character: Path,
    template: Path,
    output: Path,
    request: RigRequest,
    overwrite: bool = False,
    picture: Callable[[Path, Rigged], None] | None = None,
) -> RigDocument:
    """Write ``shapes/``, the pack of the shapes with all maps of the scans, and ``rig.json``; returns what that holds.

    Parameters
    ----------
    character, template, output, overwrite : as on the command line.
    request : what else is asked for.
    picture : draws the evidence that scans give of each shape into a file of the rig's folder, where there is one.

    Raises
    ------
    FaceZipError
        For what is wrong with scans or template, and ``CANNOT_WRITE``.
    """
    begin = perf_counter()
    check_target(output, overwrite, is_rig)
    cleaned = clean(load_character(character), request.clean)
    scans = cleaned.character
    wanted = load_template(template, scans.meshes.topology)
    started = perf_counter()
    meshes = scans.meshes
    rig = fit_rig(meshes.neutral, meshes.deltas, meshes.topology.faces, wanted.neutral, wanted.deltas)
    seconds = {"rig": perf_counter() - started}
    made = rigged(scans, compress(scans, request.method, seed=request.seed), rig, wanted.shapes, request.maps)
    with whole_folder(output, overwrite, is_rig) as folder:
        _write_shapes(folder / SHAPES, scans, wanted, rig)
        pack = folder / f"{scans.name}.facezip"
        stated = made_with(request.method, asdict(Settings(seed=request.seed)))
        stated |= {"maps": request.maps, "rig": template.name}
        stated |= {"clean": list(request.clean)} if request.clean else {}
        write_pack(made.model, pack, name=scans.name, made_with=stated)
        if picture is not None and made.estimates:
            picture(folder / PICTURE, made)
        seconds["total"] = perf_counter() - begin
        document = RigDocument(
            **vars(_fit_facts(scans, wanted, rig)),
            evidence=_evidence(rig, made),
            pack=RigPack(path=str(output / pack.name), **vars(pack_facts(pack, read_manifest(pack)))),
            settings=request,
            damping=made.damping,
            cleaning=cleaned.facts if request.clean else None,
            seconds=RigSeconds(**{step: round(value, 3) for step, value in seconds.items()}),
        )
        (folder / RIG).write_text(to_json(document), encoding="utf-8")
    return document


def is_rig(folder: Path) -> bool:
    """Whether a folder is what :func:`rig_into` writes."""
    return (folder / RIG).is_file() and any(is_pack(path) for path in folder.glob("*.facezip"))


def _write_shapes(folder: Path, scans: Character, wanted: Template, rig: Rig) -> None:
    folder.mkdir()
    write_obj(folder / f"{NEUTRAL}.obj", scans.meshes.neutral, scans.meshes.topology)
    for name, delta in track(zip(wanted.shapes, rig.deltas, strict=True), "Writing the shapes", len(wanted.shapes)):
        write_obj(folder / f"{name}.obj", scans.meshes.neutral + delta, scans.meshes.topology)


def _fit_facts(scans: Character, wanted: Template, rig: Rig) -> RigFit:
    examples = Examples.of(rig.weights)
    sizes = (scans.meshes.deltas**2).sum(axis=2).mean(axis=1) ** 0.5
    names = scans.expressions
    return RigFit(
        character=scans.facts,
        shapes=wanted.shapes,
        example_weights={
            name: {shape: round(float(value), 4) for shape, value in zip(wanted.shapes, row, strict=True) if value > 0}
            for name, row in zip(names, rig.weights, strict=True)
        },
        fit={
            name: ScanFit(rms_left=float(left), rms_displacement=float(size))
            for name, left, size in zip(names, rig.residuals, sizes, strict=True)
        },
        unseen_shapes=[shape for shape, used in zip(wanted.shapes, rig.seen, strict=True) if not used],
        condition=examples.condition if isfinite(examples.condition) else None,
        rank=len(examples.weights),
    )


def _evidence(rig: Rig, made: Rigged) -> dict[str, Evidence]:
    """By shape: what geometry tells of it, and of geometry-aware maps what textures do."""
    textures = shown(made.estimates, made.model.expressions)
    return {
        shape: Evidence(
            determined=round(float(share), 4),
            largest_weight=round(float(weight), 4),
            **(vars(textures[shape]) if shape in textures else {}),
        )
        for shape, share, weight in zip(made.model.expressions, rig.determined, rig.weights.max(axis=0), strict=True)
    }

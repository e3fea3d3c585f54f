"""``facezip demo``: the main job on the embedded character."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Literal

import click

from facezip.character.loading import load_character, save_character
from facezip.character.scans import Character
from facezip.commands import options
from facezip.commands.words import saving_words
from facezip.documents.document import Document
from facezip.files.writing import whole_folder
from facezip.fit.documents import MeasuredPack
from facezip.fit.methods import compress
from facezip.fit.pipeline import Request, write_measured
from facezip.pack.errors import albedo_errors, mean_rmse
from render.documents.judged import Judged
from render.documents.validation import Baseline

REPORT = "report"
PACK = "character.facezip"
# Most of what a render shows of the loss is the albedo's (docs/maps.md).
MAP_WEIGHTS = {"normal": 0.25, "roughness": 0.1}


@dataclass(frozen=True, kw_only=True)
class DemoDocument(MeasuredPack, Document):
    """What ``facezip demo`` made.

    Attributes
    ----------
    pack, output, report : the pack, the folder of everything, and the page.
    packs : what renders say of the pack.
    seconds : the whole job.
    """

    format: Literal["facezip-demo/1"] = "facezip-demo/1"
    pack: str
    output: str
    report: str
    packs: Sequence[Judged]
    seconds: float


@click.command("demo")
@click.option("-o", "--output", type=options.FOLDER, default=Path("facezip-demo"), show_default=True, metavar="DIR")
@click.option("--resolution", default=512, show_default=True, metavar="TEXELS", help="Side of the textures.")
@click.option("--expressions", default=20, show_default=True, metavar="N", help="How many expressions.")
@click.option("--image-resolution", default=320, show_default=True, metavar="PIXELS", help="Side of the renders.")
@click.option("--spp", default=16, show_default=True, metavar="N", help="Samples per pixel of the renders.")
@click.option(
    "--seed", type=click.IntRange(0, 2**31), default=0, show_default=True, metavar="S", help="Another person."
)
@options.overwrite
@options.as_json
def command(
    output: Path,
    resolution: int,
    expressions: int,
    image_resolution: int,
    spp: int,
    seed: int,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Make a character, compress it, render both sides, and write the report: DIR/report/index.html.

    DIR also holds character/, a folder as your scans would be, and the pack, character.facezip.
    """
    from render.candidates import candidate
    from render.settings import Settings
    from render.validation import validate
    from reports.validation import write_validation_report
    from scenes.character import make_character
    from scenes.face.capture import MAPS

    start = perf_counter()
    with whole_folder(output, overwrite, _is_demo) as folder:
        save_character(make_character(resolution, expressions, seed, maps=MAPS[:2]), folder / "character")
        scans = load_character(folder / "character")
        pack = folder / PACK
        request = Request(map_weights=MAP_WEIGHTS)
        compressed = write_measured(scans, compress(scans, map_weights=MAP_WEIGHTS), pack, False, request.stated)
        (folder / REPORT).mkdir()
        document = validate(
            scans,
            [candidate(scans, pack)],
            folder / REPORT,
            Settings(resolution=image_resolution, spp=spp, seed=seed),
        )
        document = replace(
            document,
            baselines=baselines(scans, seed),
            command=_call(resolution, expressions, image_resolution, spp, seed),
        )
        write_validation_report(document, folder / REPORT)
    answer = DemoDocument(
        **vars(compressed),
        pack=str(output / PACK),
        output=str(output),
        report=str(output / REPORT / "index.html"),
        packs=document.packs,
        seconds=round(perf_counter() - start, 2),
    )
    options.answer(answer, as_json, lambda: _lines(answer))


def baselines(scans: Character, seed: int) -> list[Baseline]:
    """Texture errors of what else a user could pick at about the same bytes (the paper's Figure 6)."""
    rivals = {
        "paper": partial(compress, method="paper", seed=seed),
        "paper without permutation": partial(compress, method="paper-unpermuted", seed=seed),
        "PCA(4)": partial(compress, method="pca", differences=4),
    }
    rows = []
    for name, fit in rivals.items():
        model = fit(scans)
        errors = albedo_errors(scans, model)
        rows.append(
            Baseline(
                name=name,
                texture_rmse=mean_rmse(errors),
                texture_rmse_per_expression=errors,
                bytes_on_gpu=model.footprint.bytes_on_gpu,
                fetches=model.footprint.fetches,
            )
        )
    return rows


def _call(resolution: int, expressions: int, image_resolution: int, spp: int, seed: int) -> str:
    """The command that makes the same report again."""
    sizes = f"--resolution {resolution} --expressions {expressions} --image-resolution {image_resolution}"
    return f"facezip demo {sizes} --spp {spp} --seed {seed}"


def _is_demo(folder: Path) -> bool:
    return (folder / REPORT / "report.json").is_file() and (folder / "character").is_dir()


def _lines(answer: DemoDocument) -> list[str]:
    pack = answer.packs[0]
    return [
        f"{answer.output}: {len(answer.expressions)} expressions, texture RMSE {answer.rmse:.2f} of 255, "
        f"{saving_words(answer.bytes_raw_bc7 / answer.bytes_bc7)} GPU memory in BC7, {answer.seconds:.0f} s",
        f"  {pack.verdict}",
        f"  open {answer.report}",
    ]

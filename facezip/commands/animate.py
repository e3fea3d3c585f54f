"""``facezip animate``: a face in motion, original against compressed, frame by frame."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from facezip.character.loading import load_character
from facezip.commands import options
from facezip.commands.words import call
from facezip.files.writing import check_target, whole_folder
from facezip.pack.read import read_pack
from facezip.rigging.originals import originals_of
from facezip.rigging.sequences import frames_of, poses_for

if TYPE_CHECKING:
    from render.documents.animation import AnimationDocument


@click.command("animate")
@click.argument("character", type=options.FOLDER)
@click.argument("pack", type=options.FOLDER)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the report.")
@click.option(
    "--frames", type=click.IntRange(2, 2000), metavar="N", help="Frames of the loop.  [default: 4 from pose to pose]"
)
@click.option("--resolution", type=int, default=320, show_default=True, metavar="PIXELS", help="Side of a frame.")
@click.option("--spp", type=int, default=16, show_default=True, metavar="N", help="Samples per pixel.")
@click.option("--seed", type=int, default=0, show_default=True, metavar="S", help="Seed of all random numbers.")
@options.overwrite
@options.as_json
def command(
    character: Path, pack: Path, output: Path, frames: int | None, overwrite: bool, as_json: bool, **look: Any
) -> None:
    """Render a loop of blends with CHARACTER's maps and with PACK's, and report every frame.

    With ARKit's names or the embedded character's, a smile grows, the eyes blink, the mouth speaks. Expressions of any
    other pack rise and fall one after the other, alone and in pairs.

    CHARACTER has the textures of PACK's expressions, or is the scans that a rigged PACK was made from. Albedo, normal,
    roughness, specular and cavity maps are rendered, on all UDIM tiles. The error of every map is measured.
    """
    from render.animation import animate
    from render.settings import Settings
    from reports.animation import is_animation, write_animation_report

    check_target(output, overwrite, is_animation)
    scans, model = load_character(character), read_pack(pack)
    originals = originals_of(scans, model, pack)
    sequence = frames_of(poses_for(model.expressions), frames)
    film = animate(originals, model, sequence, Settings(**look))
    document = replace(film.document, pack=pack.stem, command=_call(character, pack, len(sequence), look))
    with whole_folder(output, overwrite, is_animation) as folder:
        write_animation_report(document, film.images, folder)
    answer = replace(document, output=str(output))
    options.answer(answer, as_json, lambda: _lines(answer))


def _call(character: Path, pack: Path, frames: int, look: dict[str, int]) -> str:
    """The command that makes the same report again."""
    settings = (word for name, value in look.items() for word in (f"--{name}", value))
    return call("animate", character.name, pack.name, "-o", "DIR", "--frames", frames, *settings)


def _lines(answer: "AnimationDocument") -> list[str]:
    from reports.maps import headlines

    worst, means = answer.frames[answer.worst], answer.means
    others = headlines(means.map_errors)
    return [
        f"{answer.output}: {len(answer.frames)} frames, image RMSE {means.image_rmse:.2f} of 255 in the mean, "
        f"dE2000 p95 {means.delta_e_p95:.2f}, FLIP {means.flip:.4f}",
        f"  worst    frame {worst.frame}, {worst.pose}: image RMSE {worst.image_rmse:.2f}, "
        f"dE2000 p95 {worst.delta_e_p95:.2f}, FLIP {worst.flip:.4f}",
        *([f"  maps     {others}, albedo {means.texture_rmse:.2f} of 255"] if others else []),
        f"  original {answer.original}",
        f"  {answer.seconds.total:.1f} s; open {Path(answer.output or '') / 'index.html'}",
    ]

"""The options that say how to compress, which ``compress`` and ``batch`` share."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, fields
from typing import Any

import click

from facezip.cleaning.steps import STEPS
from facezip.commands import options
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.pipeline import Request
from facezip.fit.settings import EFFORTS, USED, Settings

POSITIVE = options.FiniteRange(min=0, min_open=True)
# Methods that hold nothing as large as a texture.
STREAMED = ("refined", "pca", "masks")
SETTINGS = tuple(field.name for field in fields(Settings))
GOALS = ("target_rmse", "budget_mb")
# The options by name, as if nothing stood on the command line.
DEFAULTS: dict[str, Any] = {
    "method": Request.method,
    **asdict(Settings()),
    **dict.fromkeys(GOALS),
    "importance": None,
    "map_weights": (),
    "keep_floats": False,
    "clean": (),
    "given_masks": None,
}
ALL = "all"


def _steps(context: click.Context, option: click.Parameter, value: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(step for step in STEPS if step in value or ALL in value)


clean = click.option(
    "--clean",
    type=click.Choice([*STEPS, ALL]),
    multiple=True,
    callback=_steps,
    help="Clean the scans before the fit: register the textures, even out their exposure, or make the neutral from all "
    "scans. May be repeated.  [default: none]",
)


def fit_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options of ``DEFAULTS``, which :func:`request_of` turns into a request."""
    choice = click.Choice(list(USED))
    in_order = (
        click.option("--method", type=choice, default=Request.method, show_default=True, help="How to fit."),
        _setting("differences", "R", "How many difference textures each map gets."),
        _setting("weight_scale", "S", "Make weight maps 1/S as wide as the textures."),
        click.option(
            "--effort", type=click.Choice(EFFORTS), default=Settings.effort, show_default=True, help="How long to fit: "
            "fast is two thirds of the default's time, best several times as long (refined).",
        ),
        click.option(
            "--target-rmse", type=POSITIVE, metavar="X", help="Choose R and S: the least memory with at most this RMSE."
        ),
        click.option(
            "--budget-mb", type=POSITIVE, metavar="X", help="Choose R and S: the least RMSE within X MB, at 8 bits."
        ),
        click.option(
            "--importance", type=options.FOLDER, metavar="FILE", help="How much each texel's error counts: an "
            "image, or a folder of them.",
        ),
        click.option(
            "--map-weight", "map_weights", multiple=True, metavar="MAP=W", help="How much a map counts.  [default: 1]"
        ),
        clean,
        click.option("--float", "keep_floats", is_flag=True, help="Keep floats outside 0..1, with their range."),
        _setting("masks", "K", "How many masks on the face (paper, masks)."),
        click.option(
            "--given-masks", type=options.FOLDER, metavar="DIR", help="Use your own masks, such as those of a rig: "
            "images, and masks.toml. Implies --method masks.",
        ),
        click.option(
            "--nonnegative", is_flag=True, help="Keep weights within 0..1, so that differences are only ever "
            "added (refined, masks).",
        ),
        click.option(
            "--sparse", type=int, metavar="L", help="Use at most L difference textures in each expression, so that "
            "people can read the weights (refined).",
        ),
        _setting("restarts", "N", "How many random starts the stitching gets (paper)."),
        _setting("seed", "S", "Seed of the random numbers (paper, masks)."),
    )  # fmt: skip
    for option in reversed(in_order):
        command = option(command)
    return command


def request_of(given: Mapping[str, Any]) -> Request:
    """The request that the values of :data:`DEFAULTS` make; ``BAD_VALUE`` where a map's weight is none."""
    settings = Settings(**{name: given[name] for name in SETTINGS})
    weights = _map_weights(given["map_weights"])
    rest = {name: given[name] for name in (*GOALS, "importance", "keep_floats", "given_masks", "clean")}
    method = "masks" if given["given_masks"] else given["method"]
    return Request(method, settings, map_weights=weights, **rest)


def check_together(names: set[str], given: Mapping[str, Any]) -> None:
    """Refuse options that contradict each other, before any work; ``names`` are those that somebody gave."""
    choosing, method = any(given[goal] is not None for goal in GOALS), given["method"]
    if given["given_masks"]:
        if "method" in names and method != "masks":
            raise click.UsageError(f"--given-masks are for --method masks, not {method}")
        if names & {"masks", "seed"}:
            raise click.UsageError("--masks and --seed are for the paper's masks: leave them out with --given-masks")
        method = "masks"
    if choosing and names & {"differences", "weight_scale"}:
        raise click.UsageError("--target-rmse and --budget-mb choose --differences and --weight-scale: leave those out")
    if choosing and given["nonnegative"]:
        raise click.UsageError("--target-rmse and --budget-mb choose among free weights: leave --nonnegative out")
    if given["sparse"] is not None and (choosing or method != "refined"):
        raise click.UsageError("--sparse needs --method refined, and neither --target-rmse nor --budget-mb")
    if "effort" in names and (choosing or method != "refined"):
        raise click.UsageError("--effort needs --method refined, and neither --target-rmse nor --budget-mb")
    if method != "refined" and choosing:
        raise click.UsageError("--target-rmse and --budget-mb need --method refined")
    if method not in ("refined", "masks") and given["importance"]:
        raise click.UsageError("--importance needs --method refined or masks")
    for name in sorted(names & {"masks", "restarts"}):
        if name not in USED[method]:
            takers = " or ".join(other for other, settings in USED.items() if name in settings)
            raise click.UsageError(f"--{name} needs --method {takers}")
    if method not in ("refined", "masks") and given["nonnegative"]:
        raise click.UsageError("--nonnegative needs --method refined or masks")
    if "memory" in names and method not in STREAMED:
        raise click.UsageError(f"--memory needs --method {' or '.join(STREAMED)}: the others hold all textures")


def _setting(name: str, metavar: str, help_: str) -> Callable[..., Any]:
    flag = f"--{name.replace('_', '-')}"
    return click.option(flag, default=getattr(Settings, name), show_default=True, metavar=metavar, help=help_)


def _map_weights(pairs: Iterable[str]) -> dict[str, float]:
    """``("normal=0.5", "roughness=2")`` as a dictionary; ``BAD_VALUE`` for anything else."""
    weights: dict[str, float] = {}
    for pair in pairs:
        name, _, weight = pair.partition("=")
        try:
            if name.strip() in weights:
                raise ValueError
            weights[name.strip()] = float(weight)
        except ValueError:
            reason = "write it as MAP=0.5, each map once"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--map-weight '{pair}': {reason}") from None
    return weights

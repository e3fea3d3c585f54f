"""The ``facezip`` command: one verb a module in ``facezip.commands``, errors as one line and an exit code."""

import io
import logging
import sys
from importlib import import_module

import click

from facezip.documents.document import to_json
from facezip.documents.error import ErrorDocument, Fault
from facezip.errors import ErrorCode, ExitCode, FaceZipError
from facezip.files.muting import muted_stderr
from facezip.machine.exhaustion import ended_where_threads_cannot_go_on
from facezip.machine.progress import show_progress

VERBS = {
    "demo": "Make a head, compress it, render both sides, write a report.",
    "compress": "Compress a character into a pack.",
    "extend": "Add expressions to a pack. Its textures keep their bytes.",
    "batch": "Compress many characters, on all cores or on a cluster.",
    "doctor": "Say what is read from which file, what is unusual, and what to do.",
    "check": "Check that every expression is registered to the neutral.",
    "importance": "Find out how much each texel shows in renders, as a weight for the fit.",
    "validate": "Render scans and packs side by side, and report the difference.",
    "animate": "Render a moving face, original and compressed, and report every frame.",
    "decompress": "Write the textures of a pack: of expressions, or of a blend.",
    "rig": "Turn scans into the shapes of a template, such as ARKit's 52.",
    "view": "Show the head in the browser: sliders, poses, maps, costs.",
    "export": "Export a pack to an engine or a web page.",
    "layers": "Make a page that shows what each layer, weight map and mask does.",
    "info": "Show what a pack holds and costs.",
    "verify": "Check every byte of a pack.",
    "schema": "Print the JSON Schema of what a command prints with --json.",
    "paper": "Repeat the paper's table and figures, with our methods beside.",
    "rates": "Plot error against GPU memory, beside BC1, BC7 and ASTC.",
    "bench": "Measure what this project claims, on this machine.",
}
# What writes needs locks, and two names exchanged at a stroke; Windows has neither.
ON_WINDOWS = ("info", "verify", "schema")

EXIT_CODES = "\b\nExit codes\n" + "\n".join(f"  {code.value}  {code.meaning}" for code in ExitCode)
BEGIN = "\b\nBegin with\n  facezip demo -o demo          a character, its pack and a report, in a minute\n" + (
    "  facezip compress SCANS -o me.facezip\n  facezip validate SCANS me.facezip -o report"
)


# What Python says where there is no memory for the stack of a thread.
NO_THREAD = "can't start new thread"
NO_MEMORY = "out-of-memory", "not enough memory; use smaller textures or a larger machine"


class _Verbs(click.Group):
    """Imports the module of a verb only when that verb is called, so that ``info`` starts without a renderer."""

    def list_commands(self, context: click.Context) -> list[str]:
        return list(VERBS)

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(VERBS.items()))

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in VERBS:
            return None
        if sys.platform == "win32" and name not in ON_WINDOWS:
            raise FaceZipError(
                ErrorCode.CANNOT_WRITE, f"{name}: runs on Linux and macOS, not on Windows; use WSL, Windows' own Linux"
            )
        command = import_module(f"facezip.commands.{name}").command
        return command if isinstance(command, click.Command) else None


@click.group(
    cls=_Verbs,
    epilog=f"{BEGIN}\n\n{EXIT_CODES}",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="facezip", message="facezip %(version)s")
def facezip() -> None:
    """Compress the textures of facial blendshapes, and show in path-traced images what it costs.

    N expression textures of one person become one neutral, a few difference textures and N small weight maps. A
    shader blends them in six fetches.
    """


def main() -> None:
    """Run the command line; never shows a traceback for bad input."""
    _escape_what_cannot_be_printed()
    code, message = NO_MEMORY
    last_words = _line(message).encode(), _answer(code, message).encode()
    try:
        with ended_where_threads_cannot_go_on(ExitCode.BAD_INPUT, *last_words), show_progress():
            _say_what_is_logged()
            status = facezip.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        print(_answer("usage", error.format_message()), end="")
        status = error.exit_code
    except FaceZipError as error:
        status = _refused(error.code, str(error), error.exit_code)
    # Before the next: an Abort is a RuntimeError.
    except (click.Abort, KeyboardInterrupt):
        muted_stderr.end()
        status = _refused("interrupted", "interrupted; every output is as it was, or complete", 130)
    except (MemoryError, RuntimeError) as error:
        if isinstance(error, RuntimeError) and NO_THREAD not in str(error):
            raise
        status = _refused(*NO_MEMORY, ExitCode.BAD_INPUT)
    sys.exit(int(status or ExitCode.DONE))


def _say_what_is_logged() -> None:
    """Print what the library logs, above the bars that stand on stderr by now."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("facezip: %(message)s"))
    logging.getLogger("facezip").addHandler(handler)


def _escape_what_cannot_be_printed() -> None:
    """Names have letters that the code page of a pipe may lack: they are escaped there, as they are on stderr."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _refused(code: str, message: str, status: int) -> int:
    print(_line(message), end="", file=sys.stderr)
    print(_answer(code, message), end="")
    return status


def _line(message: str) -> str:
    return f"facezip: {message}\n"


def _answer(code: str, message: str) -> str:
    """The error for a program that asked for JSON; by the words as given, since they may be what is wrong."""
    return to_json(ErrorDocument(error=Fault(code=code, message=message))) + "\n" if "--json" in sys.argv[1:] else ""

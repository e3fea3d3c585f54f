"""``facezip view``: a pack on the screen, in the browser, served to this machine alone."""

import sys
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import click

from facezip.character.loading import load_character
from facezip.commands import options
from facezip.documents.document import Document, to_json
from facezip.names import printable
from facezip.viewer.scene import read_scene
from facezip.viewer.server import ADDRESS, files_of, serve


@dataclass(frozen=True, kw_only=True)
class ViewDocument(Document):
    """Where ``facezip view`` shows a pack, until it is ended.

    Attributes
    ----------
    pack : its folder.
    url : of the page, on this machine alone.
    """

    format: Literal["facezip-view/1"] = "facezip-view/1"
    pack: str
    url: str


@click.command("view")
@click.argument("pack", type=options.FOLDER)
@click.argument("character", type=options.FOLDER, required=False)
@click.option("--port", type=click.IntRange(0, 65535), default=0, metavar="N", help="Port; a free one if left out.")
@click.option("--no-browser", is_flag=True, help="Print the address, and open no browser.")
@options.as_json
def command(pack: Path, character: Path | None, port: int, no_browser: bool, as_json: bool) -> None:
    """Show the head of PACK in the browser: sliders, poses, maps, and what it all costs.

    With CHARACTER, the folder that PACK was made from, its original textures are there to compare with. The page comes
    from a server that only this machine can reach. Ctrl-C ends it.
    """
    files = files_of(read_scene(pack, load_character(character) if character else None))
    with serve(files, port) as server:
        address = f"http://{ADDRESS}:{server.server_port}/"
        if as_json:
            print(to_json(ViewDocument(pack=str(pack), url=address), indent=None), flush=True)
        else:
            print(printable(f"{pack}: {address}"), "  Ctrl-C ends it", sep="\n", flush=True)
        if not no_browser:
            webbrowser.open(address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print(file=sys.stderr)

"""A web server for one page, on this machine alone: a fixed list of files, read and nothing else."""

import sys
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from facezip.errors import ErrorCode, FaceZipError
from facezip.viewer.page import LICENCES, SCRIPT, STYLE, bundle_file, document_json, served_page, served_policy
from facezip.viewer.scene import Scene

ADDRESS = "127.0.0.1"
TYPES = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "json": "application/json",
    "png": "image/png",
    "txt": "text/plain; charset=utf-8",
    "zlib": "application/octet-stream",
}

Files = Mapping[str, Callable[[], bytes]]


def files_of(scene: Scene) -> Files:
    """Every file that is served, by its path; the bundle is read here, so that a missing one is said at once."""
    document = document_json(scene.document).encode()
    script, style, licences = (bundle_file(name) for name in (SCRIPT, STYLE, LICENCES))
    page = served_page()
    return {
        "/": lambda: page,
        f"/{SCRIPT}": lambda: script,
        f"/{STYLE}": lambda: style,
        f"/{LICENCES}": lambda: licences,
        "/scene.json": lambda: document,
        **{f"/{name}": content for name, content in scene.assets.items()},
    }


def serve(files: Files, port: int = 0) -> ThreadingHTTPServer:
    """A server bound to 127.0.0.1 that gives ``files`` to whoever asks for them by this machine's own name.

    A request under any other name in its Host header is refused: a page elsewhere cannot read the pack by pointing a
    name of its own to this machine. Call ``serve_forever``.

    Parameters
    ----------
    files : content by path.
    port : 0 for a free one.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` where the port is taken or not allowed.
    """
    try:
        return _Server((ADDRESS, port), files)
    except OSError as error:
        raise FaceZipError(
            ErrorCode.BAD_VALUE, f"--port {port}: {error.strerror}; choose another, or leave it out for a free one"
        ) from None


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address: tuple[str, int], files: Files) -> None:
        super().__init__(address, _Handler)
        self.files = files
        self.names = {f"{host}:{self.server_port}" for host in (ADDRESS, "localhost")}

    def handle_error(self, request: object, client_address: object) -> None:
        """A browser that closes the page while a file is on its way is no fault; anything else is shown."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    server_version = "FaceZip"
    sys_version = ""
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        self._answer(with_content=True)

    def do_HEAD(self) -> None:
        self._answer(with_content=False)

    def log_message(self, format: str, *arguments: object) -> None:  # noqa: A002
        """A terminal is for people: no line a request."""

    def _answer(self, with_content: bool) -> None:
        status, kind, content = self._found()
        self.send_response(status)
        self.send_header("Content-Type", TYPES[kind])
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Content-Security-Policy", served_policy())
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        if with_content:
            self.wfile.write(content)

    def _found(self) -> tuple[HTTPStatus, str, bytes]:
        if self.headers.get_all("Host") not in [[name] for name in self.server.names]:
            return HTTPStatus.MISDIRECTED_REQUEST, "txt", b"This server answers under this machine's own name only.\n"
        content = self.server.files.get(self.path)
        if content is None:
            return HTTPStatus.NOT_FOUND, "txt", b"No such file.\n"
        return HTTPStatus.OK, "html" if self.path == "/" else self.path.rsplit(".", 1)[-1], content()

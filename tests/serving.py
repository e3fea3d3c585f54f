"""A server of pages that answers while a test runs."""

from contextlib import contextmanager
from threading import Thread


@contextmanager
def running(server):
    """The server, in a thread of its own."""
    with server:
        thread = Thread(target=server.serve_forever, args=(0.05,), daemon=True)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()

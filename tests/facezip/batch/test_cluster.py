"""At an address is a scheduler, or it is said in one line and in time what is wrong with it."""

import socket
from contextlib import contextmanager
from threading import Thread
from time import monotonic

import pytest

from facezip.batch import cluster as module
from facezip.batch.cluster import cluster
from facezip.errors import ErrorCode, FaceZipError

pytest.importorskip("distributed", reason="dask is not installed")


@contextmanager
def listening(greeting):
    """The port of somebody who answers every call with a greeting: None hangs up, nothing is silence."""
    calls = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer():
            while True:
                try:
                    call, _ = server.accept()
                except OSError:
                    return
                if greeting is None:
                    call.close()
                    continue
                calls.append(call)
                call.sendall(greeting)

        Thread(target=answer, daemon=True).start()
        yield server.getsockname()[1]
        server.shutdown(socket.SHUT_RDWR)
    for call in calls:
        call.close()


def refusal(address):
    begin = monotonic()
    with pytest.raises(FaceZipError) as caught, cluster(address):
        pass
    assert caught.value.code is ErrorCode.NO_SCHEDULER
    assert str(caught.value).startswith(f"{address}: ")
    assert "\n" not in str(caught.value)
    assert monotonic() - begin < module.PATIENCE + 3
    return str(caught.value)


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 1)
    monkeypatch.setattr(module, "REACH", 0.5)


def test_the_patience_is_less_than_a_person_is_promised():
    assert module.REACH < module.PATIENCE < 20


@pytest.mark.parametrize(
    "greeting", [b"", None, b"HTTP/1.1 400 Bad Request\r\n\r\n", b"220 mail ready\r\n", b"\1" + bytes(7)]
)
def test_what_is_no_scheduler_is_refused(impatient, greeting):
    with listening(greeting) as port:
        assert "dask scheduler" in refusal(f"tcp://127.0.0.1:{port}")


@pytest.mark.parametrize(
    "address", ["nonsense", "tcp://127.0.0.1", "http://127.0.0.1:1", "tcp://127.0.0.1:1", "tcp://[::1"]
)
def test_what_is_no_address_is_refused(impatient, address):
    refusal(address)

"""What all readers share: no error of the system or of memory leaves them as anything but a ``FaceZipError``."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError

# Flat images shrink a thousandfold and are no attack: what an image unfolds to counts from here on only ...
SPARE = 2**28
# ... and where it is a larger multiple of its file. Albedo and difference maps stay below fifty.
MOST_EXPANSION = 200


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn what the system refuses while ``path`` is read into one line.

    Raises
    ------
    FaceZipError
        ``CANNOT_READ``, or ``TOO_LARGE`` where memory does not suffice.
    """
    try:
        yield
    except OSError as error:
        raise FaceZipError(
            ErrorCode.CANNOT_READ, f"{path}: cannot be read ({error.strerror or error}); check its rights and its disk"
        ) from None
    except MemoryError:
        raise FaceZipError(
            ErrorCode.TOO_LARGE, f"{path}: does not fit into memory; make it smaller or use a larger machine"
        ) from None


def check_expansion(what: Path, decoded: int, stored: int, spare: int = SPARE) -> None:
    """Refuse what would unfold out of proportion, before memory is asked for.

    Parameters
    ----------
    what : the file or folder, for the message.
    decoded : bytes that it claims to hold.
    stored : bytes that it has on disk.
    spare : bytes that are no attack, whatever they are stored in.

    Raises
    ------
    FaceZipError
        ``TOO_LARGE``.
    """
    if decoded > max(spare, MOST_EXPANSION * stored):
        raise FaceZipError(
            ErrorCode.TOO_LARGE,
            f"{what}: claims {decoded} bytes of texels in {stored} bytes of file; that is damage or an attack",
        )

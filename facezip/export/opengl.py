"""OpenGL without a window or a display: the devices that this machine has, by EGL, and one of them to draw with."""

from collections.abc import Iterator
from contextlib import contextmanager
from ctypes.util import find_library
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from facezip.errors import ErrorCode, FaceZipError

if TYPE_CHECKING:
    import moderngl

# Of OpenGL with sampler arrays and timer queries.
VERSION = 330
SOFTWARE = ("llvmpipe", "softpipe", "swrast", "SwiftShader")
# Whatever a driver's list ends with, there are no more.
MOST = 64


@dataclass(frozen=True)
class Device:
    """One that EGL lists.

    Attributes
    ----------
    index : in that list.
    renderer, version : as its driver calls them; empty where it cannot be used.
    fault : why it cannot, else empty.
    """

    index: int
    renderer: str = ""
    version: str = ""
    fault: str = ""

    @property
    def is_software(self) -> bool:
        """Whether a processor does the work of a GPU."""
        return any(name in self.renderer for name in SOFTWARE)


def devices() -> list[Device]:
    """All devices of this machine, those that cannot be used included.

    Raises
    ------
    FaceZipError
        ``NO_GPU`` where the package or EGL itself is missing.
    """
    found = []
    for index in range(MOST):
        try:
            context = _context(index)
        except FaceZipError:
            raise
        except Exception as error:
            # The binding has one type for all that goes wrong; its list ends so.
            if "requested device index" in str(error):
                break
            found.append(Device(index, fault=str(error)))
            continue
        found.append(Device(index, context.info["GL_RENDERER"], context.info["GL_VERSION"]))
        context.release()
    return found


@contextmanager
def opened(index: int | None = None) -> Iterator[tuple[Device, "moderngl.Context"]]:
    """A device to draw with while the block runs: that of an index, else the first GPU, else whatever there is.

    Raises
    ------
    FaceZipError
        ``NO_GPU`` where there is none.
    """
    listed = devices()
    usable = [device for device in listed if not device.fault and index in (None, device.index)]
    if not usable:
        faults = "; ".join(f"device {device.index}: {device.fault}" for device in listed if device.fault)
        asked = "no OpenGL by EGL here" if index is None else f"no device {index}, EGL lists {len(listed)}"
        raise FaceZipError(
            ErrorCode.NO_GPU,
            f"{asked}{f' ({faults})' if faults else ''}; install a driver, or Mesa's (libegl1, libgl1-mesa-dri)",
        )
    device = min(usable, key=lambda one: (one.is_software, one.index))
    context = _context(device.index)
    try:
        yield device, context
    finally:
        context.release()


def _context(index: int) -> "moderngl.Context":
    try:
        import moderngl
    except ImportError:
        raise FaceZipError(ErrorCode.NO_GPU, "moderngl is not installed; pip install 'facezip[gpu]'") from None
    settings: dict[str, Any] = {
        "backend": "egl",
        "device_index": index,
        # Where the system keeps no list of libraries, by the names that all drivers have.
        "libgl": find_library("GL") or "libGL.so.1",
        "libegl": find_library("EGL") or "libEGL.so.1",
    }
    return moderngl.create_context(require=VERSION, standalone=True, **settings)

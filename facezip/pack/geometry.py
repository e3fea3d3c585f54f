"""The geometry of a pack as a GLB: the neutral mesh, and every expression as a sparse morph target of whole steps.

A step is a power of two and the scale of the node, so that positions in steps are exact; KHR_mesh_quantization is what
allows displacements of 16 bits. A vertex on a UV seam is several vertices of the file: attributes that viewers ignore
say which, and give what ``v`` down cannot express.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.gltf import vertex_normals
from facezip.files.accessors import GlbFault, GltfObject
from facezip.files.glb import Glb
from facezip.files.glb_builder import INDICES, VERTICES, GlbBuilder
from facezip.files.obj import Topology
from facezip.files.objlists import MAX_COORDINATE
from facezip.files.reading import MOST_EXPANSION, SPARE
from facezip.names import one_form

QUANTIZATION = "KHR_mesh_quantization"
# Of the largest side of the neutral's bounding box, its height as a rule: how far off a point may be.
TOLERANCE = 1e-5
SMALLEST = 1e-30
# 1 for a vertex that is the one before it with another UV.
SEAM = "_SEAM"
# v up, where it is not 1 minus v down; else 0.
V_UP = "_V_UP"
# What ``asset.extras`` say where the unit of the numbers is known.
UNIT = {"unit": "cm"}
SKIN = {"baseColorFactor": [0.6, 0.4, 0.33, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6}
MALFORMED = (KeyError, TypeError, ValueError, AttributeError, OverflowError, IndexError)


def head_bytes(
    name: str,
    topology: Topology,
    neutral: NDArray[np.float32],
    vertices: NDArray[np.float32],
    expressions: tuple[str, ...],
    centimetres: bool = False,
) -> bytes:
    """Write a GLB that :func:`read_head` reads back.

    Parameters
    ----------
    name : of the character.
    topology : faces and UV layout; vertices that no face uses are kept, UVs that no corner uses are not.
    neutral : ``(V, 3)`` float32, kept bit for bit.
    vertices : ``(N, V, 3)`` float32, absolute positions, kept within 1e-5 of the largest side of the neutral's
        bounding box.
    expressions : N names.
    centimetres : whether the unit of positions is known, and is that.

    Raises
    ------
    GlbFault
        The head is smaller than 1e-30 units, or nearly nothing of a huge one moves, so that no reader would believe it.
    """
    vertex, uv, faces = _split(topology, len(neutral))
    step = _step(neutral, vertices)
    glb = GlbBuilder(
        {
            "asset": {"version": "2.0", "generator": "facezip"} | ({"extras": UNIT} if centimetres else {}),
            "extensionsUsed": [QUANTIZATION],
            "extensionsRequired": [QUANTIZATION],
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": name, "mesh": 0, "scale": [step, step, step]}],
            "materials": [{"name": name, "pbrMetallicRoughness": SKIN}],
        },
        gathered=True,
    )
    normals = np.rint(127 * vertex_normals(neutral, topology.faces)).astype(np.int8)
    primitive = {
        "attributes": {
            "POSITION": glb.array((neutral / np.float32(step))[vertex], VERTICES, bounds=True),
            "NORMAL": glb.array(normals[vertex], VERTICES, normalized=True),
            **_coordinates(glb, uv),
            **_seams(glb, vertex),
        },
        "indices": glb.array(faces.astype(np.uint16 if len(vertex) < 2**16 else np.uint32), INDICES),
        "material": 0,
        "targets": [
            {"POSITION": glb.sparse(_in_steps(shape, neutral, step)[vertex], bounds=True)} for shape in vertices
        ],
    }
    extras = {"targetNames": list(expressions)}
    glb.document["meshes"] = [
        {"name": name, "primitives": [primitive], "weights": [0.0] * len(expressions), "extras": extras}
    ]
    content = glb.finish().to_bytes()
    _check_proportion(len(vertex), len(expressions), len(content))
    return content


def read_head(
    content: bytes, expressions: tuple[str, ...]
) -> tuple[Topology, NDArray[np.float32], NDArray[np.float32]]:
    """Topology, neutral ``(V, 3)`` and absolute positions ``(N, V, 3)`` of a GLB of :func:`head_bytes`.

    Raises
    ------
    GlbFault
        It is damaged, laid out in another way, or not that of ``expressions``.
    """
    try:
        return _read(Glb.parse(content), expressions, len(content))
    except GlbFault:
        raise
    except MALFORMED as error:
        raise GlbFault(f"it is not laid out as the head of a pack ({type(error).__name__})") from None


def states_centimetres(content: bytes) -> bool:
    """Whether the GLB of a pack says that its numbers are centimetres; ``GlbFault`` where it is no GLB."""
    asset = Glb.parse(content).document.get("asset")
    return isinstance(asset, dict) and asset.get("extras") == UNIT


def _split(topology: Topology, count: int) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.int64]]:
    """Vertex and UV of each of the K vertices of the file, by vertex; corners ``(3 F, 1)`` as indices into those."""
    corners = topology.faces.astype(np.int64) << 32 | topology.face_uv
    lonely = np.flatnonzero(np.bincount(topology.faces.ravel(), minlength=count) == 0)
    pairs = np.concatenate([corners.ravel(), lonely << 32 | len(topology.uv)])
    keys, where = np.unique(pairs, return_inverse=True)
    uv = np.concatenate([topology.uv, np.zeros((1, 2), np.float32)])
    return keys >> 32, uv[keys & 0xFFFFFFFF], where[: corners.size, None]


def _step(neutral: NDArray[np.float32], vertices: NDArray[np.float32]) -> float:
    size = float(np.ptp(neutral.astype(np.float64), axis=0).max() or np.abs(vertices - neutral).max(initial=0) or 1)
    if size < SMALLEST:
        raise GlbFault(f"the head is smaller than {SMALLEST} units; scale it up")
    # Half a step along each axis is the farthest. Positions divided by more than 1 could underflow.
    return min(1.0, 2.0 ** math.floor(math.log2(2 / math.sqrt(3) * TOLERANCE * size)))


def _in_steps(shape: NDArray[np.float32], neutral: NDArray[np.float32], step: float) -> NDArray[Any]:
    """Displacements ``(V, 3)``: int16 where they fit, else the same whole numbers as float32."""
    steps = np.rint((shape.astype(np.float64) - neutral) / step)
    fits = np.abs(steps).max() <= np.iinfo(np.int16).max
    return steps.astype(np.int16 if fits else np.float32)


def _coordinates(glb: GlbBuilder, uv: NDArray[np.float32]) -> dict[str, int]:
    down = 1 - uv[:, 1]
    inexact = np.where(1 - down == uv[:, 1], np.float32(0), uv[:, 1])
    exact = {V_UP: glb.sparse(inexact[:, None])} if inexact.any() else {}
    return {"TEXCOORD_0": glb.array(np.stack([uv[:, 0], down], axis=1), VERTICES), **exact}


def _seams(glb: GlbBuilder, vertex: NDArray[np.int64]) -> dict[str, int]:
    again = np.diff(vertex, prepend=-1) == 0
    return {SEAM: glb.sparse(again[:, None].astype(np.uint8))} if again.any() else {}


def _check_proportion(count: int, targets: int, size: int) -> None:
    if count * 12 * (targets + 1) > max(SPARE, MOST_EXPANSION * size):
        raise GlbFault(f"{targets} expressions of {count} vertices in {size} bytes; that is damage or an attack")


def _read(
    glb: Glb, expressions: tuple[str, ...], size: int
) -> tuple[Topology, NDArray[np.float32], NDArray[np.float32]]:
    primitive, step = _only_primitive(glb, expressions)
    attributes, targets = primitive["attributes"], primitive["targets"]
    count = glb.item("accessors", attributes["POSITION"])["count"]
    _check_proportion(count, len(targets), size)
    base = _values(glb, attributes["POSITION"], (count, 3), np.float32)
    again = _values(glb, attributes[SEAM], (count, 1), np.uint8)[:, 0] if SEAM in attributes else np.zeros(count)
    if again[0] or not np.isin(again, (0, 1)).all():
        raise GlbFault("its seams are not marked as the head of a pack marks them")
    neutral = _positions(base, np.int16(0), again, step)
    vertices = np.empty((len(targets), *neutral.shape), np.float32)
    for target, shape in zip(targets, vertices, strict=True):
        steps = _values(glb, target["POSITION"], (count, 3), np.int16, np.float32)
        shape[:] = _positions(base, steps, again, step)
    return _topology(glb, primitive, np.cumsum(again == 0) - 1), neutral, vertices


def _only_primitive(glb: Glb, expressions: tuple[str, ...]) -> tuple[GltfObject, float]:
    """The primitive, and the scale of the node that shows it."""
    (mesh,), (node,) = glb.document["meshes"], glb.document["nodes"]
    (primitive,) = mesh["primitives"]
    step, *others = node["scale"]
    plain = node["mesh"] == 0 and node.keys() == {"name", "mesh", "scale"} and primitive.get("mode", 4) == 4
    if glb.document["extensionsRequired"] != [QUANTIZATION] or not plain:
        raise GlbFault("it has a transform, a mode or an extension that the head of a pack has not")
    if (
        others != [step, step]
        or type(step) is not float
        or math.frexp(step)[0] != 0.5
        or not np.finfo(np.float32).tiny <= step <= 1
    ):
        raise GlbFault("its scale is no power of two")
    names = [one_form(name) for name in mesh["extras"]["targetNames"]]
    if names != [one_form(name) for name in expressions] or len(primitive["targets"]) != len(expressions):
        raise GlbFault("its morph targets are not the expressions of the pack")
    if any(target.keys() != {"POSITION"} for target in primitive["targets"]):
        raise GlbFault("its morph targets move more than positions")
    return primitive, step


def _values(glb: Glb, accessor: Any, shape: tuple[int, int], *kinds: type[np.generic]) -> NDArray[Any]:
    values = glb.array(accessor)
    if values.shape != shape or values.dtype not in kinds:
        raise GlbFault(f"an accessor has {values.shape} values of {values.dtype}, {shape} are needed")
    return values


def _positions(base: NDArray[np.float32], steps: Any, again: NDArray[Any], step: float) -> NDArray[np.float32]:
    """``(V, 3)`` of the K positions of the file; those of one vertex have to be one."""
    with np.errstate(all="ignore"):
        places = (base + steps) * np.float32(step)
        finite = (np.abs(places) < MAX_COORDINATE).all()
    if not finite:
        raise GlbFault("a position is NaN, infinite or huge")
    repeated = np.flatnonzero(again)
    if (places[repeated] != places[repeated - 1]).any():
        raise GlbFault("a vertex on a seam is torn apart")
    return places[again == 0]


def _topology(glb: Glb, primitive: GltfObject, vertex: NDArray[np.int64]) -> Topology:
    corners = glb.array(primitive["indices"])
    if corners.shape[1] != 1 or corners.dtype.kind != "u" or len(corners) % 3 or len(corners) == 0:
        raise GlbFault("its triangles are not threes of vertex numbers")
    if corners.max() >= len(vertex):
        raise GlbFault("a triangle uses a vertex that does not exist")
    faces = corners.reshape(-1, 3).astype(np.int32)
    used = np.bincount(faces.ravel(), minlength=len(vertex)) > 0
    uv = _layout(glb, primitive["attributes"], len(vertex))[used]
    return Topology(vertex.astype(np.int32)[faces], uv, (np.cumsum(used) - 1).astype(np.int32)[faces])


def _layout(glb: Glb, attributes: GltfObject, count: int) -> NDArray[np.float32]:
    """``(K, 2)`` UVs, v up."""
    uv = _values(glb, attributes["TEXCOORD_0"], (count, 2), np.float32)
    inexact = _values(glb, attributes[V_UP], (count, 1), np.float32)[:, 0] if V_UP in attributes else np.float32(0)
    v = np.where(inexact != 0, inexact, 1 - uv[:, 1])
    layout = np.stack([uv[:, 0], v], axis=1)
    if not (np.abs(layout) < MAX_COORDINATE).all():
        raise GlbFault("a UV is NaN, infinite or huge")
    return layout

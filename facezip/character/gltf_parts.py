"""The parts of a glTF: primitives of one mesh that share a material; and which of them is the face."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from facezip.character.gltf_nodes import Nodes
from facezip.character.parts import is_called, listed, without_inner
from facezip.character.scans import MAX_EXPRESSIONS
from facezip.files.accessors import GlbFault, GltfObject
from facezip.files.glb import Glb


@dataclass(frozen=True, eq=False)
class Part:
    """What of a mesh has one material.

    Attributes
    ----------
    mesh : its number.
    primitives : the JSON of each.
    names : of the morph targets; none where it has none, or where nothing names them.
    labels : what it may be called: names of its mesh, its nodes and its material, ``MESH/PRIMITIVE`` last.
    """

    mesh: int
    primitives: tuple[GltfObject, ...]
    names: tuple[str, ...]
    labels: tuple[str, ...]

    @property
    def material(self) -> Any:
        """The number of its material; None where it has none."""
        return self.primitives[0].get("material")

    @property
    def targets(self) -> int:
        """How many morph targets it has."""
        return len(self.primitives[0].get("targets", []))


def parts_of(glb: Glb) -> list[Part]:
    """All parts, in the order of the file."""
    nodes, parts = Nodes(glb), []
    for index in range(len(glb.document.get("meshes", []))):
        mesh = glb.item("meshes", index)
        groups: dict[Any, list[tuple[int, GltfObject]]] = {}
        for number, primitive in enumerate(mesh["primitives"]):
            key = primitive.get("material"), len(primitive.get("targets", []))
            groups.setdefault(key, []).append((number, primitive))
        for group in groups.values():
            primitives = tuple(primitive for _, primitive in group)
            labels = [str(mesh.get("name", "")), *nodes.names(index), _material_name(glb, primitives[0])]
            labels = [label for label in dict.fromkeys(labels) if label]
            names = _target_names(glb, mesh, primitives[0])
            parts.append(Part(index, primitives, names, (*labels, f"{index}/{group[0][0]}")))
    return parts


def titles(parts: Sequence[Part]) -> list[str]:
    """A label of each part that is of no other."""
    shared = Counter(label for part in parts for label in {*part.labels})
    return [next(label for label in part.labels if shared[label] == 1) for part in parts]


def face_of(parts: Sequence[Part], wanted: str | None, rank: Callable[[Part], int]) -> Part:
    """The part that is the face: the one that is wanted, or of the highest ``rank``; ``GlbFault`` where in doubt."""
    called = dict(zip(map(id, parts), titles(parts), strict=True))
    some = [part for part in parts if wanted is None or is_called(wanted, part.labels)]
    if not some:
        raise GlbFault(f"none of its parts is called '{(wanted or '')[:64]}'; it has {listed(called.values())}")
    morphing = [part for part in some if part.targets]
    if not morphing:
        raise GlbFault("no mesh of it has morph targets; one, the face, has to have one for each expression")
    found = [part for part in morphing if part.names] or morphing
    if len(found) > 1:
        ranks = list(map(rank, found))
        found = [part for part, one in zip(found, ranks, strict=True) if one == max(ranks)]
    if len(found) > 1:
        found = [found[number] for number in without_inner([part.labels for part in found])] or found
    if len(found) > 1:
        among = [called[id(part)] for part in found]
        raise GlbFault(
            f"each of its parts {listed(among)} may be the face; say which in character.toml beside it: "
            f'part = "{among[0][:64]}"'
        )
    _check_targets(found[0])
    return found[0]


def _check_targets(part: Part) -> None:
    if not part.names:
        raise GlbFault("its morph targets have no names of their own (extras.targetNames); name them and export again")
    if len(part.names) > MAX_EXPRESSIONS:
        raise GlbFault(f"{len(part.names)} morph targets; at most {MAX_EXPRESSIONS} besides the neutral")


def _target_names(glb: Glb, mesh: GltfObject, primitive: GltfObject) -> tuple[str, ...]:
    """Names where exporters write them: with the mesh (most), the primitive, each target (UniVRM), or its accessor."""
    targets = primitive.get("targets", [])
    ways: list[Any] = [_extras(mesh).get("targetNames"), _extras(primitive).get("targetNames")]
    ways += [[_extras(target, key).get("name") for target in targets] for key in ("extras", "extra")]
    ways.append([_accessor_name(glb, target) for target in targets])
    for names in ways:
        are_names = isinstance(names, list) and all(isinstance(name, str) and name for name in names)
        if are_names and len(targets) == len(names) == len({*names}):
            return tuple(names)
    return ()


def _extras(entry: GltfObject, key: str = "extras") -> GltfObject:
    extras = entry.get(key)
    return extras if isinstance(extras, dict) else {}


def _accessor_name(glb: Glb, target: GltfObject) -> Any:
    return glb.item("accessors", target["POSITION"]).get("name") if "POSITION" in target else None


def _material_name(glb: Glb, primitive: GltfObject) -> str:
    return str(glb.item("materials", primitive["material"]).get("name", "")) if "material" in primitive else ""

"""Mutants of valid OBJ files beside two other readers: read with the same triangles as by both, or refused."""

import random
from collections import Counter
from pathlib import Path

from facezip import FaceZipError
from facezip.files.obj import read_obj
from tests.facezip.files.other_readers import disagreements
from tests.facezip.files.spellings import random_mesh, spell
from tests.trust import mutations
from tests.trust.findings import Row

KINDS = (*mutations.ALL, *[mutations.change_token] * 4, *[mutations.change_line] * 8)


def check_meshes(work: Path, part: float) -> list[Row]:
    """4,000 mutants, each of a spelling of its own."""
    outcomes, examples, count = Counter(), [], max(20, round(4000 * part))
    for seed in range(count):
        rng = random.Random(seed)
        content = mutations.mutate(rng, spell(rng, random_mesh(rng)), KINDS)
        outcome = outcome_of(work, content)
        outcomes[outcome.split(":")[0]] += 1
        if ":" in outcome:
            (work / f"fault-{seed}.obj").write_bytes(content)
            examples.append(f"fault-{seed}.obj: {outcome}")
    faults = {fault: outcomes[fault] for fault in ("read otherwise", "other exceptions", "refusals of several lines")}
    notes = f"{outcomes['read']} read, {outcomes['refused']} refused"
    return [Row("mutants of OBJ spellings beside two other readers", count, faults, notes, tuple(examples))]


def outcome_of(work: Path, content: bytes) -> str:
    """``read``, ``refused``, or a fault and, behind a colon, what happened."""
    mutant, simple = work / "mutant.obj", work / "plain.obj"
    mutant.write_bytes(content)
    try:
        vertices, topology = read_obj(mutant)
    except FaceZipError as refusal:
        return "refused" if "\n" not in str(refusal) else f"refusals of several lines: {refusal}"
    except Exception as error:
        return f"other exceptions: {error!r}"
    others = disagreements(content, simple, vertices, topology)
    return f"read otherwise: not so by {others}" if others else "read"

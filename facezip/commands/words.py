"""Words and numbers that several verbs say to people."""

import shlex
from typing import TYPE_CHECKING

# ``info`` starts without what measures and cleans.
if TYPE_CHECKING:
    from facezip.cleaning.steps import CleaningFacts
    from facezip.pack.errors import MapErrors
    from facezip.pack.facts import MaskFacts, PackFacts


def megabytes(count: float) -> str:
    """Bytes as a person reads them: ``4.77 MB``, powers of ten as in the paper."""
    return f"{count / 1e6:.2f} MB"


def saving_words(times: float, sign: str = "x") -> str:
    """How many times less than the textures a pack takes: ``4.0x less``; of very few expressions it may take more."""
    less, more = f"{times:.1f}", f"{1 / times:.1f}"
    if less == more:
        return "no less"
    return f"{less}{sign} less" if times > 1 else f"{more}{sign} more"


def memory_words(facts: "PackFacts") -> tuple[str, str]:
    """GPU memory and fetches in the blocks that engines hold, and memory as the paper counts it."""
    (blocks, raw_blocks), (eight, raw) = (
        (megabytes(ours), f"{megabytes(theirs)} ({saving_words(theirs / ours)})")
        for ours, theirs in ((facts.bytes_bc7, facts.bytes_raw_bc7), (facts.bytes_on_gpu, facts.bytes_raw))
    )
    return (
        f"{blocks} instead of {raw_blocks} in BC7, {facts.fetches} fetches a pixel",
        f"{eight} instead of {raw} at 8 bits a channel",
    )


def masks_words(masks: "MaskFacts") -> str:
    """How many masks weight maps are made of, their names, and the range of their activations."""
    return f"{len(masks.names)}, activations {masks.activations}: {', '.join(masks.names)}"


def error_words(found: "MapErrors") -> str:
    """The error of one map, with the best and the worst expression."""
    unit = "degrees (mean angle)" if found.is_angular else "RMSE of 255"
    each = found.per_expression
    best, worst = min(each, key=each.__getitem__), max(each, key=each.__getitem__)
    return f"{found.mean:.2f} {unit}; best {best} {each[best]:.2f}, worst {worst} {each[worst]:.2f}"


def cleaning_words(cleaning: "CleaningFacts | None") -> list[str]:
    """What ``--clean`` did, a line a step."""
    if cleaning is None:
        return []
    lines = []
    if cleaning.registration:
        moved = cleaning.registration.moved
        far = f", by up to {max(moved.values()):.2f} texels (rms)" if moved else ""
        lines.append(f"registration: {len(moved)} expressions moved onto the neutral{far}")
    if cleaning.exposure:
        gains = cleaning.exposure.gains
        most = max((abs(gain - 1) for one in gains.values() for gain in one), default=0.0)
        lines.append(f"exposure: {len(gains)} scans evened out" + (f", by up to {100 * most:.1f} %" if gains else ""))
    for name, found in (cleaning.neutral or {}).items():
        noise = f"noise {found.noise:.2f} of 255"
        done = f"made of {found.scans:.1f} scans' worth, {found.removed:.2f} of 255 changed"
        lines.append(f"neutral {name}: {noise}, {done if found.scans else 'left as it is'}")
    return lines


def call(*words: object) -> str:
    """The call of ``facezip`` with these words as a shell takes it, whatever their letters are."""
    return shlex.join(["facezip", *map(str, words)])

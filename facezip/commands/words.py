"""Words and numbers that several verbs say to people."""

from collections.abc import Mapping
from typing import Any


def megabytes(count: float) -> str:
    """Bytes as a person reads them: ``4.77 MB``, powers of ten as in the paper."""
    return f"{count / 1e6:.2f} MB"


def memory_words(facts: Mapping[str, Any]) -> tuple[str, str]:
    """GPU memory and fetches in the blocks that engines hold, and memory as the paper counts it."""
    (blocks, raw_blocks), (eight, raw) = (
        (megabytes(facts[ours]), f"{megabytes(facts[theirs])} ({facts[theirs] / facts[ours]:.1f}x less)")
        for ours, theirs in (("bytes_bc7", "bytes_raw_bc7"), ("bytes_on_gpu", "bytes_raw"))
    )
    return (
        f"{blocks} instead of {raw_blocks} in BC7, {facts['fetches']} fetches a pixel",
        f"{eight} instead of {raw} at 8 bits a channel",
    )


def masks_words(masks: Mapping[str, Any]) -> str:
    """How many masks weight maps are made of, their names, and the range of their activations."""
    return f"{len(masks['names'])}, activations {masks['activations']}: {', '.join(masks['names'])}"


def error_words(found: Mapping[str, Any]) -> str:
    """The error of one map, with the best and the worst expression."""
    key, unit = ("angular_error", "degrees (mean angle)") if "angular_error" in found else ("rmse", "RMSE of 255")
    each = found[f"{key}_per_expression"]
    best, worst = min(each, key=each.__getitem__), max(each, key=each.__getitem__)
    return f"{found[key]:.2f} {unit}; best {best} {each[best]:.2f}, worst {worst} {each[worst]:.2f}"

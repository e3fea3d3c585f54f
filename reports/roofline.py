"""``python -m reports.roofline``: what one core of this machine can do, and what an alternation of the fit makes of it.

Two limits (Williams, Waterman & Patterson, Roofline: An Insightful Visual Performance Model, 2009): how many products
are added a second, all in registers, and how many bytes are read a second, from memory. Times are those of the
processor, of one thread, and medians: other work on the machine makes them larger.
"""

import time
from collections.abc import Callable
from statistics import median

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples
from facezip.fit.sweep import weight_system
from facezip.fit.weights import solve_weights
from facezip.machine.cores import use_cores
from facezip.machine.kernels import kernel
from facezip.machine.vectors import LANES, all_of, load, plus, plus_product, store

SIZE, SLOTS, CHANNELS, WEIGHT_SCALE = 1024, 4, 3, 8
EXPRESSIONS = (8, 20, 52)
REPEATS = 9
# Far more than any cache holds.
_BYTES = 2**28


def main() -> None:
    """Print both limits, and a row for each number of expressions."""
    out, memory = np.zeros(12 * LANES, np.float32), np.ones(_BYTES // 4, np.float32)
    rounds = 100_000
    products = 12 * LANES * rounds / seconds(lambda: _multiply(rounds, out))
    read = _BYTES / seconds(lambda: _read(memory, out))
    print(f"{products / 1e9:.0f} G products added a second, {read / 1e9:.1f} GB read a second, on one core\n")
    print("| expressions | bytes a texel | products | limit, ns | sweep, ns | share | weights, ns |")
    print("|---|---|---|---|---|---|---|")
    for count in EXPRESSIONS:
        size, work = texel_bytes(count), texel_products(count)
        limit = max(size / read, work / products)
        sweep, solve = _alternation(count)
        share = f"{limit / sweep:.0%}"
        print(f"| {count} | {size} | {work} | {1e9 * limit:.1f} | {1e9 * sweep:.0f} | {share} | {1e9 * solve:.0f} |")


def texel_bytes(count: int) -> int:
    """What a sweep reads of a texel of bytes: of every expression and the neutral, and its importance."""
    return CHANNELS * (count + 1) + 4


def texel_products(count: int) -> int:
    """What a sweep cannot do without: weights between rows, a texel's system, its part of the weights' equations."""
    own = SLOTS + SLOTS * (SLOTS + 1) // 2 + SLOTS * CHANNELS
    shared = SLOTS * CHANNELS + SLOTS
    return count * (own + shared)


def seconds(work: Callable[[], object]) -> float:
    """The median time of the processor that some work takes, once it is compiled."""
    work()
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return median(times)


def _alternation(count: int) -> tuple[float, float]:
    """Seconds a texel of the sweep, and of the weights."""
    random = np.random.default_rng(0)
    textures = random.integers(0, 256, (count, SIZE, SIZE, CHANNELS), np.uint8)
    importance = np.ones((SIZE, SIZE), np.float32)
    samples = Samples(textures, textures[0].copy(), np.float32(1 / 255), importance)
    low = SIZE // WEIGHT_SCALE
    weights = random.normal(size=(low, SLOTS, count, low)).astype(np.float32)
    system = weight_system(samples, weights)
    system.regularise(system.mean_diagonal)
    sweep = seconds(lambda: weight_system(samples, weights))
    return sweep / SIZE**2, seconds(lambda: solve_weights(system, weights)) / SIZE**2


@kernel()
def _multiply(rounds: int, out: NDArray[np.float32]) -> None:
    """Twelve sums at once, which is as many as a processor needs to be busy."""
    factor, zero = all_of(np.float32(0.5)), all_of(np.float32(0))
    first = second = third = zero, zero, zero, zero
    for _ in range(rounds):
        first = plus_product(factor, first, factor)
        second = plus_product(factor, second, factor)
        third = plus_product(factor, third, factor)
    store(out, 0, first)
    store(out, 4 * LANES, second)
    store(out, 8 * LANES, third)


@kernel()
def _read(memory: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    first = second = third = fourth = all_of(np.float32(0))
    for at in range(0, len(memory) - 4 * LANES + 1, 4 * LANES):
        first = plus(first, load(memory, at))
        second = plus(second, load(memory, at + LANES))
        third = plus(third, load(memory, at + 2 * LANES))
        fourth = plus(fourth, load(memory, at + 3 * LANES))
    store(out, 0, plus(plus(first, second), plus(third, fourth)))


if __name__ == "__main__":
    use_cores(1)
    main()

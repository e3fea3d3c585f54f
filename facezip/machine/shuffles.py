"""Numbers of vectors that change places: texels apart into channels and back, and sums across a vector's numbers.

As :mod:`facezip.machine.vectors`, for compiled code alone, and with the same results whatever the registers.
"""

from collections.abc import Iterable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from facezip.machine.vectors import ABREAST, LANES, VECTOR

_NUMBER = ir.FloatType()
_LLVM = ir.VectorType(_NUMBER, LANES)


def _shuffled(builder: Any, a: Any, b: Any, places: Iterable[int]) -> Any:
    """Numbers of two vectors, those of the second counted on from those of the first."""
    at = [*places]
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(ir.IntType(32), len(at)), at))


def _start(context: Any, builder: Any, kind: Any, args: Any, numbers: Any) -> Any:
    """A pointer to several numbers of an array, as one."""
    array = context.make_array(kind)(context, builder, args[0])
    return builder.bitcast(builder.gep(array.data, [args[1]]), numbers.as_pointer())


@intrinsic(prefer_literal=True)
def split_texels(typing: Any, texels: Any, at: Any, channels: Any, out: Any, to: Any, apart: Any) -> Any:
    """Sixteen texels that lie side by side from number ``at`` on, one channel after the other: to number ``to`` of an
    array of the same type, and each channel ``apart`` from the last. How many ``channels`` there are is a constant.
    """
    count = channels.literal_value

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        number, size = context.get_data_type(signature.args[0].dtype), signature.args[0].dtype.bitwidth // 8
        kind, one = ir.VectorType(number, count * LANES), ir.VectorType(number, LANES)
        numbers = builder.load(_start(context, builder, signature.args[0], args, kind), align=size)
        to = args[4]
        for c in range(count):
            places = range(c, count * LANES, count)
            channel = _shuffled(builder, numbers, ir.Constant(kind, ir.Undefined), places)
            builder.store(channel, _start(context, builder, signature.args[3], [args[3], to], one), align=size)
            to = builder.add(to, args[5])
        return context.get_dummy_value()

    return types.void(texels, types.intp, channels, out, types.intp, types.intp), code


@intrinsic
def store_texels(typing: Any, array: Any, at: Any, channels: Any) -> Any:
    """Write three vectors, one a channel, to where :func:`split_texels` would read them."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        red, green, blue = cgutils.unpack_tuple(builder, args[2])
        both = _shuffled(builder, red, green, range(2 * LANES))
        rest = _shuffled(builder, blue, ir.Constant(_LLVM, ir.Undefined), [*range(LANES), *[0] * LANES])
        texels = _shuffled(builder, both, rest, [c * LANES + x for x in range(LANES) for c in range(3)])
        place = _start(context, builder, signature.args[0], args, ir.VectorType(_NUMBER, 3 * LANES))
        builder.store(texels, place, align=4)
        return context.get_dummy_value()

    return types.void(array, types.intp, channels), code


@intrinsic
def transposed(typing: Any, rows: Any) -> Any:
    """Four vectors, of which every four numbers of each, side by side, are turned over as a square of 4 x 4."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        a, b, c, d = cgutils.unpack_tuple(builder, args[0])
        fours, found = range(0, LANES, ABREAST), []
        for k in (0, 2):
            pairs = [at for four in fours for at in (four + k, LANES + four + k, four + k + 1, LANES + four + k + 1)]
            near, far = _shuffled(builder, a, b, pairs), _shuffled(builder, c, d, pairs)
            for part in (0, 2):
                both = [at + part for four in fours for at in (four, four + 1, LANES + four, LANES + four + 1)]
                found.append(_shuffled(builder, near, far, both))
        return context.make_tuple(builder, signature.return_type, found)

    return rows(rows), code


def _halves(builder: Any, a: Any, b: Any, part: int) -> Any:
    """Both vectors with groups of ``part`` numbers folded in two."""
    near = [group + k for group in range(0, LANES, part) for k in range(part // 2)]
    low, high = ([*at, *(LANES + k for k in at)] for at in (near, [k + part // 2 for k in near]))
    return builder.fadd(_shuffled(builder, a, b, low), _shuffled(builder, a, b, high))


@intrinsic
def folded(typing: Any, rows: Any) -> Any:
    """Of four vectors, the sums over every fourth number: vector q's from number k on is number 4 k + q."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        a, b, c, d = cgutils.unpack_tuple(builder, args[0])
        sums = _halves(builder, _halves(builder, a, b, LANES), _halves(builder, c, d, LANES), LANES // 2)
        return _shuffled(builder, sums, sums, [4 * q + k for k in range(4) for q in range(4)])

    return VECTOR(rows), code


@intrinsic
def add_fours(typing: Any, array: Any, at: Any, apart: Any, vector: Any) -> Any:
    """Add every four numbers of a vector to an array from ``at`` on, each four ``apart`` from the last."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        four, at = ir.VectorType(_NUMBER, 4), args[1]
        for k in range(0, LANES, 4):
            place = _start(context, builder, signature.args[0], [args[0], at], four)
            part = _shuffled(builder, args[3], args[3], range(k, k + 4))
            builder.store(builder.fadd(builder.load(place, align=4), part), place, align=4)
            at = builder.add(at, args[2])
        return context.get_dummy_value()

    return types.void(array, types.intp, types.intp, vector), code


@intrinsic
def totals(typing: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """The sums of four vectors' numbers, always taken in the same order."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        near, far = _halves(builder, args[0], args[1], LANES), _halves(builder, args[2], args[3], LANES)
        both = _halves(builder, near, far, LANES // 2)
        both = _halves(builder, both, both, 4)
        both = _halves(builder, both, both, 2)
        ends = [builder.extract_element(both, ir.Constant(ir.IntType(32), k)) for k in range(4)]
        return context.make_tuple(builder, signature.return_type, ends)

    return types.UniTuple(types.float32, 4)(a, b, c, d), code


@intrinsic
def maximum(typing: Any, a: Any) -> Any:
    """The largest number of a vector."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        most, part = args[0], LANES
        while part > 1:
            part //= 2
            near, far = (_shuffled(builder, most, most, range(k, k + part)) for k in (0, part))
            most = builder.select(builder.fcmp_ordered(">", near, far), near, far)
        return builder.extract_element(most, ir.Constant(ir.IntType(32), 0))

    return types.float32(a), code

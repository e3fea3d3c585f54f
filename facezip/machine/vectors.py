"""Vectors of 16 numbers for compiled code: what a processor does at once, or in two or four goes.

Loops over arrays are turned into vectors by the compiler, too, but each is then guarded against arrays that overlap and
against lengths that do not divide, which takes longer than a short loop itself, and its sums live in memory. Vectors
that are written as such stay in registers, and compile in a fraction of the time.

Only compiled code calls these; results are the same with vector registers of any length.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, models, register_model
from numpy.typing import NDArray

from facezip.machine.kernels import inner

LANES = 16
# Vectors that are taken at once: as many as processors need for their pipelines, and have registers for.
ABREAST = 4

_FLOAT = ir.FloatType()
_LLVM = ir.VectorType(_FLOAT, LANES)
# A product that is added may be rounded once.
_FUSED = ("contract",)


class _Vector(types.Type):  # type: ignore[misc]
    """Sixteen float32."""

    def __init__(self) -> None:
        super().__init__(name="Vector")


VECTOR = _Vector()


@register_model(_Vector)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _LLVM)


@inner()
def room(count: int) -> NDArray[np.float32]:
    """Zeros for ``count`` vectors, each within a line of the cache: one that lies across two takes twice as long."""
    numbers = np.zeros((count + 1) * LANES, np.float32)
    begin = -(np.intp(numbers.ctypes.data) // 4) % LANES
    return numbers[begin : begin + count * LANES]


def _place(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """A pointer to vectors of an array."""
    array = context.make_array(signature.args[0])(context, builder, args[0])
    at = context.cast(builder, args[1], signature.args[1], types.intp)
    return builder.bitcast(builder.gep(array.data, [at]), _LLVM.as_pointer())


def _next(builder: Any, place: Any, k: int) -> Any:
    return builder.gep(place, [ir.Constant(ir.IntType(64), k)])


def _loaded(context: Any, builder: Any, signature: Any, args: Any, count: int) -> Any:
    """So many vectors that lie one after the other, of any type of numbers, as float32."""
    number = signature.args[0].dtype
    array = context.make_array(signature.args[0])(context, builder, args[0])
    kind, size = ir.VectorType(context.get_data_type(number), LANES), number.bitwidth // 8
    place = builder.bitcast(builder.gep(array.data, [args[1]]), kind.as_pointer())
    found = [builder.load(_next(builder, place, k), align=size) for k in range(count)]
    return [builder.uitofp(one, _LLVM) for one in found] if isinstance(number, types.Integer) else found


@intrinsic
def load(typing: Any, array: Any, at: Any) -> Any:
    """Sixteen numbers of a C-contiguous array from number ``at`` on, as they lie; nothing is checked.

    They are uint8, uint16 or float32, and become float32.
    """

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _loaded(context, builder, signature, args, 1)[0]

    return VECTOR(array, types.intp), code


@intrinsic
def load_abreast(typing: Any, array: Any, at: Any) -> Any:
    """:data:`ABREAST` vectors that lie one after the other, as :func:`load` would read each."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return context.make_tuple(builder, signature.return_type, _loaded(context, builder, signature, args, ABREAST))

    return types.UniTuple(VECTOR, ABREAST)(array, types.intp), code


@intrinsic
def store(typing: Any, array: Any, at: Any, vector: Any) -> Any:
    """Write sixteen numbers to where :func:`load` reads them, or a tuple of vectors one after the other."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _place(context, builder, signature, args)
        several = isinstance(signature.args[2], types.BaseTuple)
        for k, one in enumerate(cgutils.unpack_tuple(builder, args[2]) if several else [args[2]]):
            builder.store(one, _next(builder, place, k), align=4)
        return context.get_dummy_value()

    return types.void(array, at, vector), code


@intrinsic
def prefetch(typing: Any, array: Any, at: Any) -> Any:
    """Ask for the line of the cache that holds number ``at`` of an array, which may lie beyond its end."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        number, byte = ir.IntType(32), ir.IntType(8).as_pointer()
        array = context.make_array(signature.args[0])(context, builder, args[0])
        kind = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
        ask = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
        place = builder.bitcast(builder.gep(array.data, [args[1]]), byte)
        # To read; to be kept in every cache; data.
        builder.call(ask, [place, number(0), number(3), number(1)])
        return context.get_dummy_value()

    return types.void(array, types.intp), code


def _everywhere(builder: Any, number: Any) -> Any:
    one = builder.insert_element(ir.Constant(_LLVM, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(_LLVM, ir.Undefined), lanes)


@intrinsic
def all_of(typing: Any, number: Any) -> Any:
    """Sixteen times one float32."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _everywhere(builder, args[0])

    return VECTOR(types.float32), code


@intrinsic
def all_at(typing: Any, array: Any, at: Any) -> Any:
    """Sixteen times number ``at`` of a C-contiguous float32 array; nothing is checked."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        return _everywhere(builder, builder.load(builder.gep(data, [args[1]])))

    return VECTOR(array, types.intp), code


def _of_vectors(make: Callable[..., Any], *kinds: Any) -> tuple[Any, Callable[..., Any]]:
    """Of vectors, or of tuples of as many, beside which a vector counts for each."""
    counts = [kind.count for kind in kinds if isinstance(kind, types.UniTuple)]
    result = types.UniTuple(VECTOR, counts[0]) if counts else VECTOR

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        if not counts:
            return make(builder, *args)
        each = [
            cgutils.unpack_tuple(builder, arg) if isinstance(kind, types.UniTuple) else [arg] * counts[0]
            for kind, arg in zip(kinds, args, strict=True)
        ]
        return context.make_tuple(builder, result, [make(builder, *some) for some in zip(*each, strict=True)])

    return result(*kinds), code


@intrinsic
def times(typing: Any, a: Any, b: Any) -> Any:
    """``a b``."""
    return _of_vectors(lambda builder, a, b: builder.fmul(a, b), a, b)


@intrinsic
def plus(typing: Any, a: Any, b: Any) -> Any:
    """``a + b``."""
    return _of_vectors(lambda builder, a, b: builder.fadd(a, b), a, b)


@intrinsic
def minus(typing: Any, a: Any, b: Any) -> Any:
    """``a - b``."""
    return _of_vectors(lambda builder, a, b: builder.fsub(a, b), a, b)


@intrinsic
def plus_product(typing: Any, sum_: Any, a: Any, b: Any) -> Any:
    """``sum_ + a b``, rounded once where the processor can."""

    def make(builder: Any, sum_: Any, a: Any, b: Any) -> Any:
        return builder.fadd(sum_, builder.fmul(a, b, flags=_FUSED), flags=_FUSED)

    return _of_vectors(make, sum_, a, b)


@intrinsic
def minus_product(typing: Any, sum_: Any, a: Any, b: Any) -> Any:
    """``sum_ - a b``, rounded once where the processor can."""

    def make(builder: Any, sum_: Any, a: Any, b: Any) -> Any:
        return builder.fsub(sum_, builder.fmul(a, b, flags=_FUSED), flags=_FUSED)

    return _of_vectors(make, sum_, a, b)


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


@intrinsic
def larger(typing: Any, a: Any, b: Any) -> Any:
    """The larger number of each two."""
    return _of_vectors(_larger, a, b)


@intrinsic
def clipped(typing: Any, a: Any) -> Any:
    """``a`` within 0..1."""

    def make(builder: Any, a: Any) -> Any:
        zero, one = (ir.Constant(_LLVM, [bound] * LANES) for bound in (0.0, 1.0))
        above = _larger(builder, a, zero)
        return builder.select(builder.fcmp_ordered("<", above, one), above, one)

    return _of_vectors(make, a)


@intrinsic
def reciprocal_root(typing: Any, a: Any, least: Any) -> Any:
    """``1 / sqrt(max(a, least))``."""

    def make(builder: Any, a: Any, least: Any) -> Any:
        bounded = _larger(builder, a, least)
        kind = ir.FunctionType(_LLVM, [_LLVM])
        root = cgutils.get_or_insert_function(builder.module, kind, f"llvm.sqrt.v{LANES}f32")
        return builder.fdiv(ir.Constant(_LLVM, [1.0] * LANES), builder.call(root, [bounded]))

    return _of_vectors(make, a, least)

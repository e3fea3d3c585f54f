"""Vectors of 16 numbers for compiled code: what a processor does at once, or in two or four goes.

Loops over arrays are turned into vectors by the compiler, too, but each is then guarded against arrays that overlap and
against lengths that do not divide, which takes longer than a short loop itself, and its sums live in memory. Vectors
that are written as such stay in registers, and compile in a fraction of the time.

Only compiled code calls these; results are the same with vector registers of any length.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, models, register_model

LANES = 16
# Sums that are taken at once: as many as processors need for their pipelines, and have registers for.
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


def _place(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """A pointer to 16 numbers of an array."""
    array = context.make_array(signature.args[0])(context, builder, args[0])
    at = context.cast(builder, args[1], signature.args[1], types.intp)
    return builder.bitcast(builder.gep(array.data, [at]), _LLVM.as_pointer())


@intrinsic
def load(typing: Any, array: Any, at: Any) -> Any:
    """Sixteen numbers of a C-contiguous float32 array from number ``at`` on, as they lie; nothing is checked.

    Where the array has several axes and the last one's length is a constant, the compiler knows how far apart rows are.
    """

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(_place(context, builder, signature, args), align=4)

    return VECTOR(array, at), code


@intrinsic
def store(typing: Any, array: Any, at: Any, vector: Any) -> Any:
    """Write sixteen numbers to where :func:`load` reads them."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        builder.store(args[2], _place(context, builder, signature, args), align=4)
        return context.get_dummy_value()

    return types.void(array, at, vector), code


@intrinsic
def all_of(typing: Any, number: Any) -> Any:
    """Sixteen times one float32."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        number = context.cast(builder, args[0], signature.args[0], types.float32)
        one = builder.insert_element(ir.Constant(_LLVM, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
        lanes = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return builder.shuffle_vector(one, ir.Constant(_LLVM, ir.Undefined), lanes)

    return VECTOR(number), code


@intrinsic
def load_texels(typing: Any, array: Any, at: Any) -> Any:
    """Sixteen texels of three numbers each, which lie side by side from number ``at`` on: one vector a channel."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        texels = context.make_array(signature.args[0])(context, builder, args[0])
        at = context.cast(builder, args[1], signature.args[1], types.intp)
        kind = ir.VectorType(context.get_data_type(signature.args[0].dtype), 3 * LANES)
        size = signature.args[0].dtype.bitwidth // 8
        numbers = builder.load(builder.bitcast(builder.gep(texels.data, [at]), kind.as_pointer()), align=size)
        found = []
        for c in range(3):
            places = ir.Constant(ir.VectorType(ir.IntType(32), LANES), list(range(c, 3 * LANES, 3)))
            channel = builder.shuffle_vector(numbers, ir.Constant(kind, ir.Undefined), places)
            whole = isinstance(signature.args[0].dtype, types.Integer)
            found.append(builder.uitofp(channel, _LLVM) if whole else channel)
        return context.make_tuple(builder, signature.return_type, found)

    return types.UniTuple(VECTOR, 3)(array, at), code


@intrinsic
def totals(typing: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """The sums of four vectors' numbers, always taken in the same order."""

    def halves(builder: Any, a: Any, b: Any, part: int) -> Any:
        """Both vectors with groups of ``part`` numbers folded in two."""
        groups = range(0, LANES, part)
        near = [group + k for group in groups for k in range(part // 2)]
        low, high = ([*at, *(LANES + k for k in at)] for at in (near, [k + part // 2 for k in near]))
        places = (ir.Constant(ir.VectorType(ir.IntType(32), LANES), at) for at in (low, high))
        return builder.fadd(*(builder.shuffle_vector(a, b, at) for at in places))

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        both = halves(
            builder, halves(builder, args[0], args[1], LANES), halves(builder, args[2], args[3], LANES), LANES // 2
        )
        both = halves(builder, both, both, 4)
        both = halves(builder, both, both, 2)
        ends = [builder.extract_element(both, ir.Constant(ir.IntType(32), k)) for k in range(4)]
        return context.make_tuple(builder, signature.return_type, ends)

    return types.UniTuple(types.float32, 4)(a, b, c, d), code


def _of_vectors(count: int, make: Callable[..., Any]) -> Callable[..., Any]:
    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return make(builder, *args)

    return lambda: (VECTOR(*[VECTOR] * count), code)


@intrinsic
def times(typing: Any, a: Any, b: Any) -> Any:
    """``a b``."""
    return _of_vectors(2, lambda builder, a, b: builder.fmul(a, b))()


@intrinsic
def plus(typing: Any, a: Any, b: Any) -> Any:
    """``a + b``."""
    return _of_vectors(2, lambda builder, a, b: builder.fadd(a, b))()


@intrinsic
def minus(typing: Any, a: Any, b: Any) -> Any:
    """``a - b``."""
    return _of_vectors(2, lambda builder, a, b: builder.fsub(a, b))()


@intrinsic
def plus_product(typing: Any, sum_: Any, a: Any, b: Any) -> Any:
    """``sum_ + a b``, rounded once where the processor can."""
    return _of_vectors(3, lambda builder, s, a, b: builder.fadd(s, builder.fmul(a, b, flags=_FUSED), flags=_FUSED))()


@intrinsic
def minus_product(typing: Any, sum_: Any, a: Any, b: Any) -> Any:
    """``sum_ - a b``, rounded once where the processor can."""
    return _of_vectors(3, lambda builder, s, a, b: builder.fsub(s, builder.fmul(a, b, flags=_FUSED), flags=_FUSED))()


@intrinsic
def clipped(typing: Any, a: Any) -> Any:
    """``a`` within 0..1."""

    def make(builder: Any, a: Any) -> Any:
        zero, one = (ir.Constant(_LLVM, [bound] * LANES) for bound in (0.0, 1.0))
        above = builder.select(builder.fcmp_ordered(">", a, zero), a, zero)
        return builder.select(builder.fcmp_ordered("<", above, one), above, one)

    return _of_vectors(1, make)()


@intrinsic
def reciprocal_root(typing: Any, a: Any, least: Any) -> Any:
    """``1 / sqrt(max(a, least))``."""

    def make(builder: Any, a: Any, least: Any) -> Any:
        bounded = builder.select(builder.fcmp_ordered(">", a, least), a, least)
        kind = ir.FunctionType(_LLVM, [_LLVM])
        root = cgutils.get_or_insert_function(builder.module, kind, f"llvm.sqrt.v{LANES}f32")
        return builder.fdiv(ir.Constant(_LLVM, [1.0] * LANES), builder.call(root, [bounded]))

    return _of_vectors(2, make)()

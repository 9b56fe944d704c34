"""Eight float64 lanes as one Numba value, so that a kernel reads like scalar code and runs as vector instructions.

Numba leaves LLVM's superword vectorizer off, and its loop vectorizer does not see through loops around a recurrence.
Here the vector is explicit instead: `load` and `store` move a row of an array of shape [rows, LANES], and the
arithmetic operators, `sqrt`, `fabs`, `minimum`, `maximum` and `rint` act on all lanes at once. LLVM maps them to
AVX-512, AVX2, SSE2 or NEON, whatever the processor has.
"""

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic, models, overload, register_model

LANES = 8

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)


class LanesType(types.Type):
    """Numba type of a vector of `LANES` float64."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{LANES}")


lanes = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, _VECTOR)


def _row_pointer(context: Any, builder: Any, array_type: Any, array: Any, row: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    start = builder.mul(row, ir.Constant(row.type, LANES))
    return builder.bitcast(builder.gep(data, [start]), _VECTOR.as_pointer())


@intrinsic
def load(typingctx, array, row):
    """Read a row of a C-contiguous float64 array whose last axis has `LANES` entries, counting rows flat."""

    def codegen(context, builder, signature, args):
        return builder.load(_row_pointer(context, builder, signature.args[0], *args), align=8)

    return lanes(array, types.intp), codegen


@intrinsic
def store(typingctx, array, row, value):
    """Write a row of a C-contiguous float64 array whose last axis has `LANES` entries, counting rows flat."""

    def codegen(context, builder, signature, args):
        builder.store(args[2], _row_pointer(context, builder, signature.args[0], *args[:2]), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes), codegen


@intrinsic
def splat(typingctx, number):
    """Put one number in every lane."""

    def codegen(context, builder, signature, args):
        undefined = ir.Constant(_VECTOR, ir.Undefined)
        first = builder.insert_element(undefined, args[0], ir.Constant(ir.IntType(32), 0))
        return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))

    return lanes(types.float64), codegen


def _llvm_intrinsic(name: str, n_arguments: int) -> Callable[..., Any]:
    """Make a vector function of one of LLVM's own intrinsics."""

    def codegen(context, builder, signature, args):
        function_type = ir.FunctionType(_VECTOR, [_VECTOR] * n_arguments)
        function = get_or_insert_function(builder.module, function_type, f"{name}.v{LANES}f64")
        return builder.call(function, args)

    if n_arguments == 1:
        return intrinsic(lambda typingctx, a: (lanes(lanes), codegen))
    return intrinsic(lambda typingctx, a, b: (lanes(lanes, lanes), codegen))


sqrt = _llvm_intrinsic("llvm.sqrt", 1)
fabs = _llvm_intrinsic("llvm.fabs", 1)
rint = _llvm_intrinsic("llvm.rint", 1)
minimum = _llvm_intrinsic("llvm.minnum", 2)
maximum = _llvm_intrinsic("llvm.maxnum", 2)


def _overload_arithmetic(function: Callable[..., Any], instruction: str) -> None:
    """Let an operator act on two vectors, or on a vector and a number."""

    def codegen(context, builder, signature, args):
        return getattr(builder, instruction)(*args)

    operate = intrinsic(lambda typingctx, a, b: (lanes(lanes, lanes), codegen))

    @overload(function)
    def _implementation(a, b):
        if a is lanes and b is lanes:
            return lambda a, b: operate(a, b)
        if a is lanes and isinstance(b, types.Number):
            return lambda a, b: operate(a, splat(float(b)))
        if b is lanes and isinstance(a, types.Number):
            return lambda a, b: operate(splat(float(a)), b)
        return None


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.iadd, "fadd"),
    (operator.sub, "fsub"),
    (operator.isub, "fsub"),
    (operator.mul, "fmul"),
    (operator.imul, "fmul"),
    (operator.truediv, "fdiv"),
    (operator.itruediv, "fdiv"),
):
    _overload_arithmetic(_function, _instruction)


@overload(operator.neg)
def _negate(a):
    return (lambda a: splat(-0.0) - a) if a is lanes else None

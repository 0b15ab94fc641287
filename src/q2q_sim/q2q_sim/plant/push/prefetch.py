"""Prefetch within compiled kernels: memory is asked for what is read later, which then does not wait.

It is LLVM's intrinsic `llvm.prefetch` (LLVM Language Reference), which numba offers no function for.
"""

from collections.abc import Callable, Sequence

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.base import BaseContext
from numba.core.typing.templates import Signature
from numba.extending import intrinsic, overload

from q2q_model.compiled import HOT
from q2q_model.signals.values import Array

Values = Sequence[ir.Value]
Intrinsic = tuple[Signature, Callable[[BaseContext, ir.IRBuilder, Signature, Values], ir.Value]]
"""Signature of a function in compiled code, and what writes it."""


def prefetch(table: Array, i: int, j: int) -> None:
    """Prefetch the cache line of table[i, j, 0]; without compilation do nothing."""


@intrinsic  # type: ignore[untyped-decorator]  # numba has no types
def _prefetched(_: BaseContext, table: types.Array, i: types.Integer, j: types.Integer) -> Intrinsic:
    return types.void(table, i, j), _write_prefetch


def _write_prefetch(context: BaseContext, builder: ir.IRBuilder, call: Signature, values: Values) -> ir.Value:
    """Write a call of LLVM's prefetch (to read, into all caches, of data)."""
    array = context.make_array(call.args[0])(context, builder, values[0])
    place = [values[1], values[2], context.get_constant(types.intp, 0)]
    pointer = cgutils.get_item_pointer(context, builder, call.args[0], array, place)
    pointer = builder.bitcast(pointer, ir.IntType(8).as_pointer())
    number = ir.IntType(32)
    kind = ir.FunctionType(ir.VoidType(), [pointer.type, number, number, number])
    function = builder.module.declare_intrinsic("llvm.prefetch", [pointer.type], kind)
    builder.call(function, [pointer, number(0), number(3), number(1)])
    return context.get_dummy_value()


@overload(prefetch, jit_options=HOT, strict=False)  # type: ignore[untyped-decorator]
def _compiled_prefetch(*_: types.Type) -> Callable[[Array, int, int], None]:
    return lambda table, i, j: _prefetched(table, i, j)  # noqa: PLW0108  numba compiles it

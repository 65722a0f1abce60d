"""Operations on whole numbers of a user's strategy, compiled so that what leaves 64 bits is an error.

Users do not see these messages: the reference plays the run again, and its errors have the values.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, Final

from llvmlite import ir
from numba import float64, int64, types
from numba.core.typing import templates
from numba.extending import lower_builtin as lowers

from feasibee.strategies.overflow import LEAVES, OPERATIONS, Checked

BIT, LONG = ir.IntType(1), ir.IntType(64)
LEAST: Final = LONG(-(2**63))
AbstractTemplate: Any = templates.AbstractTemplate
infer: Any = templates.infer
infer_global: Any = templates.infer_global
lower_builtin: Any = lowers


def _with_overflow(name: str) -> Callable[..., Any]:
    """Return a builder of LLVM's test whether a sum, difference or product leaves 64 bits."""

    def leaves(_context: Any, builder: Any, one: Any, other: Any) -> Any:
        return builder.extract_value(getattr(builder, f"{name}_with_overflow")(one, other), 1)

    return leaves


def _power_leaves(context: Any, builder: Any, base: Any, exponent: Any) -> Any:
    """Test the float of a power: no whole power but 2**63 is so near to 2**63 that this errs."""
    signature = float64(float64, float64)
    power = context.get_function(operator.pow, signature)
    return _float_leaves(
        context, builder, power(builder, [builder.sitofp(each, ir.DoubleType()) for each in (base, exponent)])
    )


def _float_leaves(_context: Any, builder: Any, number: Any) -> Any:
    limit = ir.DoubleType()(2.0**63)
    least = ir.DoubleType()(-(2.0**63))
    inside = builder.and_(builder.fcmp_ordered("<", number, limit), builder.fcmp_ordered(">=", number, least))
    return builder.not_(inside)


def _shift_leaves(_context: Any, builder: Any, number: Any, places: Any) -> Any:
    """Shift there and back; a shift by 64 or more, or by less than 0, is none that processors have."""
    far = builder.icmp_unsigned(">=", places, LONG(64))
    near = builder.and_(places, LONG(63))
    back = builder.ashr(builder.shl(number, near), near)
    lost = builder.icmp_signed("!=", back, number)
    wrong = builder.or_(lost, builder.icmp_signed("<", places, LONG(0)))
    return builder.select(far, builder.or_(wrong, builder.icmp_signed("!=", number, LONG(0))), wrong)


def _quotient_leaves(_context: Any, builder: Any, number: Any, by: Any) -> Any:
    return builder.and_(builder.icmp_signed("==", number, LEAST), builder.icmp_signed("==", by, LONG(-1)))


def _is_least(_context: Any, builder: Any, number: Any) -> Any:
    return builder.icmp_signed("==", number, LEAST)


LEAVING: Final[dict[Any, Callable[..., Any]]] = {
    operator.add: _with_overflow("sadd"),
    operator.sub: _with_overflow("ssub"),
    operator.mul: _with_overflow("smul"),
    operator.pow: _power_leaves,
    operator.lshift: _shift_leaves,
    operator.floordiv: _quotient_leaves,
    operator.neg: _is_least,
    abs: _is_least,
    int: _float_leaves,
}
"""Builders of the test whether a result leaves 64 bits, by operation."""


def _compile(checked: Checked) -> None:
    """Let numba compile an operation: with the types and the result that it has without the check."""

    class Template(AbstractTemplate):  # type: ignore[misc]  # numba has no types
        key = checked

        def generic(self, arguments: Any, keywords: Any) -> Any:
            return self.context.resolve_function_type(checked.operation, arguments, keywords)

    infer(Template)
    infer_global(checked, types.Function(Template))
    for kinds in ([types.Any], [types.Any, types.Any]):
        lower_builtin(checked, *kinds)(_lowered(checked))


def _lowered(checked: Checked) -> Callable[..., Any]:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = all(isinstance(each, types.Integer | types.Boolean) for each in signature.args)
        if isinstance(signature.return_type, types.Integer) and whole != (checked.operation is int):
            kind = int64 if whole else float64
            numbers = [
                context.cast(builder, each, given, kind)
                for each, given in zip(arguments, signature.args, strict=True)
            ]
            leaves = LEAVING[checked.operation](context, builder, *numbers)
            with builder.if_then(leaves, likely=False):
                context.call_conv.return_user_exc(builder, OverflowError, (f"a whole number {LEAVES}",))
        function = context.typing_context.resolve_value_type(checked.operation)
        resolved = function.get_call_type(context.typing_context, signature.args, {})
        return context.get_function(function, resolved)(builder, arguments)

    return generate


for each in OPERATIONS.values():
    _compile(each)

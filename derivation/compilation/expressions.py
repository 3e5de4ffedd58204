"""Every sympy expression in the instructions that evaluate it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import sympy

from chassym.derivation.compilation.instructions import Instructions
from chassym.derivation.compilation.parts import Kernel, Statement


class UnsupportedExpressionError(NotImplementedError):
    """A sympy function or number that has no machine code."""


# LLVM has intrinsics for these only since versions 19 and 20; C's mathematical library has always had them.
LIBRARY = {"tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "atan2": 2}
"""Functions that are called lane by lane, with the number of their arguments."""

# Beyond it a power by multiplications is less exact than the library's.
_LARGEST_PRODUCT = 8
# Comparisons with NaN are false, but for "not equal".
_PREDICATES = {
    "StrictLessThan": "olt",
    "LessThan": "ole",
    "StrictGreaterThan": "ogt",
    "GreaterThan": "oge",
    "Equality": "oeq",
    "Unequality": "une",
}


class Body:
    """One part of a kernel in the making."""

    def __init__(self, kernel: Kernel, places: Mapping[sympy.Symbol, int], lanes: int) -> None:
        self.kernel = kernel
        self.places = places
        self.values: dict[sympy.Symbol, str] = {}
        self.code = Instructions(lanes)

    def add(self, statement: Statement) -> None:
        """Compute a value, and put it where results or later parts look for it."""
        value, target = self.operand(statement.expression), statement.target
        if isinstance(target, int):
            if self.kernel.by_pass:
                self.code.store_by_pass(target, len(self.kernel.results), value)
            else:
                self.code.store(target, value)
            return
        self.values[target] = value
        if target in self.places:
            self.code.keep(self.places[target], value)

    def operand(self, expression: sympy.Expr) -> str:
        """The name, or literal, that holds an expression's value."""
        if expression.is_Symbol:
            return self._symbol(expression)
        if expression.is_number:
            return self.code.splat(_number(expression))
        method = self._methods.get(type(expression).__name__)
        if method is None:
            raise UnsupportedExpressionError(
                f"{type(expression).__name__} in {expression} has no machine code; "
                f"use sums, products, powers and {', '.join(sorted(self._methods))}"
            )
        return method(self, expression)

    def _symbol(self, symbol: sympy.Symbol) -> str:
        if symbol not in self.values:
            if symbol in self.places:
                self.values[symbol] = self.code.recall(self.places[symbol])
            elif symbol in self.kernel.arguments:
                self.values[symbol] = self.code.load(self.kernel.arguments[symbol])
            else:
                self.values[symbol] = self.code.load_constant(self.kernel.constants[symbol])
        return self.values[symbol]

    def _call(self, function: str, *operands: str) -> str:
        vector = self.code.vector
        listed = ", ".join(f"{vector} {operand}" for operand in operands)
        name = f"lanes_{function}" if function in LIBRARY else f"llvm.{function}.v{self.code.lanes}f64"
        return self.code.new(f"call {vector} @{name}({listed})")

    def _add(self, expression: sympy.Expr) -> str:
        positive = [term for term in expression.args if not _is_negative(term)]
        negative = [-term for term in expression.args if _is_negative(term)]
        total = self.operand(positive[0]) if positive else self.code.splat(0.0)
        for term in positive[1:]:
            total = self.code.binary("fadd", total, self.operand(term))
        for term in negative:
            total = self.code.binary("fsub", total, self.operand(term))
        return total

    def _mul(self, expression: sympy.Expr) -> str:
        if _is_negative(expression) and expression.args[0] == -1:
            return self.code.binary("fsub", self.code.splat(0.0), self.operand(-expression))
        over = [f for f in expression.args if not (f.is_Pow and f.exp.is_negative)]
        under = [1 / f for f in expression.args if f.is_Pow and f.exp.is_negative]
        product = self._product(over)
        return self.code.binary("fdiv", product, self._product(under)) if under else product

    def _product(self, factors: Sequence[sympy.Expr]) -> str:
        if not factors:
            return self.code.splat(1.0)
        product = self.operand(factors[0])
        for factor in factors[1:]:
            product = self.code.binary("fmul", product, self.operand(factor))
        return product

    def _pow(self, expression: sympy.Expr) -> str:
        base, exponent = expression.args
        if exponent.is_negative and exponent.is_number:
            return self.code.binary("fdiv", self.code.splat(1.0), self.operand(base**-exponent))
        factor = self.operand(base)
        number = _number(exponent) if exponent.is_number else math.nan
        if number == 0.5:
            return self._call("sqrt", factor)
        if number not in range(1, _LARGEST_PRODUCT + 1):
            return self._call("pow", factor, self.operand(exponent))
        product = factor
        for _ in range(int(number) - 1):
            product = self.code.binary("fmul", product, factor)
        return product

    def _same_name(self, expression: sympy.Expr) -> str:
        """Functions that LLVM or C's library has under sympy's name."""
        return self._call(type(expression).__name__, *map(self.operand, expression.args))

    def _magnitude(self, expression: sympy.Expr) -> str:
        return self._call("fabs", self.operand(expression.args[0]))

    def _extremum(self, expression: sympy.Expr) -> str:
        """The largest or smallest; NaN if any is NaN, as a lost contact must not hide a failed force."""
        # "Unordered or": true if either is NaN, so that the second operand's NaN needs a look of its own.
        predicate = {"Max": "ugt", "Min": "ult"}[type(expression).__name__]
        numbers = [argument for argument in expression.args if argument.is_number]
        first, *others = map(self.operand, [a for a in expression.args if not a.is_number] + numbers)
        for position, other in enumerate(others, start=1):
            chosen = self.code.select(self.code.compare(predicate, first, other), first, other)
            is_number = position >= len(expression.args) - len(numbers)
            first = (
                chosen
                if is_number
                else self.code.select(self.code.compare("uno", other, other), other, chosen)
            )
        return first

    def _heaviside(self, expression: sympy.Expr) -> str:
        """One beyond zero, zero before it, at it the second argument, which sympy sets to one half.

        One half is the mean of the slopes at a knot.
        """
        argument, corner = map(self.operand, expression.args)
        return self._step(argument, self.code.splat(0.0), corner)

    def _sign(self, expression: sympy.Expr) -> str:
        return self._step(self.operand(expression.args[0]), self.code.splat(-1.0), self.code.splat(0.0))

    def _step(self, argument: str, below: str, corner: str) -> str:
        """From a value below zero to one above it; NaN at NaN."""
        at = self.code.select(self.code.compare("oeq", argument, self.code.splat(0.0)), corner, argument)
        lower = self.code.select(self.code.compare("olt", argument, self.code.splat(0.0)), below, at)
        return self.code.select(
            self.code.compare("ogt", argument, self.code.splat(0.0)), self.code.splat(1.0), lower
        )

    def _slope_beside_a_step(self, expression: sympy.Expr) -> str:
        """Zero: sympy's derivative of a step is Dirac's delta, and the step is flat on both of its sides."""
        return self.code.splat(0.0)

    def _modulo(self, expression: sympy.Expr) -> str:
        """The remainder with the divisor's sign, as Python and sympy define it; C's has the dividend's."""
        dividend, divisor = map(self.operand, expression.args)
        rest = self.code.new(f"frem {self.code.vector} {dividend}, {divisor}")
        signs = (self.code.compare("olt", value, self.code.splat(0.0)) for value in (rest, divisor))
        opposite = self.code.logic(
            "and", self.code.logic("xor", *signs), self.code.compare("one", rest, self.code.splat(0.0))
        )
        return self.code.select(opposite, self.code.binary("fadd", rest, divisor), rest)

    def _piecewise(self, expression: sympy.Expr) -> str:
        """The first branch whose condition holds; NaN where none does."""
        value = self.code.splat(math.nan)
        for branch, condition in reversed(expression.args):
            value = self.code.select(self._condition(condition), self.operand(branch), value)
        return value

    def _condition(self, condition: sympy.Basic) -> str:
        """The name, or literal, that holds a truth value in every lane."""
        kind = type(condition).__name__
        if kind in ("BooleanTrue", "BooleanFalse"):
            return self.code.splat_truth(bool(condition))
        if kind in _PREDICATES:
            return self.code.compare(_PREDICATES[kind], *map(self.operand, condition.args))
        if kind == "Not":
            return self.code.logic("xor", self._condition(condition.args[0]), self.code.splat_truth(True))
        if kind == "ITE":  # what sympy makes of a Piecewise inside a condition
            test, one, other = map(self._condition, condition.args)
            return self.code.select_truth(test, one, other)
        if kind not in ("And", "Or"):
            raise UnsupportedExpressionError(
                f"{kind} in the condition {condition} has no machine code; "
                "use And, Not, Or, <, <=, >, >=, Eq, Ne"
            )
        first, *others = map(self._condition, condition.args)
        for other in others:
            first = self.code.logic(kind.lower(), first, other)
        return first

    _methods: Mapping[str, Callable[[Body, sympy.Expr], str]] = {
        "Add": _add,
        "Mul": _mul,
        "Pow": _pow,
        "Abs": _magnitude,
        "Max": _extremum,
        "Min": _extremum,
        "Heaviside": _heaviside,
        "sign": _sign,
        "DiracDelta": _slope_beside_a_step,
        "Mod": _modulo,
        "Piecewise": _piecewise,
        **dict.fromkeys(("sin", "cos", "exp", "log", *LIBRARY), _same_name),
    }


def _is_negative(term: sympy.Expr) -> bool:
    return bool(term.as_coeff_Mul()[0].is_negative)


def _number(expression: sympy.Expr) -> float:
    """The value of an expression without symbols."""
    try:
        return float(expression)
    except TypeError as error:
        raise UnsupportedExpressionError(
            f"the number {expression} is not real and has no machine code; use real numbers"
        ) from error

"""Reads formulas back from LaTeX: enough of it to evaluate what the package writes."""

import math
import re
from collections.abc import Callable, Mapping

FUNCTIONS: dict[str, Callable[..., float]] = {
    r"\sin": math.sin,
    r"\cos": math.cos,
    r"\max": max,
    r"\min": min,
}

TOKEN = re.compile(
    r"(?:\\d?dot\{[^{}]*\}|\\[a-z]+|[A-Za-z]'?)(?:_\{(?:[^{}]|\{[^{}]*\})*\})?"  # a symbol or a command
    r"|\d+|\S"
)


def equations_of(block: str) -> list[tuple[str, str]]:
    """Left and right-hand sides of an aligned block."""
    rows = (re.sub(r"\\\\\n|\\qquad \{\}|&", " ", row) for row in block.split("\\\\[1ex]\n"))
    return [(left.strip(), right.strip()) for left, right in (row.split("=") for row in rows)]


def evaluate(formula: str, numbers: Mapping[str, float]) -> float:
    """Give the value of a formula for the values of its symbols by their typeset names."""
    tokens = TOKEN.findall(formula.replace(r"\,", " "))
    reader = _Reader([token for token in tokens if token not in (r"\left", r"\right")], numbers)
    value = reader.sum()
    assert reader.tokens == [], f"left over: {reader.tokens}"
    return value


class _Reader:
    """Recursive descent over sums, products, powers and fractions."""

    def __init__(self, tokens: list[str], numbers: Mapping[str, float]) -> None:
        self.tokens, self.numbers = tokens, numbers

    def sum(self) -> float:
        total = self.product(-1.0) if self.accept("-") else self.product(1.0)
        while self.tokens and self.tokens[0] in ("+", "-"):
            total += self.product(1.0 if self.tokens.pop(0) == "+" else -1.0)
        return total

    def product(self, value: float) -> float:
        count = 0
        while self.tokens and self.tokens[0] not in ("+", "-", ")", "}", ","):
            value *= self.power()
            count += 1
        assert count > 0
        return value

    def power(self) -> float:
        token = self.tokens.pop(0)
        if token in FUNCTIONS:
            exponent = self.exponent()
            base = FUNCTIONS[token](*self.arguments())
            return base ** (exponent * self.exponent())
        if token in self.numbers:
            base = self.numbers[token]
        elif token == r"\frac":
            base = self.group() / self.group()
        elif token in ("(", "{"):
            self.tokens.insert(0, token)
            (base,) = self.arguments()
        else:
            base = float(token)
        return base ** self.exponent()

    def exponent(self) -> float:
        return self.group() if self.accept("^") else 1.0

    def group(self) -> float:
        (value,) = self.arguments()
        return value

    def arguments(self) -> list[float]:
        closing = {"(": ")", "{": "}"}[self.tokens.pop(0)]
        values = [self.sum()]
        while self.accept(","):
            values.append(self.sum())
        assert self.tokens.pop(0) == closing
        return values

    def accept(self, token: str) -> bool:
        if self.tokens and self.tokens[0] == token:
            self.tokens.pop(0)
            return True
        return False

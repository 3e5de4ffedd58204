"""Laws held on one side of their kinks: the pieces of Max, Min, Abs, sign, Heaviside and Piecewise."""

from collections.abc import Mapping
from itertools import product

import numpy as np
import pytest
import sympy

from chassym.derivation import Model
from chassym.derivation.kinks import Kink, held, kink_of, switches

V, W = sympy.symbols("v w", real=True)

KINKED = {
    "max": 3 * sympy.Max(V - 1, 0) + V,
    "min": sympy.Min(0, 2 * V + 1),
    "extremes of three": sympy.Max(V, 1, W) - sympy.Min(V, W, 2),
    "abs and sign": V * abs(V) + sympy.sign(W - V) * V,
    "heaviside": sympy.Heaviside(V - W) * sympy.sin(V),
    "pieces": sympy.Piecewise((V**2, V < 0), (W, V <= 1), (V + W, True)),
    "nested": sympy.Max(abs(V) - 1, 0) ** 2,
    "within": sympy.sin(sympy.Max(V, W)) / 2,
}


def on_side(expression: sympy.Expr, at: Mapping[sympy.Symbol, float]) -> sympy.Expr:
    """Continue the piece that holds at a place."""
    sides = {s: sympy.Integer(bool(s.subs(at) > 0)) for s in switches(expression)}
    return held(expression, sides)


@pytest.mark.parametrize("expression", KINKED.values(), ids=KINKED.keys())
def test_a_held_law_is_the_law_where_it_is_held_and_smooth_everywhere(expression: sympy.Expr) -> None:
    for v, w in product((-2.3, -0.4, 0.3, 1.6, 2.7), (-1.1, 0.8, 2.2)):
        place = {V: v, W: w}
        piece = on_side(expression, place)
        assert not switches(piece)
        assert float(piece.subs(place)) == pytest.approx(float(expression.subs(place)))
        beyond = {V: v + 1e-3, W: w - 1e-3}
        if on_side(expression, beyond) == piece:
            assert float(piece.subs(beyond)) == pytest.approx(float(expression.subs(beyond)))


def test_kinks_that_are_not_held_stay() -> None:
    assert held(abs(V) + abs(W), {V: sympy.S.One}) == V + abs(W)
    assert held(sympy.Max(V, W), {}) == sympy.Max(V, W)


def test_contact_is_told_from_other_corners() -> None:
    assert kink_of(V, sympy.Min(0, V)) is Kink.CONTACT_BELOW
    assert kink_of(-V, sympy.Min(0, V)) is Kink.CONTACT_ABOVE
    assert {kink_of(V, push) for push in (sympy.Max(0, V), sympy.Min(V, W), abs(V))} == {Kink.KNOT}


def test_the_sedan_held_where_it_is_moves_as_it_does(sedan: Model) -> None:
    """And a damper held on its first piece is linear across its knots."""
    generator, n = np.random.default_rng(2), sedan.size
    plain, smooth = sedan.right_hand_side, sedan.held_right_hand_side
    for _ in range(20):
        given = 0.3 * generator.normal(size=len(plain.arguments))
        sides = sedan.state_knot_distances(given) > 0
        assert smooth(np.append(given, sides)) == pytest.approx(plain(given), rel=1e-11, abs=1e-9)
    arm = n + [c.name for c in sedan.system.coordinates].index("front_left_arm_angle")
    across = np.zeros((3, len(plain.arguments)))
    across[:, arm] = -1.0, 0.0, 1.0
    below = np.zeros(len(smooth.arguments) - len(plain.arguments))
    first, middle, last = (smooth(np.append(a, below))[n:] for a in across)
    bends = first - 2 * middle + last
    assert np.abs(bends[8]) < 1e-2 * np.abs(plain(across[0])[n:] + plain(across[2])[n:])[8]

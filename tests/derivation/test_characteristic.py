"""Force laws: their values against numpy, and that energy, dissipation and remainder add up to the force."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    HELD,
    Actuator,
    Characteristic,
    DamperTable,
    ForceLaw,
    Input,
    Linear,
    Mechanism,
    Polynomial,
    Program,
    SpringTable,
    TravelPort,
    Unilateral,
    build_model,
    derive,
    prismatic,
)

Array = np.ndarray
S, V = sympy.symbols("s v", real=True)
PLACES, FORCES = (-1.0, -0.25, 0.5, 2.0), (-3.0, 0.5, 1.0, 7.0)
COMMAND = Input("command", "N")


def table(x: Array, before: float, after: float) -> Array:
    inside = np.interp(x, PLACES, FORCES)
    return inside + before * np.minimum(x - PLACES[0], 0) + after * np.maximum(x - PLACES[-1], 0)


LAWS: dict[str, tuple[Characteristic, Callable[[Array, Array, float], Array]]] = {
    "spring and damper": (Linear(3, 0.5), lambda s, v, p: 3 * s + 0.5 * v + p),
    "with a known preload": (Linear(3, 0, -7), lambda s, v, p: 3 * s - 7 + p),
    "polynomial": (
        Polynomial((2, -1, 0.5), (0, 3)),
        lambda s, v, p: 2 * s - s**2 + 0.5 * s**3 + 3 * v**2 + p,
    ),
    "damper table": (DamperTable(PLACES, FORCES, 2), lambda s, v, p: 2 * table(v, 14 / 3, 4) + p),
    "held damper table": (
        DamperTable(PLACES, FORCES, 2, outer_slopes=HELD),
        lambda s, v, p: 2 * table(v, 0, 0) + p,
    ),
    "spring table": (SpringTable(PLACES, FORCES), lambda s, v, p: table(s, 14 / 3, 4) + p),
    "spring table with bump stops": (
        SpringTable(PLACES, FORCES, outer_slopes=(50, 80)),
        lambda s, v, p: table(s, 50, 80) + p,
    ),
    "expression": (
        ForceLaw(2 * sympy.sin(S) + V * abs(V), S, V),
        lambda s, v, p: 2 * np.sin(s) + v * np.abs(v) + p,
    ),
    "expression of the rate": (ForceLaw(V**3, rate=V), lambda s, v, p: v**3 + p),
    "unilateral": (Unilateral(Linear(3, 0.5)), lambda s, v, p: np.minimum(0, 3 * s + 0.5 * v + p)),
    "actuator": (Actuator(COMMAND), lambda s, v, p: p - 0.25),
}


@pytest.fixture(params=LAWS)
def law(request: pytest.FixtureRequest) -> tuple:
    return LAWS[request.param]


@pytest.fixture
def samples() -> tuple[Array, Array]:
    s, v = np.meshgrid(np.linspace(-3, 3, 25), np.linspace(-3, 3, 25))
    return s.ravel(), v.ravel()


def test_force(law: tuple, samples: tuple, lambdified: Callable) -> None:
    characteristic, expected = law
    program = Program()
    preload = sympy.Symbol("preload", real=True)
    force = characteristic.force(program, S, V, preload)
    evaluate = lambdified(program, [S, V, preload, COMMAND.position], [force])
    for value in (0.0, -1.5):
        found = evaluate(*samples, value, 0.25)[0] * np.ones_like(samples[0])
        np.testing.assert_allclose(found, expected(*samples, value), rtol=1e-13, atol=1e-13)


def test_energy_dissipation_and_remainder_make_the_force(
    law: tuple, samples: tuple, lambdified: Callable
) -> None:
    """DV/ds + dD/dv + remainder = F, and V and D vanish where there is nothing."""
    characteristic, expected = law
    program = Program()
    preload = sympy.Symbol("preload", real=True)
    potential = program.absorb(characteristic.potential(S, preload))
    dissipation = program.absorb(characteristic.dissipation(V))
    ((by_s,),) = program.differentiate([potential], [S])
    ((by_v,),) = program.differentiate([dissipation], [V])
    total = by_s + by_v + characteristic.remainder(program, S, V, preload)
    evaluate = lambdified(program, [S, V, preload, COMMAND.position], [total])
    found = evaluate(*samples, -1.5, 0.25)[0] * np.ones_like(samples[0])
    np.testing.assert_allclose(found, expected(*samples, -1.5), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("table_class", [DamperTable, SpringTable])
def test_outer_slopes_make_the_ends_knots(table_class: Callable) -> None:
    inner = [14 / 3, 2 / 3, 4]
    continued = table_class(PLACES, FORCES).table
    assert list(continued.knots) == [-0.25, 0.5] and continued.slopes == pytest.approx(inner)
    stopped = table_class(PLACES, FORCES, outer_slopes=(50, 80)).table
    assert list(stopped.knots) == list(PLACES) and stopped.slopes == pytest.approx([50, *inner, 80])


def test_kinks_of_every_law_are_found() -> None:
    """What bends or jumps along a motion is reported, and nothing that depends on parameters alone."""
    k = sympy.Symbol("k", positive=True)
    laws = {
        "table": (SpringTable(PLACES, FORCES), {0.25, -0.5}),
        "held": (DamperTable(PLACES, FORCES, outer_slopes=HELD), {1.0, 0.25, -0.5, -2.0}),
        "step": (ForceLaw(sympy.sign(V - k) * sympy.Max(k, 3), S, V), None),
        "pieces": (ForceLaw(sympy.Piecewise((S, S < 1), (2 * S - 1, True)), S, V), {-1.0}),
        "lift": (Unilateral(Linear(5)), None),
    }
    for name, (law, knots) in laws.items():
        mechanism = Mechanism("block", gravity=0)
        block = mechanism.add_body("block", mechanism.ground, prismatic("x", "x"), (0, 0, 0), mass=1)
        port = TravelPort(mechanism.point("p", block, (0, 0, 0)), mechanism.ground, "x")
        mechanism.add_force_element("law", port, law)
        equations = derive(mechanism)
        found = equations.program.expand(equations.knot_distances)
        if knots is None:
            assert len(found) == 1, name
        else:
            at_rest = dict.fromkeys(equations.arguments, 0)
            assert {abs(float(each.xreplace(at_rest))) for each in found} == {abs(knot) for knot in knots}, (
                name
            )


@pytest.fixture
def lifting_mass() -> Mechanism:
    """Give a mass that stands on a spring which cannot pull."""
    mechanism = Mechanism("lifting mass", gravity=sympy.Symbol("g"))
    block = mechanism.add_body(
        "block", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=sympy.Symbol("m")
    )
    port = TravelPort(mechanism.point("foot", block, (0, 0, 0)), mechanism.ground, "z")
    mechanism.add_force_element("foot", port, Unilateral(Linear(sympy.Symbol("k"))), preloaded=True)
    return mechanism


def test_a_unilateral_spring_holds_a_weight_and_lets_go(lifting_mass: Mechanism) -> None:
    """The preload is the weight; k z - m g below lift-off at z = m g / k, weightless above."""
    model = build_model(lifting_mass, {"m": 2.0, "g": 9.81, "k": 1000.0})
    assert model.preloads == {"foot.preload": pytest.approx(-2 * 9.81)}
    heights = np.linspace(-0.05, 0.05, 11)
    arguments = np.zeros((3, len(heights)))
    arguments[0] = heights
    expected = np.maximum(2 * 9.81 - 1000 * heights, 0) / 2 - 9.81
    np.testing.assert_allclose(model.accelerations(arguments)[0], expected, rtol=1e-12)
    assert model.knot_distances(np.array([[2 * 9.81 / 1000], [0], [0]])) == pytest.approx(0, abs=1e-12)

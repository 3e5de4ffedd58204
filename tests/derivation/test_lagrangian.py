"""Equations of motion of somebody's own Lagrangian: closed forms, sympy's own method, the vehicles again."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pytest
import sympy
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from chassym.derivation import (
    CompiledEquations,
    Coordinate,
    EquationsOfMotion,
    Input,
    MechanismError,
    Model,
    derive,
)
from chassym.derivation.compilation.structure import describe
from chassym.derivation.from_sympy import from_lagrangian
from chassym.derivation.lagrangian import ExpressionOutput, Lagrangian
from chassym.derivation.values import build_model
from chassym.linear import damped_modes, frequency_response, linearise
from chassym.nonlinear import Harmonic, simulate, steady_state

STATES = 30

m, k, c, g, length = sympy.symbols("m k c g l", positive=True)
q, theta, u = dynamicsymbols("q theta u")
t = dynamicsymbols._t


def plain(name: str) -> sympy.Symbol:
    return sympy.Symbol(name, real=True)


def residual(equations: EquationsOfMotion) -> list[sympy.Expr]:
    return equations.program.expand(equations.residual)


def assert_equal(found: Sequence[sympy.Expr], expected: Sequence[sympy.Expr]) -> None:
    assert [sympy.simplify(a - b) for a, b in zip(found, expected, strict=True)] == [0] * len(found)


def states(
    equations: EquationsOfMotion, values: Mapping[str, float], seed: int
) -> dict[sympy.Symbol, object]:
    """Give every argument random numbers and every parameter its own."""
    generator = np.random.default_rng(seed)
    arguments = {symbol: generator.uniform(-0.5, 0.5, STATES) for symbol in equations.arguments}
    return arguments | {symbol: values[symbol.name] for symbol in equations.parameters}


def numbers(
    lambdified: Callable[..., Callable[..., list]],
    equations: EquationsOfMotion,
    results: Sequence[sympy.Expr],
    at: Mapping[sympy.Symbol, object],
) -> np.ndarray:
    """Evaluate results by numpy, shape (results, states)."""
    rows = lambdified(equations.program, list(at), results)(*at.values())
    return np.array([np.broadcast_to(np.asarray(row, dtype=float), STATES) for row in rows])


def parts(equations: EquationsOfMotion) -> list[sympy.Expr]:
    net = [q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)]
    return [*(entry for row in equations.mass_matrix for entry in row), *net]


def written(equations: EquationsOfMotion) -> list[sympy.Expr]:
    energies = equations.energies
    return [energies.kinetic, energies.potential, energies.dissipation]


def close(found: np.ndarray, expected: np.ndarray) -> bool:
    """Whether two results agree to 1e-10 of the largest one of each state."""
    return bool(np.all(np.abs(found - expected) <= 1e-10 * np.abs(expected).max(axis=0)))


# The vehicles again, from their energies


@pytest.mark.parametrize(
    "vehicle",
    ["quarter_car", "half_car", "torsion_chain", pytest.param("sedan", marks=pytest.mark.slow)],
)
def test_the_energies_of_a_vehicle_give_its_equations_again(
    vehicle: str, request: pytest.FixtureRequest, lambdified: Callable[..., Callable[..., list]]
) -> None:
    model: Model = request.getfixturevalue(vehicle)
    first, terms = model.equations, model.equations.energies
    kinetic, potential, dissipation, *applied = first.program.expand(
        [terms.kinetic, terms.potential, terms.dissipation, *terms.applied]
    )
    second = from_lagrangian(
        kinetic - potential,
        first.coordinates,
        dissipation=dissipation,
        forces=dict(zip(first.coordinates, applied, strict=True)),
        inputs=first.system.inputs,
        name=vehicle,
    )
    assert second.arguments == first.arguments
    at = states(first, model.values, seed=len(applied))
    expected, found = (numbers(lambdified, e, [*parts(e), *written(e)], at) for e in (first, second))
    n = len(applied)
    for rows in (slice(n * n), slice(n * n, n * n + n), -3, -2, -1):
        assert np.abs(expected[rows]).any()
        assert close(np.atleast_2d(found[rows]), np.atleast_2d(expected[rows]))


# Closed forms


def test_pendulum_on_a_driven_cart() -> None:
    """(M + m) x'' + m l (theta'' cos - theta'^2 sin) = F and l theta'' + x'' cos + g sin = 0."""
    M = sympy.Symbol("M", positive=True)
    x, force = dynamicsymbols("x force")
    across, down = x + length * sympy.sin(theta), length * sympy.cos(theta)
    T = M * x.diff() ** 2 / 2 + m * (across.diff(t) ** 2 + down.diff(t) ** 2) / 2
    equations = from_lagrangian(
        T + m * g * down,
        [x, theta],
        forces={x: force},
        inputs=[force],
        units={x: "m", theta: "rad"},
        name="cart",
    )
    angle, turning, a, alpha = map(plain, ("theta", "theta_rate", "x_acceleration", "theta_acceleration"))
    sine, cosine = sympy.sin(angle), sympy.cos(angle)
    expected = [
        (M + m) * a + m * length * (alpha * cosine - turning**2 * sine) - plain("force"),
        m * length * (length * alpha + a * cosine + g * sine),
    ]
    assert_equal(residual(equations), expected)
    assert [each.unit for each in equations.coordinates] == ["m", "rad"]


def test_double_pendulum_is_that_of_sympy() -> None:
    first, second = dynamicsymbols("first second")
    m2, l2 = sympy.symbols("m2 l2", positive=True)
    x = [length * sympy.sin(first), length * sympy.sin(first) + l2 * sympy.sin(second)]
    y = [-length * sympy.cos(first), -length * sympy.cos(first) - l2 * sympy.cos(second)]
    energies = [
        mass * (a.diff(t) ** 2 + b.diff(t) ** 2) / 2 - mass * g * b
        for mass, a, b in zip((m, m2), x, y, strict=True)
    ]
    method = LagrangesMethod(sum(energies), [first, second])
    method.form_lagranges_equations()
    symbols = {f.diff(): plain(f"{f.func.__name__}_rate") for f in (first, second)}
    symbols |= {f: plain(f.func.__name__) for f in (first, second)}
    equations = from_lagrangian(sum(energies), [first, second], name="double")
    expand = equations.program.expand
    net = expand([q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)])
    matrix = expand([entry for row in equations.mass_matrix for entry in row])
    assert_equal(net, list(method.forcing.xreplace(symbols)))
    assert_equal(matrix, list(method.mass_matrix.xreplace(symbols)))


def test_charge_in_a_magnetic_field_circles_at_the_cyclotron_frequency() -> None:
    """m x'' = charge B y' - k x: a term of L linear in the rates is a gyroscopic force, and does no work."""
    charge, field = sympy.symbols("charge field", positive=True)
    x, y = dynamicsymbols("x y")
    T = m * (x.diff() ** 2 + y.diff() ** 2) / 2
    vector_potential = charge * field * (x * y.diff() - y * x.diff()) / 2
    equations = from_lagrangian(T + vector_potential - k * (x**2 + y**2) / 2, [x, y], name="charge")
    names = ("x", "y", "x_rate", "y_rate", "x_acceleration", "y_acceleration")
    px, py, vx, vy, ax, ay = map(plain, names)
    push = charge * field
    assert_equal(residual(equations), [m * ax - push * vy + k * px, m * ay + push * vx + k * py])
    model = build_model(equations, {"m": 2.0, "charge": 3.0, "field": 4.0, "k": 8.0})
    found = sorted(mode.eigenvalue.imag for mode in damped_modes(linearise(model)))
    larmor = 3.0 * 4.0 / (2 * 2.0)
    assert found == pytest.approx([np.hypot(larmor, 2.0) - larmor, np.hypot(larmor, 2.0) + larmor], rel=1e-10)


def test_anharmonic_oscillator_keeps_its_exact_period() -> None:
    """x'' = -x^3 from rest at a: the period is 4 K(1/2) / a with the complete elliptic integral K."""
    beta = sympy.Symbol("beta", positive=True)
    equations = from_lagrangian(m * q.diff() ** 2 / 2 - beta * q**4 / 4, [q], name="quartic")
    model = build_model(equations, {m: 2.0, beta: 2.0})
    amplitude = 0.7
    quarter = float(sympy.elliptic_k(sympy.Rational(1, 2))) / amplitude
    times = np.array([0.0, quarter, 2 * quarter, 4 * quarter])
    still = Harmonic(1.0, {})
    motion = simulate(model, still, times, start=np.array([amplitude, 0.0]), relative_tolerance=1e-11)
    assert motion.states[0] == pytest.approx([amplitude, 0.0, -amplitude, amplitude], abs=1e-8)


def test_bead_on_a_rotating_hoop_rests_where_its_cosine_is_g_over_w2_r() -> None:
    radius, spin = sympy.symbols("radius spin", positive=True)
    T = m * radius**2 * (theta.diff() ** 2 + spin**2 * sympy.sin(theta) ** 2) / 2
    equations = from_lagrangian(T + m * g * radius * sympy.cos(theta), [theta], name="hoop")
    model = build_model(equations, {"m": 0.3, "radius": 0.5, "spin": 7.0, "g": 9.81})
    angle = np.arccos(9.81 / (7.0**2 * 0.5))
    at = np.array([[angle], [0.0], [0.0]])
    assert model.residual(at)[0, 0] == pytest.approx(0.0, abs=1e-14)
    slope = model.residual_jacobian.matrix(at[:, 0], (1, 3))
    assert slope[0, 0] / slope[0, 2] == pytest.approx((7.0 * np.sin(angle)) ** 2, rel=1e-12)


def test_pendulum_of_prescribed_length() -> None:
    """L theta'' + 2 L' theta' + g sin = 0: an input may change the momentum, and its rate then enters."""
    rope = dynamicsymbols("rope")
    T = m * (rope.diff() ** 2 + rope**2 * theta.diff() ** 2) / 2
    equations = from_lagrangian(T + m * g * rope * sympy.cos(theta), [theta], inputs=[rope], name="swing")
    names = ("theta", "theta_rate", "theta_acceleration", "rope", "rope_rate")
    angle, turning, alpha, r, pulled = map(plain, names)
    expected = m * r * (r * alpha + 2 * pulled * turning + g * sympy.sin(angle))
    assert_equal(residual(equations), [expected])


def test_relativistic_particle_has_a_mass_that_grows_with_its_rate() -> None:
    """p = gamma m v, so that M = gamma^3 m: the kinetic energy need not be quadratic."""
    light = sympy.Symbol("light", positive=True)
    equations = from_lagrangian(-m * light**2 * sympy.sqrt(1 - q.diff() ** 2 / light**2), [q], name="fast")
    gamma = 1 / sympy.sqrt(1 - plain("q_rate") ** 2 / light**2)
    assert_equal(equations.program.expand(equations.mass_matrix[0]), [gamma**3 * m])
    assert equations.bias == (0,)


def test_dissipation_and_forces() -> None:
    """A Rayleigh function resists, a force pushes, and both may contain an input and its rate."""
    equations = from_lagrangian(
        m * q.diff() ** 2 / 2 - k * (q - u) ** 2 / 2,
        [q],
        inputs=[u],
        dissipation=c * (q.diff() - u.diff()) ** 2 / 2,
        forces={q: sympy.Max(q.diff() - u, 0) * k},
        name="oscillator",
    )
    x, v, a, base, moving = map(plain, ("q", "q_rate", "q_acceleration", "u", "u_rate"))
    expected = m * a + k * (x - base) + c * (v - moving) - k * sympy.Max(v - base, 0)
    assert_equal(residual(equations), [expected])
    assert equations.program.expand(equations.knot_distances) in ([v - base], [base - v])


# What the energies show


def test_terms_of_the_sum_with_rates_are_the_kinetic_energy() -> None:
    T, V = m * length**2 * theta.diff() ** 2 / 2, -m * g * length * sympy.cos(theta)
    equations = from_lagrangian(T - V, [theta], dissipation=c * theta.diff() ** 2 / 2, name="pendulum")
    energies = equations.energies
    found = equations.program.expand([energies.kinetic, energies.potential, energies.dissipation])
    symbols = {theta.diff(): plain("theta_rate"), theta: plain("theta")}
    assert_equal(found, [each.xreplace(symbols) for each in (T, V, c * theta.diff() ** 2 / 2)])
    assert energies.applied == (0,)


def split(lagrangian: sympy.Expr) -> list[sympy.Expr]:
    """Give T and V of a Lagrangian in q."""
    equations = from_lagrangian(lagrangian, [q], name="system")
    energies = equations.energies
    return equations.program.expand([energies.kinetic, energies.potential])


def test_products_of_sums_are_split_too() -> None:
    x, v = plain("q"), plain("q_rate")
    rate = q.diff()
    assert_equal(split(m * (rate**2 / 2 - g * q)), [m * v**2 / 2, m * g * x])
    assert_equal(
        split(m * (k * (rate**2 - q) / c + g * q**2)), [m * k * v**2 / c, m * (k * x / c - g * x**2)]
    )
    mixed = (rate**2 + k * q) * (rate - c) * (1 + q)
    still = -k * c * x * (1 + x)
    assert_equal(split(mixed), [(v**2 + k * x) * (v - c) * (1 + x) - still, -still])


def test_products_that_are_kinetic_energy_and_powers_stay_as_written() -> None:
    """A large factor is not multiplied out without need; the square of a velocity is kinetic energy."""
    x, v = plain("q"), plain("q_rate")
    many = sympy.Add(*sympy.symbols("a:30")) ** 2
    kinetic, potential = split(many * (m + k * q) * q.diff() ** 2 - many * k * q**2)
    assert kinetic == many * (m + k * x) * v**2
    assert potential == many * k * x**2
    assert split(m * (q.diff() + k * q) ** 2 / 2) == [m * (v + k * x) ** 2 / 2, 0]


def test_a_snapshot_is_the_lagrangian_itself() -> None:
    system = from_lagrangian(m * q.diff() ** 2, [q], name="system").system
    assert system.snapshot() is system


def test_symbols_of_coordinates_and_functions_of_time_say_the_same() -> None:
    tilt, wind = Coordinate("tilt", "rad"), Input("wind", "N")
    angle, gust = dynamicsymbols("tilt wind")
    by_symbols = from_lagrangian(
        m * tilt.rate**2 / 2 - k * tilt.position**2 / 2,
        [tilt],
        forces={tilt: wind.position - c * wind.rate},
        inputs=[wind],
        outputs={"acceleration": (tilt.acceleration, "rad/s^2")},
        name="mast",
    )
    by_functions = from_lagrangian(
        m * angle.diff() ** 2 / 2 - k * angle**2 / 2,
        [angle],
        units={angle: "rad", gust: "N"},
        forces={angle: gust - c * gust.diff()},
        inputs=[gust],
        outputs={"acceleration": (angle.diff().diff(), "rad/s^2")},
        name="mast",
    )
    assert by_functions.system == by_symbols.system
    assert residual(by_functions) == residual(by_symbols)


def test_derivatives_not_carried_out_are() -> None:
    lazy = sympy.Derivative(length * sympy.sin(theta), dynamicsymbols._t)
    equations = from_lagrangian(m * lazy**2 / 2, [theta], name="slider")
    assert_equal(
        equations.program.expand(equations.mass_matrix[0]), [m * length**2 * sympy.cos(plain("theta")) ** 2]
    )


def test_outputs_have_units_and_are_evaluated() -> None:
    equations = from_lagrangian(
        m * q.diff() ** 2 / 2 - k * (q - u) ** 2 / 2,
        [q],
        inputs=[u],
        outputs={"pull": (k * (q - u) + c * u.diff(), "N"), "acceleration": q.diff().diff()},
        name="oscillator",
    )
    model = build_model(equations, {m: 2.0, k: 8.0, c: 0.5})
    assert [(y.name, y.unit) for y in model.system.outputs] == [("pull", "N"), ("acceleration", "1")]
    found = model.outputs(np.array([[0.3], [0.0], [7.0], [0.1], [4.0]]))[:, 0]
    assert found == pytest.approx([8.0 * 0.2 + 0.5 * 4.0, 7.0], rel=1e-14)


def test_structure_is_described_by_the_expressions() -> None:
    """Equal Lagrangians share compiled functions; another force, input or output makes another system."""
    L = m * q.diff() ** 2 / 2 - k * q**2 / 2

    def described(**more: object) -> str:
        return describe(from_lagrangian(L, [q], inputs=[u], name="oscillator", **more).system)[0]

    variants = [
        described(),
        described(forces={q: u}),
        described(dissipation=c * q.diff() ** 2),
        described(outputs={"y": q}),
        described(outputs={"y": (q, "m")}),
    ]
    assert described() == variants[0]
    assert len(set(variants)) == len(variants)


def test_derived_again_from_its_system() -> None:
    equations = from_lagrangian(m * theta.diff() ** 2 / 2 + k * sympy.cos(theta), [theta], name="pendulum")
    assert residual(derive(equations.system)) == residual(equations)
    assert residual(CompiledEquations(equations.system).equations) == residual(equations)


# The linear and the nonlinear stage


@pytest.fixture(scope="module")
def oscillator(cache_directory: str) -> Model:
    """Give a mass of 2 kg on 800 N/m and 4 N s/m, pushed and standing on a base that moves."""
    push = dynamicsymbols("push")
    equations = from_lagrangian(
        m * q.diff() ** 2 / 2 - k * (q - u) ** 2 / 2,
        [q],
        units={q: "m", u: "m", push: "N"},
        dissipation=c * (q.diff() - u.diff()) ** 2 / 2,
        forces={q: push},
        inputs=[u, push],
        outputs={"place": (q, "m"), "acceleration": (q.diff().diff(), "m/s^2")},
        name="oscillator",
    )
    return build_model(equations, {m: "2 kg", k: "0.8 N/mm", c: "4 N*s/m"})


def test_frequency_and_damping_ratio(oscillator: Model) -> None:
    (mode,) = damped_modes(linearise(oscillator))
    assert mode.frequency_hz == pytest.approx(20.0 / (2 * np.pi), rel=1e-12)
    assert mode.damping_ratio == pytest.approx(4.0 / (2 * np.sqrt(2.0 * 800.0)), rel=1e-12)
    assert linearise(oscillator).coordinate_units == ("m",)


def test_transmissibility_of_a_moving_base(oscillator: Model) -> None:
    """(k + i w c) / (k - w^2 m + i w c)."""
    frequencies = np.array([0.5, 3.0, 8.0])
    w = 2 * np.pi * frequencies
    response = frequency_response(linearise(oscillator), frequencies).select("place", "u")
    assert response == pytest.approx((800.0 + 4j * w) / (800.0 - 2.0 * w**2 + 4j * w), rel=1e-12)


def test_amplitude_at_resonance(oscillator: Model) -> None:
    """A push at the undamped natural frequency meets the damper alone: force / (c w)."""
    pushed = steady_state(oscillator, Harmonic(20.0 / (2 * np.pi), {"push": 3.0}), metrics=["place"])
    assert pushed.peak_to_peak["place"].value == pytest.approx(2 * 3.0 / (4.0 * 20.0), rel=1e-6)
    assert pushed.is_stable
    assert pushed.contact is None


def test_free_vibration(oscillator: Model) -> None:
    times = np.linspace(0.0, 1.0, 21)
    motion = simulate(
        oscillator, Harmonic(1.0, {}), times, start=np.array([0.1, 0.0]), relative_tolerance=1e-11
    )
    decay, ringing = 1.0, np.sqrt(400.0 - 1.0)
    expected = (
        0.1 * np.exp(-decay * times) * (np.cos(ringing * times) + decay / ringing * np.sin(ringing * times))
    )
    assert motion.states[0] == pytest.approx(expected, abs=1e-9)


# Refusals


def refused(
    *words: str, lagrangian: object = m * q.diff() ** 2 / 2, coordinates: object = (q,), **more: object
) -> None:
    with pytest.raises(MechanismError) as caught:
        from_lagrangian(lagrangian, coordinates, name="system", **more)
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words), message


L = m * q.diff() ** 2 / 2


def test_an_inputs_second_derivative_is_refused_with_the_remedy() -> None:
    refused(
        "'u'",
        "second derivative",
        "'q'",
        "u_rate",
        "from the ground",
        lagrangian=m * (q + u).diff(t) ** 2 / 2,
        inputs=[u],
    )
    from_lagrangian(L - k * (q - u) ** 2 / 2 + m * u.diff() ** 2 / 2, [q], inputs=[u], name="from the ground")


def test_explicit_time_is_refused() -> None:
    refused("lagrangian", "time t", lagrangian=L - k * q * sympy.sin(3 * t))
    refused("force on 'q'", "time t", forces={q: sympy.sin(t)})
    clock = sympy.Symbol("clock")
    own = sympy.Function("q")(clock)
    refused("time clock", lagrangian=m * own.diff() ** 2 / 2 - clock * own, coordinates=[own])


def test_derivatives_too_high_are_refused() -> None:
    refused("lagrangian", "acceleration", "q_acceleration", lagrangian=L + m * q * q.diff().diff())
    refused("force on 'q'", "q_acceleration", forces={q: q.diff().diff()})
    refused("dissipation", "q_acceleration", dissipation=q.diff().diff() ** 2)
    refused("output 'jerk'", "derivative 3", "'q'", outputs={"jerk": q.diff(t, 3)})
    refused("output 'y'", "derivative 2", "'u'", outputs={"y": u.diff(t, 2)}, inputs=[u])


def test_unknown_functions_are_refused() -> None:
    refused("lagrangian", "theta(t)", "neither", "q", lagrangian=L + sympy.cos(theta))
    refused("output 'y'", "theta(t)", outputs={"y": theta.diff()})
    refused("f(q(t))", "function of time", lagrangian=L + sympy.Function("f")(q))


def test_coordinates_without_inertia_are_refused() -> None:
    refused("'theta'", "moves no mass", "theta_rate", lagrangian=L - k * theta**2, coordinates=(q, theta))
    refused("'q'", "moves no mass", lagrangian=q.diff() * theta.diff(), coordinates=(q, theta))
    refused("'q'", "moves no mass", lagrangian=k * q.diff())


def test_names_are_refused() -> None:
    refused("'q'", "is taken", coordinates=(q, q))
    refused("'q'", "is taken", inputs=[q])
    refused("'q'", "is taken", outputs={"q": q.diff()})
    refused("'q_rate'", "is taken", coordinates=(q, dynamicsymbols("q_rate")))
    refused("'_0'", "underscore", coordinates=(q, dynamicsymbols("_0")))
    refused("'_0'", "underscore", lagrangian=L * sympy.Symbol("_0"))
    refused("'q'", ".position", lagrangian=L - k * sympy.Symbol("q") ** 2)
    refused("'q_rate'", ".rate", dissipation=sympy.Symbol("q_rate") ** 2)


def test_what_is_no_expression_is_refused() -> None:
    refused("lagrangian", "Matrix", lagrangian=sympy.Matrix([L]))
    refused("lagrangian", "str", lagrangian="m*q**2")
    refused("lagrangian", "object", lagrangian=object())
    refused("dissipation", "real", dissipation=sympy.I * q.diff() ** 2)
    refused("force on 'q'", "finite", forces={q: sympy.nan})
    refused("'q'", "function of time", coordinates=("q",))
    refused("function of time", coordinates=(sympy.Symbol("q"),))
    refused("one coordinate or more", coordinates=(), lagrangian=0)


def test_unknown_keys_are_refused() -> None:
    refused("forces", "'theta'", "q", forces={theta: 1})
    refused("units", "theta(t)", units={theta: "rad"})


def test_a_system_made_by_hand_is_checked_too() -> None:
    own = Coordinate("q", "m")
    zero = sympy.S.Zero
    with pytest.raises(MechanismError, match="0 forces on 1 coordinates"):
        Lagrangian("system", m * own.rate**2, (own,), (), (), zero, ())
    with pytest.raises(MechanismError, match=r"lagrangian contains Derivative\(q\(t\), t\)"):
        Lagrangian("system", L, (own,), (), (), zero, (zero,))
    with pytest.raises(MechanismError, match=r"output 'y' contains q\(t\)"):
        Lagrangian("system", m * own.rate**2, (own,), (), (ExpressionOutput("y", "m", q),), zero, (zero,))

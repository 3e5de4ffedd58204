"""Rigid-body motions whose rates and frequencies stand in every textbook, from the compiled equations.

Each test names its source and states the formula; tolerances are those of rounding.
"""

from collections.abc import Sequence

import numpy as np
import pytest

from chassym.derivation import (
    AngularAcceleration,
    AngularVelocity,
    Body,
    CompiledEquations,
    Linear,
    LineOfSightPort,
    Mechanism,
    Output,
    PointAcceleration,
    PointPosition,
    PointVelocity,
    cylindrical,
    free,
    prismatic,
    revolute,
    spherical,
)

TOLERANCE = 1e-13
G = 9.81
ORIGIN = (0.0, 0.0, 0.0)

Array = np.ndarray
Numbers = Sequence[float] | Array


def accelerations(mechanism: Mechanism, position: Numbers, rate: Numbers) -> Array:
    """Second derivatives of the coordinates, length n."""
    arguments = np.concatenate([position, rate, np.zeros(len(position))])
    return CompiledEquations(mechanism).accelerations.bind({})(arguments[:, None])[:, 0]


def outputs(mechanism: Mechanism, position: Numbers, rate: Numbers, second: Numbers) -> Array:
    """All outputs in a state of motion, as vectors of three."""
    arguments = np.concatenate([position, rate, second])
    return CompiledEquations(mechanism).outputs.bind({})(arguments[:, None])[:, 0].reshape(-1, 3)


def eigenvalues(mechanism: Mechanism, position: Numbers, rate: Numbers) -> Array:
    """Eigenvalues of small deviations from a steady motion, in which no rate changes."""
    n = len(position)
    state = np.concatenate([position, rate, np.zeros(n)])
    jacobian = CompiledEquations(mechanism).residual_jacobian.bind({}).matrix(state, (n, 3 * n))
    stiffness, damping, mass = np.hsplit(jacobian, 3)
    lower = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    return np.linalg.eigvals(np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower]))


def frequencies(mechanism: Mechanism, position: Numbers | None = None, rate: Numbers | None = None) -> Array:
    """Frequencies of small oscillations about a steady motion, or about rest, ascending (rad/s)."""
    rest = np.zeros(len(mechanism.coordinates))
    found = eigenvalues(mechanism, rest if position is None else position, rest if rate is None else rate)
    return np.sort(found.imag[found.imag > 1e-6])


def add_measurements(mechanism: Mechanism, kinds: Sequence[type[Output]], of: object, *seen: Body) -> None:
    """Add every component of some measurements; `seen` are the axes and the observer, or the frame."""
    for kind in kinds:
        for axis in "xyz":
            mechanism.add_output(kind(f"{kind.__name__}_{axis}", of, axis, *seen))  # type: ignore[call-arg]


# Tops

TOP_MASS, TOP_ARM, ACROSS, ALONG = 0.7, 0.11, 0.0133, 0.0021
"""Mass, distance of the mass centre from the pivot, moments of inertia about the pivot."""


def top() -> Mechanism:
    mechanism = Mechanism("top", gravity=G)
    mechanism.add_body(
        "top",
        mechanism.ground,
        spherical("zxz"),
        ORIGIN,
        mass=TOP_MASS,
        mass_centre=(0, 0, TOP_ARM),
        inertia=(ACROSS, ACROSS, ALONG),
        inertia_about=ORIGIN,
    )
    return mechanism


def steady_precessions(nutation: float, spin: float) -> Array:
    """Roots of (I1 - I3) cos(theta) p^2 - I3 psi' p + m g l = 0, the slow precession first."""
    roots = np.roots([(ACROSS - ALONG) * np.cos(nutation), -ALONG * spin, TOP_MASS * G * TOP_ARM])
    return np.array(sorted(roots, key=abs))


@pytest.mark.parametrize("nutation", [0.4, 1.1, 2.3])
@pytest.mark.parametrize("which", ["slow", "fast"])
def test_steady_precession_of_a_heavy_top(nutation: float, which: str) -> None:
    """H. Goldstein, Classical Mechanics, 2nd ed., section 5-7: m g l = p (I3 w3 - I1 p cos(theta)).

    With w3 = psi' + p cos(theta) it is a quadratic for the precession p; nothing then accelerates.
    """
    spin = 280.0
    precession = steady_precessions(nutation, spin)[["slow", "fast"].index(which)]
    found = accelerations(top(), (0.3, nutation, -0.8), (precession, 0, spin))
    assert np.all(np.abs(found) < TOLERANCE * (precession**2 + abs(precession * spin)))


@pytest.mark.parametrize("nutation", [0.4, 1.1, 2.3])
@pytest.mark.parametrize("spin", [200.0, 1000.0])
def test_nutation_about_steady_precession(nutation: float, spin: float) -> None:
    """H. Lamb, Mechanics, Encyclopaedia Britannica, 11th ed. (1911), section 20, equations 8 and 9.

    Small oscillations about a precession p go with (I3 w3 / I1 - 2 p cos(theta))^2 + p^2 sin(theta)^2.
    """
    precession = steady_precessions(nutation, spin)[0]
    own = ALONG * (spin + precession * np.cos(nutation)) / ACROSS
    expected = np.hypot(own - 2 * precession * np.cos(nutation), precession * np.sin(nutation))
    found = frequencies(top(), (0.3, nutation, -0.8), (precession, 0, spin))
    np.testing.assert_allclose(found, [expected], rtol=10 * TOLERANCE)


def test_nutation_of_a_fast_top() -> None:
    """L. D. Landau and E. M. Lifshitz, Mechanics, 3rd ed., section 35, problem 3: the nutation is I3 w3 / I1.

    By the exact frequency, with p = m g l / (I3 w3), the next term is -2 p cos(theta).
    """
    nutation, errors = 0.9, []
    for spin in (2e3, 4e3, 8e3):
        precession = steady_precessions(nutation, spin)[0]
        momentum = ALONG * (spin + precession * np.cos(nutation))
        found = frequencies(top(), (0, nutation, 0), (precession, 0, spin))[0]
        slow = TOP_MASS * G * TOP_ARM / momentum
        errors.append((momentum / ACROSS - found) / (2 * slow * np.cos(nutation)) - 1)
    assert abs(errors[-1]) < 1e-3
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, rtol=0.02)


# Bodies free of torques

MOMENTS = {"x": 0.7, "y": 1.1, "z": 1.6}


def spinner(sequence: str, moments: Numbers) -> Mechanism:
    """Make a body held at its mass centre."""
    mechanism = Mechanism("spinner", gravity=0)
    mechanism.add_body("body", mechanism.ground, spherical(sequence), ORIGIN, mass=2, inertia=moments)
    return mechanism


def test_body_cone_of_a_symmetric_body() -> None:
    """Landau and Lifshitz, Mechanics, 3rd ed., section 36: w1' = -c w2, w2' = c w1, c = w3 (I3 - I1) / I1.

    In the body's axes the angular velocity goes round the axis of symmetry at the rate c.
    """
    across, along = 0.8, 1.3
    mechanism = Mechanism("thrown", gravity=G)
    body = mechanism.add_body(
        "body", mechanism.ground, free("yxz"), ORIGIN, mass=2, inertia=(across, across, along)
    )
    add_measurements(mechanism, (AngularVelocity, AngularAcceleration), body, body)
    generator = np.random.default_rng(5)
    for position, rate in generator.uniform(-1, 1, (10, 2, 6)):
        spin, change = outputs(mechanism, position, rate, accelerations(mechanism, position, rate))
        cone = spin[2] * (along - across) / across
        np.testing.assert_allclose(change, [-cone * spin[1], cone * spin[0], 0], atol=20 * TOLERANCE)


@pytest.mark.parametrize("sequence", ["xyz", "yzx", "zxy"])
def test_rotation_about_a_principal_axis(sequence: str) -> None:
    """Landau and Lifshitz, Mechanics, 3rd ed., section 37: only the intermediate axis is unstable.

    Deviations of Euler's equations from a rotation W about axis a grow or oscillate with
    s^2 = W^2 (I_a - I_b) (I_c - I_a) / (I_b I_c); the axis as a whole goes round with W in the body's eyes.
    """
    rate, (a, b, c) = 3.7, (MOMENTS[axis] for axis in sequence)
    found = eigenvalues(spinner(sequence, list(MOMENTS.values())), (0.4, 0, 0), (rate, 0, 0))
    expected = np.sqrt(complex(rate**2 * (a - b) * (c - a) / (b * c)))
    assert (expected.real > 0) == (sequence[0] == "y")
    for value in (expected, -expected, 1j * rate, -1j * rate):
        assert np.abs(found - value).min() < 10 * TOLERANCE * rate


# Pendulums


def test_compound_pendulum() -> None:
    """Landau and Lifshitz, Mechanics, 3rd ed., section 32, problem 3.

    w^2 = m g l / (m l^2 + I1 cos(alpha)^2 + I2 cos(beta)^2 + I3 cos(gamma)^2), with the angles between the
    principal axes and the horizontal axis of rotation at the distance l. At any amplitude phi'' is
    -w^2 sin(phi).
    """
    mass, arm, axis, moments = 1.7, 0.45, np.array([0.6, 0.8, 0]), np.array([0.2, 0.33, 0.41])
    axes = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    tensor = axes * moments @ axes.T
    mechanism = Mechanism("compound pendulum", gravity=G)
    mechanism.add_body(
        "body",
        mechanism.ground,
        revolute("swing", axis.tolist()),
        ORIGIN,
        mass=mass,
        mass_centre=(0.3 * axis - arm * np.array([0, 0, 1])).tolist(),
        inertia=((tensor + tensor.T) / 2).tolist(),
    )
    expected = mass * G * arm / (mass * arm**2 + moments @ (axis @ axes) ** 2)
    np.testing.assert_allclose(frequencies(mechanism), [np.sqrt(expected)], rtol=TOLERANCE)
    for angle in (0.4, 1.9):
        found = accelerations(mechanism, [angle], [2.0])
        np.testing.assert_allclose(found, [-expected * np.sin(angle)], rtol=TOLERANCE)


def double_pendulum(masses: Numbers, lengths: Numbers) -> Mechanism:
    mechanism = Mechanism("double pendulum", gravity=G)
    parent, hinge = mechanism.ground, 0.0
    for name, mass, length in zip(("upper", "lower"), masses, lengths, strict=True):
        bob = (0, 0, hinge - length)
        joint = revolute(f"{name}_angle", "y")
        parent = mechanism.add_body(name, parent, joint, (0, 0, hinge), mass=mass, mass_centre=bob)
        hinge -= length
    return mechanism


def test_double_pendulum() -> None:
    """T. W. B. Kibble and F. H. Berkshire, Classical Mechanics, 5th ed., chapter 11, equation 11.21.

    w^4 - (1 + m / M) (g / L + g / l) w^2 + (1 + m / M) g^2 / (L l) = 0 with m and l below M and L; for equal
    bobs and rods w^2 = (2 -+ sqrt(2)) g / l.
    """
    for masses, (first, second) in (((1.3, 1.3), (0.6, 0.6)), ((0.4, 1.9), (0.8, 0.3))):
        factor = 1 + masses[1] / masses[0]
        squares = np.roots([1, -factor * (G / first + G / second), factor * G**2 / (first * second)])
        found = frequencies(double_pendulum(masses, (first, second)))
        np.testing.assert_allclose(found, np.sort(np.sqrt(squares)), rtol=10 * TOLERANCE)
    equal = np.sqrt((2 + np.sqrt(2) * np.array([-1, 1])) * G / 0.6)
    found = frequencies(double_pendulum((1.3, 1.3), (0.6, 0.6)))
    np.testing.assert_allclose(found, equal, rtol=TOLERANCE)


def test_pendulum_on_a_rolling_cart() -> None:
    """Landau and Lifshitz, Mechanics, 3rd ed., section 5, problem 2: w^2 = (1 + m / M) g / l, cart M.

    The mass centre keeps its place, so that (M + m) x' = -m l phi' and the kinetic energy loses the factor
    M / (M + m).
    """
    cart_mass, mass, length = 2.3, 0.9, 0.7
    mechanism = Mechanism("cart", gravity=G)
    cart = mechanism.add_body("cart", mechanism.ground, prismatic("x", "x"), ORIGIN, mass=cart_mass)
    mechanism.add_body("bob", cart, revolute("swing", "y"), ORIGIN, mass=mass, mass_centre=(0, 0, -length))
    expected = np.sqrt((1 + mass / cart_mass) * G / length)
    np.testing.assert_allclose(frequencies(mechanism), [expected], rtol=TOLERANCE)


STRING_STIFFNESS, STRING_LENGTH, BOB = 55.0, 0.8, 0.35
"""Stiffness of the string, its length under the bob's weight, mass of the bob."""


def elastic_pendulum() -> Mechanism:
    """Make a bob that hangs below the origin on an elastic string, its place as coordinates."""
    mechanism = Mechanism("elastic pendulum", gravity=G)
    slides = prismatic("x", "x").then(prismatic("y", "y")).then(prismatic("z", "z"))
    rest = (0, 0, -STRING_LENGTH)
    bob = mechanism.add_body("bob", mechanism.ground, slides, rest, mass=BOB)
    ends = mechanism.point("hook", mechanism.ground, ORIGIN), mechanism.point("bob", bob, rest)
    law = Linear(stiffness=STRING_STIFFNESS, preload=BOB * G)
    mechanism.add_force_element("string", LineOfSightPort(*ends), law)
    return mechanism


def test_frequencies_of_an_elastic_pendulum() -> None:
    """P. Lynch, Resonant motions of the three-dimensional elastic pendulum, 2002: linear normal modes.

    Int. J. Non-Linear Mechanics 37, 345-367. sqrt(g / l) twice for the swinging, with the stretched length l,
    and sqrt(k / m) for the bouncing.
    """
    expected = np.sqrt([G / STRING_LENGTH, G / STRING_LENGTH, STRING_STIFFNESS / BOB])
    np.testing.assert_allclose(frequencies(elastic_pendulum()), expected, rtol=TOLERANCE)


def test_acceleration_of_an_elastic_pendulum() -> None:
    """The same source, equations of motion: r'' = -k (|r| - l0) r / (m |r|) - g, l0 = l - m g / k."""
    slack = STRING_LENGTH - BOB * G / STRING_STIFFNESS
    for position in np.random.default_rng(7).uniform(-0.5, 0.5, (5, 3)):
        place = position - [0, 0, STRING_LENGTH]
        length = np.linalg.norm(place)
        expected = -STRING_STIFFNESS * (length - slack) * place / (BOB * length) - [0, 0, G]
        found = accelerations(elastic_pendulum(), position, np.ones(3))
        np.testing.assert_allclose(found, expected, rtol=TOLERANCE, atol=TOLERANCE * G)


# Rotating observers


def test_free_particle_seen_by_a_rotating_observer() -> None:
    """Landau and Lifshitz, Mechanics, 3rd ed., section 39, equation 39.7, without forces.

    v' = v - W x r and a' = 2 v' x W + W x (r x W) + r x W', with the observer's rate W and its change W'.
    """
    mechanism, along = Mechanism("turntable", gravity=0), np.array([2.0, -1.0, 2.0]) / 3
    table = mechanism.add_body(
        "table", mechanism.ground, revolute("turn", along.tolist()), ORIGIN, inertia=(1, 1, 1)
    )
    slides = prismatic("x", "x").then(prismatic("y", "y")).then(prismatic("z", "z"))
    particle = mechanism.add_body("particle", mechanism.ground, slides, ORIGIN, mass=1)
    point = mechanism.point("particle", particle, ORIGIN)
    add_measurements(mechanism, (PointPosition,), point, table)
    add_measurements(mechanism, (PointVelocity, PointAcceleration), point, table, table)
    add_measurements(mechanism, (AngularVelocity, AngularAcceleration), table, table)
    generator = np.random.default_rng(3)
    for position, rate in generator.uniform(-2, 2, (5, 2, 4)):
        second = np.array([0.9, 0, 0, 0])
        r, v, a, spin, change = outputs(mechanism, position, rate, second)
        np.testing.assert_allclose([spin, change], [rate[0] * along, 0.9 * along], rtol=TOLERANCE)
        expected = 2 * np.cross(v, spin) + np.cross(spin, np.cross(r, spin)) + np.cross(r, change)
        np.testing.assert_allclose(a, expected, atol=50 * TOLERANCE)
        speed = np.linalg.norm(v + np.cross(spin, r))
        np.testing.assert_allclose(speed, np.linalg.norm(rate[1:]), rtol=10 * TOLERANCE)


def test_free_particle_in_polar_coordinates() -> None:
    """J. R. Taylor, Classical Mechanics, section 1.7, no forces: r'' = r phi'^2, r phi'' = -2 r' phi'."""
    mechanism = Mechanism("polar coordinates", gravity=0)
    joint = revolute("phi", "z").then(prismatic("r", "x"))
    mechanism.add_body("particle", mechanism.ground, joint, ORIGIN, mass=0.7)
    for phi, r, turning, parting in np.random.default_rng(8).uniform(0.2, 2, (5, 4)):
        found = accelerations(mechanism, (phi, r), (turning, parting))
        np.testing.assert_allclose(found, [-2 * parting * turning / r, r * turning**2], rtol=TOLERANCE)


def test_foucault_pendulum_at_the_pole() -> None:
    """Landau and Lifshitz, Mechanics, 3rd ed., section 39, problem 3: the plane of swing turns with -W.

    In the turning axes x + i y = exp(-i W t) (A exp(i w t) + B exp(-i w t)), w^2 = g / l: frequencies w -+ W.
    """
    turning, length = 0.8, 1.2
    mechanism = Mechanism("Foucault", gravity=G)
    earth = mechanism.add_body("earth", mechanism.ground, revolute("day", "z"), ORIGIN, inertia=(1, 1, 1))
    cardan = revolute("east", "x").then(revolute("north", "y"))
    mechanism.add_body("bob", earth, cardan, ORIGIN, mass=0.4, mass_centre=(0, 0, -length))
    swing = np.sqrt(G / length)
    found = frequencies(mechanism, (0.3, 0, 0), (turning, 0, 0))
    np.testing.assert_allclose(found, [swing - turning, swing + turning], rtol=10 * TOLERANCE)


def test_helix_of_a_cylindrical_joint() -> None:
    """M. P. do Carmo, Differential Geometry of Curves and Surfaces, section 1-5, exercise 1.

    A helix of radius a and pitch 2 pi b has the curvature a / (a^2 + b^2): at constant turning w the speed is
    w sqrt(a^2 + b^2) and |v x a| = curvature |v|^3.
    """
    axis, radius, pitch, turning = np.array([2.0, 3.0, 6.0]) / 7, 0.4, 0.15, 2.5
    outward = np.array([3.0, -2.0, 0.0]) / np.sqrt(13)
    mechanism = Mechanism("screw", gravity=0)
    screw = mechanism.add_body(
        "screw",
        mechanism.ground,
        cylindrical("slide", "turn", axis.tolist()),
        ORIGIN,
        mass=1,
        inertia=(1, 1, 1),
    )
    point = mechanism.point("edge", screw, (0.2 * axis + radius * outward).tolist())
    add_measurements(mechanism, (PointVelocity, PointAcceleration), point, mechanism.ground)
    for angle in (0.0, 0.7, 4.0):
        v, a = outputs(mechanism, (pitch * angle, angle), (pitch * turning, turning), (0, 0))
        squares = radius**2 + pitch**2
        np.testing.assert_allclose(np.linalg.norm(v), turning * np.sqrt(squares), rtol=TOLERANCE)
        curvature = np.linalg.norm(np.cross(v, a)) / np.linalg.norm(v) ** 3
        np.testing.assert_allclose(curvature, radius / squares, rtol=10 * TOLERANCE)
        np.testing.assert_allclose(v @ axis, pitch * turning, rtol=TOLERANCE)

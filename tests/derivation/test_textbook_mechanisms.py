"""M and Q - h of named mechanisms against sympy.physics.mechanics, which lays out frames and points itself.

Kane's method is quick enough for every run; Lagrange's, which differentiates T - V, for the small ones.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    Body,
    EquationsOfMotion,
    Joint,
    JointPort,
    Linear,
    LineOfSightPort,
    Mechanism,
    TravelPort,
    cylindrical,
    derive,
    free,
    planar,
    prismatic,
    revolute,
    spherical,
    weld,
)

from .textbook import Layout, Load, Textbook, by_kane, by_lagrange, lay_out, plain_symbols

STATES = 50
TOLERANCE = 1e-12

Array = np.ndarray
Place = tuple[float, float, float]
Tensor = Sequence[Sequence[float]]
Work = tuple[sympy.Expr, list[Load]]


@dataclass(frozen=True)
class Part:
    """One row of a table of bodies; the inertia is about the mass centre, or about the joint if `hinged`."""

    name: str
    parent: str
    joint: Joint
    origin: Place
    mass: float
    centre: Place
    inertia: Sequence[float] | Tensor
    hinged: bool = False


@dataclass(frozen=True)
class Case:
    """A mechanism as a table of its bodies, with what acts on it: `act` there, `work` in the textbook.

    `work` gives a potential energy and loads on points and frames.
    """

    parts: Sequence[Part]
    gravity: float = 9.81
    act: Callable[[Mechanism, Mapping[str, Body]], None] = lambda mechanism, bodies: None
    work: Callable[[Layout], Work] = lambda layout: (sympy.S.Zero, [])


def symbol(name: str) -> sympy.Symbol:
    return sympy.Symbol(name, real=True)


def symmetric(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> Tensor:
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


# What acts: springs, dampers and applied forces, once as ports and once as energies and loads

AXLES = {"front": (-1.2, 21e3, 1.3e3, 180e3, 90.0), "rear": (1.5, 24e3, 1.5e3, 190e3, 80.0)}
"""Station, spring and damper of the suspension, stiffness and damping of the tyre."""


def put_on_tyres(mechanism: Mechanism, bodies: Mapping[str, Body]) -> None:
    for axle, (x, spring, damper, tyre, tyre_damping) in AXLES.items():
        suspension = JointPort(mechanism.coordinate(f"{axle}_travel"))
        mechanism.add_force_element(f"{axle}_suspension", suspension, Linear(spring, damper))
        patch = mechanism.point(f"{axle}_patch", bodies[axle], (x, 0.0, 0.0))
        port = TravelPort(patch, mechanism.ground, "z").less(mechanism.add_input(f"{axle}_road", "m"))
        mechanism.add_force_element(f"{axle}_tyre", port, Linear(tyre, tyre_damping))


def work_of_tyres(layout: Layout) -> Work:
    up, potential, loads = layout.ground.z, sympy.S.Zero, []
    for axle, (x, spring, damper, tyre, tyre_damping) in AXLES.items():
        i = [q.func.__name__ for q in layout.coordinates].index(f"{axle}_travel")
        travel, rate = layout.coordinates[i], layout.rates[i]
        potential += spring * travel**2 / 2
        patch, beneath = layout.point(axle, (x, 0.0, 0.0)), layout.point("body", (x, 0.0, 0.3))
        # The body's particle at the axle's place moves as the axle would without its travel.
        sliding = rate * layout.frames["body"].z
        beneath.set_vel(layout.ground, layout.origins[axle].vel(layout.ground) - sliding)
        stretch = layout.place(patch).dot(up) - symbol(f"{axle}_road")
        potential += tyre * stretch**2 / 2
        speed = patch.vel(layout.ground).dot(up) - symbol(f"{axle}_road_rate")
        loads += [(patch, -tyre_damping * speed * up)]
        loads += [(layout.origins[axle], -damper * sliding), (beneath, damper * sliding)]
    return potential, loads


STRUT = ("carriage", (0.2, 0.1, 0.9)), ("pendulum", (1.0, -0.3, 0.2))
STRUT_LAW = {"stiffness": 130.0, "damping": 3.5, "preload": 11.0}


def put_on_strut(mechanism: Mechanism, bodies: Mapping[str, Body]) -> None:
    ends = [mechanism.point(name, bodies[name], place) for name, place in STRUT]
    mechanism.add_force_element("strut", LineOfSightPort(*ends), Linear(**STRUT_LAW))


def work_of_strut(layout: Layout) -> Work:
    """Potential of the spring from the distance; the damper pulls both ends together."""
    first, second = (layout.point(*end) for end in STRUT)
    line = layout.place(second) - layout.place(first)
    distance, direction = line.magnitude(), line.normalize()
    stretch = distance - np.linalg.norm(np.subtract(STRUT[1][1], STRUT[0][1]))
    closing = STRUT_LAW["damping"] * (second.vel(layout.ground) - first.vel(layout.ground)).dot(direction)
    potential = STRUT_LAW["stiffness"] * stretch**2 / 2 + STRUT_LAW["preload"] * stretch
    return potential, [(first, closing * direction), (second, -closing * direction)]


GUST = (0.3, -0.1, -0.8)


def blow(mechanism: Mechanism, bodies: Mapping[str, Body]) -> None:
    point = mechanism.point("gust", bodies["bob"], GUST)
    mechanism.add_applied_force("push", point, (1, 2, 2), bodies["cart"])
    mechanism.add_applied_torque("motor", bodies["bob"], (0, 3, 4), bodies["cart"])


def work_of_gust(layout: Layout) -> Work:
    cart, bob = layout.frames["cart"], layout.frames["bob"]
    force = symbol("push") * (cart.x + 2 * cart.y + 2 * cart.z) / 3
    torque = symbol("motor") * (3 * cart.y + 4 * cart.z) / 5
    return sympy.S.Zero, [(layout.point("bob", GUST), force), (bob, torque)]


# The mechanisms

ORIGIN = (0.0, 0.0, 0.0)
SCREW = cylindrical("slide", "turn", (1, -2, 2))
UNIVERSAL = revolute("pitch", "y").then(revolute("roll", "x"))
WHEELS = (1.0, 2.0, 1.5)
FULL = symmetric(0.31, 0.42, 0.37, 0.03, -0.05, 0.02)
HINGED = symmetric(1.9, 1.7, 0.9, -0.11, 0.23, 0.17)
CASES = {
    "symmetric top": Case(
        [Part("top", "ground", spherical("zxz"), ORIGIN, 0.6, (0, 0, 0.2), (0.004, 0.004, 0.0012))]
    ),
    "asymmetric top": Case([Part("top", "ground", spherical("xyz"), ORIGIN, 1.3, (0.1, -0.2, 0.4), FULL)]),
    "double pendulum in space": Case(
        [
            Part("upper", "ground", spherical("zyx", "upper_"), ORIGIN, 1.3, (0.1, 0.2, -0.6), HINGED, True),
            Part(
                "lower",
                "upper",
                spherical("xzy", "lower_"),
                (0.2, 0, -1),
                0.9,
                (0.3, -0.2, -1.4),
                HINGED,
                True,
            ),
        ]
    ),
    "chain of five links": Case(
        [
            Part(
                f"link{i}",
                f"link{i - 1}" if i else "ground",
                revolute(f"angle{i}", "y"),
                (0.5 * i, 0, 0),
                1.0 + 0.2 * i,
                (0.5 * i + 0.2, 0.1, 0.05 * i),
                (0.1, 0.2 + 0.03 * i, 0.25),
            )
            for i in range(5)
        ]
    ),
    "half car in pitch": Case(
        [
            Part(
                "body",
                "ground",
                prismatic("bounce", "z").then(revolute("pitch", "y")),
                (0.1, 0, 0.5),
                1400.0,
                (0.2, 0, 0.55),
                (400, 1900, 2000),
            ),
            *(
                Part(
                    axle, "body", prismatic(f"{axle}_travel", "z"), (x, 0, 0.3), 70.0, (x, 0, 0.3), (0, 2, 0)
                )
                for axle, (x, *_) in AXLES.items()
            ),
        ],
        act=put_on_tyres,
        work=work_of_tyres,
    ),
    "screw on an oblique axis": Case(
        [
            Part(
                "nut",
                "ground",
                cylindrical("slide", "turn", (1, -2, 2)),
                (0.1, 0.2, 0.3),
                1.1,
                (0.4, 0, 0),
                FULL,
            ),
            Part("arm", "nut", revolute("swing", "y"), (0.5, 0.1, 0.2), 0.7, (0.8, 0.3, -0.1), FULL),
        ]
    ),
    "arm on a sliding plate": Case(
        [
            Part("plate", "ground", planar(), (0.1, 0.2, 0), 2.1, (0.3, 0.1, 0.2), FULL),
            Part("arm", "plate", revolute("swing", "x"), (0.4, 0.1, 0.1), 0.7, (0.8, 0.3, -0.3), FULL),
        ]
    ),
    "free body with an oblique rotor": Case(
        [
            Part("body", "ground", free("yxz"), (0.3, 0.1, 0.2), 2.1, (0.35, 0, 0.3), FULL),
            Part("rotor", "body", revolute("spin", (1, 2, -2)), (0.5, 0.2, 0.1), 0.8, (0.6, 0.1, 0.2), FULL),
        ]
    ),
    "cart with a pendulum in space": Case(
        [
            Part("cart", "ground", prismatic("x", "x"), (0, 0, 0.2), 1.9, (0, 0, 0.2), ORIGIN),
            Part("bob", "cart", spherical(), (0.1, 0, 0.1), 0.7, (0.2, 0.1, -0.9), FULL),
        ],
        act=blow,
        work=work_of_gust,
    ),
    "gyroscope in two gimbals": Case(
        [
            Part("outer", "ground", revolute("heading", "z"), ORIGIN, 0.2, ORIGIN, (0.02, 0.03, 0.04)),
            Part("inner", "outer", revolute("tilt", "y"), ORIGIN, 0.15, (0, 0.01, 0), (0.01, 0.02, 0.015)),
            Part("rotor", "inner", revolute("spin", "x"), ORIGIN, 0.5, (0.02, 0, 0), (0.05, 0.03, 0.03)),
        ]
    ),
    "strut between two bodies": Case(
        [
            Part(
                "carriage", "ground", prismatic("slide", (0, 1, 1)), (0, 0, 0.8), 1.4, (0, 0, 0.8), (0, 0, 0)
            ),
            Part(
                "pendulum",
                "ground",
                revolute("pitch", "y").then(revolute("roll", "x")),
                (1, 0, 1),
                0.9,
                (1, 0, 0.4),
                FULL,
            ),
        ],
        act=put_on_strut,
        work=work_of_strut,
    ),
    "welded counterweight": Case(
        [
            Part("beam", "ground", revolute("tilt", (0, 3, 4)), ORIGIN, 1.2, (0.3, 0, 0), FULL),
            Part("weight", "beam", weld(), (-0.6, 0.1, 0), 2.5, (-0.7, 0.1, -0.1), HINGED, True),
        ]
    ),
}
QUICK_BY_LAGRANGE = ("symmetric top", "strut between two bodies")


def build(case: Case) -> Mechanism:
    mechanism = Mechanism("mechanism", gravity=case.gravity)
    bodies = {"ground": mechanism.ground}
    for part in case.parts:
        bodies[part.name] = mechanism.add_body(
            part.name,
            bodies[part.parent],
            part.joint,
            part.origin,
            mass=part.mass,
            mass_centre=part.centre,
            inertia=part.inertia,
            inertia_about=part.origin if part.hinged else None,
        )
    case.act(mechanism, bodies)
    return mechanism


@dataclass(frozen=True)
class Pair:
    """The package's equations of a case, and the case as the textbook lays it out."""

    case: Case
    equations: EquationsOfMotion
    layout: Layout


def pair(case: Case, *, own_rates: bool) -> Pair:
    """Lay a case out; an inertia about a joint goes there as given, not as the package shifts it."""
    mechanism = build(case)
    inertias = {part.name: (part.inertia, part.origin) for part in case.parts if part.hinged}
    return Pair(case, derive(mechanism), lay_out(mechanism, own_rates=own_rates, inertias=inertias))


def relative_difference(found: Array, expected: Array) -> float:
    """Largest difference in any state over the largest entry of that state; shapes (entries, states)."""
    return float(np.max(np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)))


def evaluated(function: Callable[..., list], states: Array) -> Array:
    return np.array([np.broadcast_to(np.asarray(row, dtype=float), STATES) for row in function(*states)])


def random_states(equations: EquationsOfMotion) -> Array:
    """Draw all arguments from (-1, 1), shape (arguments, states)."""
    generator = np.random.default_rng(len(equations.arguments))
    return generator.uniform(-1, 1, (len(equations.arguments), STATES))


def compare(equations: EquationsOfMotion, expected: Textbook, lambdified: Callable) -> None:
    """Compare M and Q - h at random states."""
    entries = [entry for row in equations.mass_matrix for entry in row]
    net = [q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)]
    states = random_states(equations)
    for own, other in ((entries, expected.mass_matrix), (net, expected.forcing)):
        found = evaluated(lambdified(equations.program, equations.arguments, own), states)
        truth = sympy.lambdify(equations.arguments, list(other), modules="numpy", cse=True)
        assert relative_difference(found, evaluated(truth, states)) < TOLERANCE


@pytest.fixture(scope="module", params=CASES)
def with_own_rates(request: pytest.FixtureRequest) -> Pair:
    """Give every case, laid out as Kane's method wants it."""
    return pair(CASES[request.param], own_rates=True)


def test_against_kane(with_own_rates: Pair, lambdified: Callable) -> None:
    layout = with_own_rates.layout
    compare(with_own_rates.equations, by_kane(layout, *with_own_rates.case.work(layout)), lambdified)


@pytest.mark.parametrize(
    "name", [n if n in QUICK_BY_LAGRANGE else pytest.param(n, marks=pytest.mark.slow) for n in CASES]
)
def test_against_lagrange(name: str, lambdified: Callable) -> None:
    laid_out = pair(CASES[name], own_rates=False)
    expected = by_lagrange(laid_out.layout, *laid_out.case.work(laid_out.layout))
    compare(laid_out.equations, expected, lambdified)


def test_energies(with_own_rates: Pair, lambdified: Callable) -> None:
    """T, and V up to a constant, are those of the bodies, weights and springs that the textbook lays out."""
    layout, equations = with_own_rates.layout, with_own_rates.equations
    potential = layout.weight_energy + with_own_rates.case.work(layout)[0]
    written = [e.xreplace(plain_symbols(layout)) for e in (layout.kinetic_energy, potential)]
    own = [equations.energies.kinetic, equations.energies.potential]
    states = random_states(equations)
    found = evaluated(lambdified(equations.program, equations.arguments, own), states)
    truth = evaluated(sympy.lambdify(equations.arguments, written, modules="numpy", cse=True), states)
    assert relative_difference(found[:1], truth[:1]) < TOLERANCE
    scale = max(1, np.abs(truth[1]).max())
    np.testing.assert_allclose(np.ptp(found[1] - truth[1]) / scale, 0, atol=TOLERANCE)


@pytest.mark.parametrize(
    ("joint", "steps"),
    [
        (weld(), []),
        (revolute("a", (0, 0, -2)), ["turn a 0 0 -1"]),
        (prismatic("a", (3, 0, -4)), ["slide a 0.6 0 -0.8"]),
        (
            cylindrical("s", "t", (2, -1, 2)),
            ["slide s 0.6667 -0.3333 0.6667", "turn t 0.6667 -0.3333 0.6667"],
        ),
        (planar(), ["slide x 1 0 0", "slide y 0 1 0", "turn yaw 0 0 1"]),
        (planar(("u", "v", "w"), ("z", "x")), ["slide u 0 0 1", "slide v 1 0 0", "turn w 0 1 0"]),
        (spherical(), ["turn yaw 0 0 1", "turn pitch 0 1 0", "turn roll 1 0 0"]),
        (spherical("xzy", "p_"), ["turn p_roll 1 0 0", "turn p_yaw 0 0 1", "turn p_pitch 0 1 0"]),
        (spherical("zxz"), ["turn precession 0 0 1", "turn nutation 1 0 0", "turn spin 0 0 1"]),
        (
            free("yxz", "b_"),
            ["slide b_x 1 0 0", "slide b_y 0 1 0", "slide b_z 0 0 1"]
            + ["turn b_pitch 0 1 0", "turn b_roll 1 0 0", "turn b_yaw 0 0 1"],
        ),
    ],
)
def test_steps_of_joints(joint: Joint, steps: list[str]) -> None:
    """The textbook takes a joint's steps as they are; here they are written out."""
    kinds = {True: "turn", False: "slide"}
    written = [
        f"{kinds[s.is_rotation]} {s.coordinate.name} {' '.join(f'{float(c):.4g}' for c in s.axis)}"
        for s in joint.steps
    ]
    assert written == steps


def test_a_planar_joint_turns_about_the_unit_normal_of_its_axes() -> None:
    """Also where the two axes are oblique to each other."""
    first, second, turn = (np.array(s.axis, dtype=float) for s in planar(axes=((1, 0, 0), (1, 1, 1))).steps)
    np.testing.assert_allclose(turn, np.array([0, -1, 1]) / np.sqrt(2), atol=1e-15)
    np.testing.assert_allclose(second, np.ones(3) / np.sqrt(3), atol=1e-15)
    np.testing.assert_array_equal(first, [1, 0, 0])

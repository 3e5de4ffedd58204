"""M and Q - h against sympy.physics.mechanics, from energies and forces written down a second time.

Source of the comparison: `sympy.physics.mechanics.LagrangesMethod`, which differentiates L = T - V. Springs,
preloads and weights enter by their energy; dampers, tyres and moving pads as forces on points.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
import sympy
from sympy.physics import mechanics
from sympy.physics.mechanics import LagrangesMethod, ReferenceFrame, dynamicsymbols

from chassym.derivation import (
    CombinedPort,
    CompiledEquations,
    EquationsOfMotion,
    Joint,
    JointPort,
    Linear,
    Mechanism,
    Model,
    TravelPort,
    derive,
    prismatic,
    revolute,
)

STATES = 50
TOLERANCE = 1e-12

Vector = mechanics.Vector


@dataclass(frozen=True)
class Textbook:
    """Lagrange's equations by sympy.physics.mechanics, in plain symbols named as in the package."""

    mass_matrix: sympy.Matrix
    forcing: sympy.Matrix


def named(name: str) -> sympy.Symbol:
    return sympy.Symbol(name, real=True)


def textbook(
    lagrangian: sympy.Expr,
    coordinates: Sequence[sympy.Expr],
    ground: ReferenceFrame,
    loads: Sequence[tuple] = (),
    inputs: Sequence[sympy.Expr] = (),
) -> Textbook:
    """Form the equations and replace functions of time by symbols."""
    method = LagrangesMethod(lagrangian, coordinates, forcelist=list(loads), frame=ground)
    method.form_lagranges_equations()
    moving = [*coordinates, *inputs]
    rates = {f.diff(): named(f"{f.func.__name__}_rate") for f in moving}
    plain = rates | {f: named(f.func.__name__) for f in moving}
    return Textbook(method.mass_matrix.xreplace(plain), method.forcing.xreplace(plain))


def point_at(name: str, place: Vector, ground: ReferenceFrame) -> mechanics.Point:
    """Make a point from its position; its velocity is the position's derivative in the ground frame."""
    point = mechanics.Point(name)
    point.set_vel(ground, place.dt(ground))
    return point


def random_values(symbols: Sequence[sympy.Symbol], given: dict[str, float], seed: int) -> dict:
    """Give numbers to symbols: parameters as given, the rest uniform in (-1, 1), one value for each state."""
    generator = np.random.default_rng(seed)
    values = {}
    for symbol in sorted(symbols, key=lambda s: s.name):
        constant = given.get(symbol.name)
        values[symbol] = (
            generator.uniform(-1, 1, STATES) if constant is None else np.full(STATES, float(constant))
        )
    return values


def numbers(function: Callable[..., list], values: dict) -> np.ndarray:
    """Evaluate to an array of shape (entries, states)."""
    rows = function(*values.values())
    return np.array([np.broadcast_to(np.asarray(row, dtype=float), STATES) for row in rows])


def relative_difference(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference in any state over the largest entry of that state."""
    return float(np.max(np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)))


def compare(
    equations: EquationsOfMotion,
    expected: Textbook,
    lambdified: Callable[..., Callable[..., list]],
    given: dict[str, float],
    extra: Callable[[dict], dict] = lambda values: {},
) -> None:
    """Compare M and Q - h at random states; `extra` gives forces that the textbook keeps as symbols."""
    upper = [entry for row in equations.mass_matrix for entry in row]
    net = [q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)]
    program = equations.program
    free = set().union(*(e.free_symbols for e in program.required([*upper, *net]).values()))
    symbols = (free | {s for e in (*upper, *net) for s in e.free_symbols}) - set(program.definitions)
    arguments = set(equations.arguments)
    values = random_values([*(symbols | arguments)], given, seed=len(upper))
    known = {s.name: v for s, v in values.items()} | extra({s.name: v for s, v in values.items()})
    for own, other in ((upper, list(expected.mass_matrix)), (net, list(expected.forcing))):
        found = numbers(lambdified(program, list(values), own), values)
        wanted = sorted({s for e in other for s in e.free_symbols}, key=lambda s: s.name)
        truth = numbers(
            sympy.lambdify(wanted, other, modules="numpy", cse=True), {s: known[s.name] for s in wanted}
        )
        assert relative_difference(found, truth) < TOLERANCE


# Quarter car


def quarter_car_by_textbook() -> Textbook:
    ground = ReferenceFrame("ground")
    body, wheel, road = dynamicsymbols("body_bounce wheel_bounce road")
    sprung, unsprung, g, k = (named(n) for n in ("sprung.mass", "unsprung.mass", "gravity", "spring.rate"))
    tyre_k, tyre_c = named("tyre.stiffness"), named("tyre.damping")
    spring_preload, tyre_preload = named("spring.preload"), named("tyre.preload")
    travel = wheel - body
    kinetic = (sprung * body.diff() ** 2 + unsprung * wheel.diff() ** 2) / 2
    potential = g * (sprung * body + unsprung * wheel) + spring_preload * travel + k * travel**2 / 2
    tyre = tyre_k * (wheel - road) + tyre_c * (wheel - road).diff() + tyre_preload
    damper = named("damper")
    loads = [
        (point_at("B", body * ground.z, ground), damper * ground.z),
        (point_at("W", wheel * ground.z, ground), -(damper + tyre) * ground.z),
    ]
    return textbook(kinetic - potential, [body, wheel], ground, loads, [road])


def test_quarter_car(quarter_car: Model, lambdified: Callable, table_force: Callable) -> None:
    parameters = quarter_car.parameters
    table = [np.array(parameters.value(name)) for name in ("damper.velocity", "damper.force")]

    def damper(values: dict) -> dict:
        return {"damper": table_force(values["wheel_bounce_rate"] - values["body_bounce_rate"], *table)}

    compare(quarter_car.equations, quarter_car_by_textbook(), lambdified, quarter_car.values, damper)


# Torsion chain


def torsion_chain_by_textbook() -> Textbook:
    ground = ReferenceFrame("ground")
    roll, front, rear = dynamicsymbols("roll front_torsion rear_torsion")
    angle = {"front": front, "middle": sympy.S.Zero, "rear": rear}
    kinetic = sum(named(f"inertia.{s}") * (roll + a).diff() ** 2 / 2 for s, a in angle.items())
    ends = [("front", front), ("rear", rear)]
    potential = sum(named(f"stiffness.{s}") * a**2 / 2 for s, a in ends)
    frames = {s: ground.orientnew(s, "Axis", [roll + a, ground.x]) for s, a in angle.items()}
    loads = []
    for s, a in ends:
        torque = named(f"damping.{s}") * a.diff() * ground.x
        loads += [(frames[s], -torque), (frames["middle"], torque)]
    return textbook(kinetic - potential, [roll, front, rear], ground, loads)


def test_torsion_chain(torsion_chain: Model, lambdified: Callable) -> None:
    compare(torsion_chain.equations, torsion_chain_by_textbook(), lambdified, torsion_chain.values)


def test_torsion_chain_in_symbols(torsion_chain: Model) -> None:
    """The expanded equations, as they would be printed, are the textbook's."""
    equations, expected = torsion_chain.equations, torsion_chain_by_textbook()
    written = equations.program.expand([e for row in equations.mass_matrix for e in row])
    assert (sympy.Matrix(3, 3, written) - expected.mass_matrix).expand().is_zero_matrix
    net = [q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)]
    forcing = sympy.Matrix(equations.program.expand(net))
    assert (forcing - expected.forcing).expand().is_zero_matrix


# Half car


def half_car_by_textbook() -> Textbook:
    ground = ReferenceFrame("ground")
    bounce, pitch = dynamicsymbols("bounce pitch")
    frame = ground.orientnew("B", "Axis", [pitch, ground.y])
    x, z, g = named("body.mass_centre.x"), named("body.mass_centre.z"), named("gravity")
    mass, inertia = named("body.mass"), named("body.inertia.yy")
    centre = x * ground.x + (z + bounce) * ground.z
    lagrangian = mass * bounce.diff() ** 2 / 2 + inertia * pitch.diff() ** 2 / 2 - mass * g * bounce
    coordinates, inputs, loads = [bounce, pitch], [], []
    for axle in ("front", "rear"):
        travel, road = dynamicsymbols(f"{axle}_travel {axle}_road")
        wheel_mass, k = named(f"axle.{axle}.mass"), named(f"suspension.{axle}.spring.rate")
        on_body = centre + (named(f"axle.{axle}.x") - x) * frame.x + (travel - z) * frame.z
        height = on_body.dot(ground.z)
        velocity = on_body.dt(ground)
        lagrangian += wheel_mass * velocity.dot(velocity) / 2 - wheel_mass * g * height
        lagrangian -= named(f"{axle}_suspension.preload") * travel + k * travel**2 / 2
        damper = named(f"suspension.{axle}.damper.coefficient") * travel.diff() * frame.z
        stretch = height - road
        tyre = named(f"tyre.{axle}.stiffness") * stretch + named(f"tyre.{axle}.damping") * stretch.diff(
            dynamicsymbols._t
        )
        tyre += named(f"{axle}_tyre.preload")
        wheel = point_at(f"{axle}_wheel", on_body, ground)
        # The body's particle at the wheel's place moves as the wheel would without sliding.
        beneath = mechanics.Point(f"{axle}_body")
        beneath.set_vel(ground, velocity - travel.diff() * frame.z)
        loads += [(wheel, -damper - tyre * ground.z), (beneath, damper)]
        coordinates.append(travel)
        inputs.append(road)
    return textbook(lagrangian, coordinates, ground, loads, inputs)


def test_half_car(half_car: Model, lambdified: Callable) -> None:
    compare(half_car.equations, half_car_by_textbook(), lambdified, half_car.values)


# Spatial chains of two links with offsets in all three directions


@dataclass(frozen=True)
class Segment:
    """One link of a chain: the steps of its joint, and its mass properties at the design position."""

    steps: str
    origin: tuple[float, float, float]
    centre: tuple[float, float, float]
    mass: float
    inertia: tuple[float, float, float]

    @property
    def step_list(self) -> list[tuple[str, str]]:
        """Kind, 'turn' or 'slide', and axis of each step: "z" turns about z, "Z" slides along it."""
        return [("slide" if letter.isupper() else "turn", letter.lower()) for letter in self.steps]


@dataclass(frozen=True)
class Chain:
    """Segments in order, each jointed to the one before, under gravity."""

    segments: tuple[Segment, ...]
    gravity: float


UPPER = ((0.1, -0.2, 0.3), (0.25, 0.15, -0.35), 1.7, (0.05, 0.07, 0.04))
LOWER = ((0.4, -0.3, -0.5), (0.9, 0.2, -0.7), 0.9, (0.02, 0.03, 0.025))
TIP = (1.1, -0.4, -0.2)
LONGEST = "yaw, pitch and roll, then pitch"
CHAINS = {
    LONGEST: Chain((Segment("zyx", *UPPER), Segment("y", *LOWER)), 9.81),
    "no axis along gravity": Chain((Segment("xy", *UPPER), Segment("x", *LOWER)), 9.81),
    "without gravity": Chain((Segment("y", *UPPER), Segment("xz", *LOWER)), 0.0),
    "slides between turns": Chain((Segment("Xy", *UPPER), Segment("Zx", *LOWER)), 9.81),
}
SPRINGS = {"inner": (310.0, 4.0), "outer": (170.0, 2.5), "torsion": (21.0, 0.6), "both": (90.0, 1.5)}


def coordinate_names(chain: Chain) -> list[list[str]]:
    return [
        [f"{kind}_{axis}{number}" for kind, axis in segment.step_list]
        for number, segment in enumerate(chain.segments)
    ]


def chain_mechanism(chain: Chain) -> Mechanism:
    """Make the chain with springs and dampers at every kind of port, one of them on a moving base."""
    mechanism = Mechanism("chain", sympy.sympify(chain.gravity))
    parent = mechanism.ground
    for number, (segment, names) in enumerate(zip(chain.segments, coordinate_names(chain), strict=True)):
        joint = Joint(())
        for name, (kind, axis) in zip(names, segment.step_list, strict=True):
            joint = joint.then(revolute(name, axis) if kind == "turn" else prismatic(name, axis))
        parent = mechanism.add_body(
            f"link{number}",
            parent,
            joint,
            segment.origin,
            mass=segment.mass,
            mass_centre=segment.centre,
            inertia=segment.inertia,
        )
    first, last = mechanism.bodies
    tip = mechanism.point("tip", last, TIP)
    seen = TravelPort(tip, first, "y")
    shaken = TravelPort(tip, mechanism.ground, "x").less(mechanism.add_input("base", "m"))
    both = CombinedPort(((TravelPort(tip, first, "z"), 2), (TravelPort(tip, mechanism.ground, "y"), -1)))
    ports = {
        "inner": seen,
        "outer": shaken,
        "torsion": JointPort(last.joint.steps[-1].coordinate),
        "both": both,
    }
    for name, port in ports.items():
        mechanism.add_force_element(name, port, Linear(*map(sympy.sympify, SPRINGS[name])))
    return mechanism


def chain_by_textbook(chain: Chain) -> Textbook:
    """Write the same chain with sympy's frames and rigid bodies; the work at ports by hand."""
    ground = ReferenceFrame("ground")
    frame, place, velocity, last_origin = ground, 0 * ground.x, 0 * ground.x, np.zeros(3)
    base = dynamicsymbols("base")
    lagrangian, coordinates, frames, origins = sympy.S.Zero, [], [], []
    for segment, names in zip(chain.segments, coordinate_names(chain), strict=True):
        offset = along(frame, np.subtract(segment.origin, last_origin))
        place, last_origin = place + offset, segment.origin
        velocity = velocity + frame.ang_vel_in(ground).cross(offset)
        for name, (kind, axis) in zip(names, segment.step_list, strict=True):
            q = dynamicsymbols(name)
            coordinates.append(q)
            if kind == "slide":
                slide = q * getattr(frame, axis)
                place = place + slide
                velocity = velocity + slide.dt(frame) + frame.ang_vel_in(ground).cross(slide)
            else:
                frame = frame.orientnew(f"frame_{name}", "Axis", [q, getattr(frame, axis)])
        velocity, spin = velocity.express(frame), frame.ang_vel_in(ground).express(frame)
        arm = along(frame, np.subtract(segment.centre, segment.origin))
        speed, moments = velocity + spin.cross(arm), mechanics.inertia(frame, *segment.inertia)
        lagrangian += (segment.mass * speed.dot(speed) + spin.dot(moments.dot(spin))) / 2
        lagrangian -= segment.mass * chain.gravity * (place + arm).dot(ground.z)
        frames.append(frame)
        origins.append(place)
    tip = place + along(frame, np.subtract(TIP, chain.segments[-1].origin))
    inside = tip - origins[0]
    design = np.subtract(TIP, chain.segments[0].origin)
    deflections = {
        "inner": inside.dot(frames[0].y) - design[1],
        "outer": tip.dot(ground.x) - TIP[0] - base,
        "torsion": coordinates[-1],
        "both": 2 * (inside.dot(frames[0].z) - design[2]) - (tip.dot(ground.y) - TIP[1]),
    }
    result = textbook(lagrangian, coordinates, ground)
    return Textbook(result.mass_matrix, result.forcing - work_gradient(deflections, coordinates, base))


def work_gradient(
    deflections: dict[str, sympy.Expr], coordinates: Sequence[sympy.Expr], base: sympy.Expr
) -> sympy.Matrix:
    """Give the derivative by the coordinates of the work done against springs and dampers."""
    plain = {f: named(f.func.__name__) for f in (*coordinates, base)}
    total = sympy.zeros(len(coordinates), 1)
    for name, (stiffness, damping) in SPRINGS.items():
        s = deflections[name].xreplace(plain)
        rate = sum(s.diff(q) * named(f"{q.name}_rate") for q in plain.values())
        total += (stiffness * s + damping * rate) * sympy.Matrix([s.diff(plain[q]) for q in coordinates])
    return total


def along(frame: ReferenceFrame, components: Sequence[float]) -> Vector:
    return sum((float(c) * axis for c, axis in zip(components, frame, strict=True)), 0 * frame.x)


@pytest.mark.parametrize(
    "name", [pytest.param(LONGEST, marks=pytest.mark.slow), *(n for n in CHAINS if n != LONGEST)]
)
def test_spatial_chain(name: str, lambdified: Callable) -> None:
    chain = CHAINS[name]
    compare(derive(chain_mechanism(chain)), chain_by_textbook(chain), lambdified, {})


@pytest.mark.parametrize("name", [LONGEST, "slides between turns"])
def test_compiled_accelerations_of_a_chain(name: str, lambdified: Callable) -> None:
    """Machine code solves M q'' = Q - h as numpy does."""
    compiled = CompiledEquations(chain_mechanism(CHAINS[name]))
    equations = compiled.equations
    arguments = np.random.default_rng(3).uniform(-1, 1, (len(equations.arguments), STATES))
    values = dict(zip(equations.arguments, arguments, strict=True))
    upper = [entry for row in equations.mass_matrix for entry in row]
    net = [q - h for q, h in zip(equations.generalized_forces, equations.bias, strict=True)]
    n = len(net)
    mass = numbers(lambdified(equations.program, list(values), upper), values).T.reshape(STATES, n, n)
    forcing = numbers(lambdified(equations.program, list(values), net), values).T[:, :, None]
    found = compiled.accelerations.bind({})(arguments)
    assert relative_difference(found, np.linalg.solve(mass, forcing)[:, :, 0].T) < TOLERANCE
    assert np.all(np.linalg.eigvalsh(mass) > 0)

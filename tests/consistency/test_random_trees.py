"""Random trees of rigid bodies with every kind of joint against MuJoCo, from the same numbers.

A joint of several steps is as many MuJoCo joints of one body, one after the other. Masses, moments of inertia
and lengths are of order one and angles within a radian, so that rotation sequences stay regular.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import permutations

import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from chassym.derivation import (
    AngularAcceleration,
    AngularVelocity,
    Body,
    Joint,
    Mechanism,
    PointAcceleration,
    PointPosition,
    PointVelocity,
    cylindrical,
    derive,
    free,
    planar,
    prismatic,
    revolute,
    spherical,
    weld,
)

STATES = 3
MATRIX_TOLERANCE = 1e-12
MOTION_TOLERANCE = 1e-12
WELL_CONDITIONED = 1e3
GROUND = -1
SEQUENCES = ["".join(letters) for letters in permutations("xyz")]
ANGLES = {"x": "roll", "y": "pitch", "z": "yaw"}
UNIT = dict(zip("xyz", np.eye(3), strict=True))

Array = np.ndarray
Step = tuple[str, str, Array]  # kind of MuJoCo's joint, name of the coordinate, axis
Kind = tuple[Joint, list[Step]]
# Random numbers do not shrink to simpler ones, so a failure is reported as it was found.
RANDOM = settings(
    derandomize=True,
    deadline=None,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@dataclass(frozen=True)
class Link:
    """One body, by design positions, with a point on it; its joint in the package's words and MuJoCo's."""

    parent: int
    joint: Joint
    steps: list[Step]
    origin: Array
    mass: float
    centre: Array
    inertia: Array
    probe: Array

    def inertia_about(self, place: Array) -> Array:
        """Give the inertia about a place by the parallel-axis theorem; `inertia` is about the mass centre."""
        r = place - self.centre
        return self.inertia + self.mass * (r @ r * np.eye(3) - np.outer(r, r))


@dataclass(frozen=True)
class Push:
    """A force on the point of a body, or a torque on the body, along an axis fixed in another one."""

    body: int
    axis: Array
    axes: int
    is_torque: bool


@dataclass(frozen=True)
class Tree:
    """A random mechanism, what pushes it, and a seed for what else is drawn."""

    links: list[Link]
    gravity: float
    pushes: list[Push]
    seed: int

    @property
    def names(self) -> list[str]:
        """Names of the coordinates, in order."""
        return [name for link in self.links for _, name, _ in link.steps]


# Drawing a tree: hypothesis draws the structure, a generator the numbers


class Numbers:
    """Random numbers of order one."""

    def __init__(self, seed: int) -> None:
        self._generator = np.random.default_rng(seed)

    def uniform(self, low: float, high: float, *shape: int) -> Array:
        return self._generator.uniform(low, high, shape)

    def place(self) -> Array:
        return self.uniform(-1, 1, 3)

    def index(self, low: int, end: int) -> int:
        return int(self._generator.integers(low, end))

    def axis(self) -> Array:
        """Give any axis, a coordinate axis every other time."""
        if self.index(0, 2):
            return np.eye(3)[self.index(0, 3)]
        direction = self._generator.normal(size=3)
        return direction / np.linalg.norm(direction)

    def inertia(self) -> Array:
        """Give the tensor of a ball and of six particles about their mass centre."""
        masses, places = self.uniform(0.1, 0.5, 6), self.uniform(-1, 1, 6, 3)
        places -= masses @ places / masses.sum()
        weighted = np.sqrt(masses)[:, None] * places
        second = weighted.T @ weighted
        return (0.2 + np.trace(second)) * np.eye(3) - second


def rotations(numbers: Numbers, prefix: str) -> tuple[str, list[Step]]:
    sequence = SEQUENCES[numbers.index(0, 6)]
    return sequence, [("hinge", prefix + ANGLES[letter], UNIT[letter]) for letter in sequence]


def a_weld(numbers: Numbers, prefix: str) -> Kind:
    return weld(), []


def a_revolute(numbers: Numbers, prefix: str) -> Kind:
    axis = numbers.axis()
    return revolute(f"{prefix}angle", axis.tolist()), [("hinge", f"{prefix}angle", axis)]


def a_prismatic(numbers: Numbers, prefix: str) -> Kind:
    axis = numbers.axis()
    return prismatic(f"{prefix}travel", axis.tolist()), [("slide", f"{prefix}travel", axis)]


def a_cylindrical(numbers: Numbers, prefix: str) -> Kind:
    axis, names = numbers.axis(), (f"{prefix}travel", f"{prefix}angle")
    return cylindrical(*names, axis.tolist()), [("slide", names[0], axis), ("hinge", names[1], axis)]


def a_planar(numbers: Numbers, prefix: str) -> Kind:
    """Two axes at 60 to 120 degrees."""
    names = (f"{prefix}first", f"{prefix}second", f"{prefix}turn")
    normal, first = numbers.axis(), numbers.axis()
    across = np.cross(normal, first)
    if np.linalg.norm(across) < 0.1:
        across = np.cross(first, np.roll(first, 1) + first)
    second = across / np.linalg.norm(across) + numbers.uniform(-0.5, 0.5) * first
    turn = np.cross(first, second)
    joint = planar(names, (first.tolist(), second.tolist()))
    return joint, [("slide", names[0], first), ("slide", names[1], second), ("hinge", names[2], turn)]


def a_spherical(numbers: Numbers, prefix: str) -> Kind:
    sequence, steps = rotations(numbers, prefix)
    return spherical(sequence, prefix), steps


def a_free(numbers: Numbers, prefix: str) -> Kind:
    sequence, steps = rotations(numbers, prefix)
    slides: list[Step] = [("slide", prefix + letter, UNIT[letter]) for letter in "xyz"]
    return free(sequence, prefix), slides + steps


KINDS: list[Callable[[Numbers, str], Kind]] = [
    a_revolute,
    a_weld,
    a_prismatic,
    a_cylindrical,
    a_planar,
    a_spherical,
    a_free,
]


def link(numbers: Numbers, index: int, parent: int, kind: Callable[[Numbers, str], Kind]) -> Link:
    joint, steps = kind(numbers, f"b{index}_")
    origin = numbers.place()
    centre, probe = (origin + numbers.place() for _ in range(2))
    return Link(
        parent, joint, steps, origin, float(numbers.uniform(0.5, 2)), centre, numbers.inertia(), probe
    )


@st.composite
def trees(draw: st.DrawFn, most_bodies: int) -> Tree:
    """Draw a tree of at least one body that moves, and up to three forces and torques."""
    seed = draw(st.integers(0, 2**32 - 1))
    numbers = Numbers(seed)
    count = draw(st.integers(1, most_bodies))
    kinds = [draw(st.sampled_from(KINDS)) for _ in range(count)]
    if all(kind is a_weld for kind in kinds):
        kinds[-1] = a_revolute
    links = [link(numbers, i, draw(st.integers(GROUND, i - 1)), kind) for i, kind in enumerate(kinds)]
    gravity = draw(st.sampled_from([9.81, 1.0, 0.0]))
    pushes = [
        Push(numbers.index(0, count), numbers.axis(), numbers.index(GROUND, count), draw(st.booleans()))
        for _ in range(draw(st.integers(0, 3)))
    ]
    return Tree(links, gravity, pushes, seed)


# The tree in the package


def build(tree: Tree) -> tuple[Mechanism, dict[int, Body]]:
    mechanism = Mechanism("tree", gravity=tree.gravity)
    bodies = {GROUND: mechanism.ground}
    for i, one in enumerate(tree.links):
        bodies[i] = mechanism.add_body(
            f"body{i}",
            bodies[one.parent],
            one.joint,
            one.origin.tolist(),
            mass=one.mass,
            mass_centre=one.centre.tolist(),
            inertia=one.inertia_about(one.probe).tolist(),
            inertia_about=one.probe.tolist(),
        )
    for i, push in enumerate(tree.pushes):
        body, axis, axes = bodies[push.body], push.axis.tolist(), bodies[push.axes]
        if push.is_torque:
            mechanism.add_applied_torque(f"push{i}", body, axis, axes)
        else:
            point = mechanism.point(f"push{i}", body, tree.links[push.body].probe.tolist())
            mechanism.add_applied_force(f"push{i}", point, axis, axes)
    return mechanism, bodies


# The tree in MuJoCo


def text(numbers: Sequence[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def body_element(tree: Tree, index: int) -> str:
    one = tree.links[index]
    start = tree.links[one.parent].origin if one.parent != GROUND else np.zeros(3)
    i = one.inertia
    moments = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
    joints = [f'<joint name="{name}" type="{kind}" axis="{text(axis)}"/>' for kind, name, axis in one.steps]
    children = [body_element(tree, j) for j, other in enumerate(tree.links) if other.parent == index]
    return f"""<body name="body{index}" pos="{text(one.origin - start)}">{"".join(joints)}
      <inertial pos="{text(one.centre - one.origin)}" mass="{one.mass!r}" fullinertia="{text(moments)}"/>
      <site name="probe{index}" pos="{text(one.probe - one.origin)}"/>{"".join(children)}</body>"""


def mjcf(tree: Tree) -> str:
    roots = [body_element(tree, i) for i, one in enumerate(tree.links) if one.parent == GROUND]
    return f"""<mujoco>
      <compiler angle="radian" inertiafromgeom="false" autolimits="false" fusestatic="false"/>
      <option gravity="0 0 {-tree.gravity!r}">
        <flag contact="disable" constraint="disable" energy="enable"/></option>
      <worldbody>{"".join(roots)}</worldbody></mujoco>"""


@dataclass(frozen=True)
class Twist:
    """A place with rotation matrix, velocities and accelerations relative to the ground, in its axes."""

    place: Array
    rotation: Array
    velocity: Array
    spin: Array
    acceleration: Array
    spin_up: Array


class Engine:
    """MuJoCo's tree at one state."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.model = mujoco.MjModel.from_xml_string(mjcf(tree))
        self.data = mujoco.MjData(self.model)
        self.columns = [self.model.joint(name).dofadr[0] for name in tree.names]

    def move_to(self, position: Array, rate: Array, amounts: Array) -> None:
        """Set the state, push, and work out the accelerations."""
        self.data.qpos[self.columns], self.data.qvel[self.columns] = position, rate
        self.data.qfrc_applied[:] = 0
        mujoco.mj_forward(self.model, self.data)
        for push, amount in zip(self.tree.pushes, amounts, strict=True):
            self._push(push, amount)
        mujoco.mj_forward(self.model, self.data)
        mujoco.mj_rnePostConstraint(self.model, self.data)

    def _push(self, push: Push, amount: float) -> None:
        along = amount * self._rotation(push.axes) @ push.axis
        force, torque = (np.zeros(3), along) if push.is_torque else (along, np.zeros(3))
        place, target = self.data.site(f"probe{push.body}").xpos, self._body(push.body)
        mujoco.mj_applyFT(self.model, self.data, force, torque, place, target, self.data.qfrc_applied)

    def _body(self, index: int) -> int:
        return 0 if index == GROUND else self.model.body(f"body{index}").id

    def _rotation(self, index: int) -> Array:
        return self.data.xmat[self._body(index)].reshape(3, 3)

    @property
    def accelerations(self) -> Array:
        """Second derivatives of the coordinates."""
        return self.data.qacc[self.columns]

    @property
    def mass_matrix(self) -> Array:
        """M, column by column."""
        n = self.model.nv
        product, columns = np.zeros(n), []
        for unit in np.eye(n):
            mujoco.mj_mulM(self.model, self.data, product, unit)
            columns.append(product.copy())
        return np.array(columns)[np.ix_(self.columns, self.columns)]

    @property
    def energies(self) -> Array:
        """Kinetic and potential energy."""
        return self.data.energy[::-1].copy()

    def frame(self, index: int) -> Twist:
        """Motion of a body's frame."""
        body = self._body(index)
        return self._twist(mujoco.mjtObj.mjOBJ_XBODY, body, self.data.xpos[body], self._rotation(index))

    def probe(self, index: int) -> Twist:
        """Motion of the point on a body."""
        site = self.data.site(f"probe{index}")
        return self._twist(mujoco.mjtObj.mjOBJ_SITE, site.id, site.xpos, self._rotation(index))

    def _twist(self, kind: mujoco.mjtObj, number: int, place: Array, rotation: Array) -> Twist:
        velocity, acceleration = np.zeros(6), np.zeros(6)
        mujoco.mj_objectVelocity(self.model, self.data, kind, number, velocity, 0)
        mujoco.mj_objectAcceleration(self.model, self.data, kind, number, acceleration, 0)
        # MuJoCo's accelerations contain -g, as an accelerometer's reading.
        moved = acceleration[3:] + self.model.opt.gravity
        return Twist(place.copy(), rotation.copy(), velocity[3:], velocity[:3], moved, acceleration[:3])


# The comparison


def random_arguments(tree: Tree) -> Array:
    """Draw coordinates within a radian or metre, rates and pushes, no accelerations; (arguments, states)."""
    n, m = len(tree.names), len(tree.pushes)
    scale = np.concatenate([np.full(n, 1.0), np.full(n, 2.0), np.zeros(n), np.full(m, 5.0), np.zeros(m)])
    return scale[:, None] * Numbers(tree.seed).uniform(-1, 1, len(scale), STATES)


def evaluated(function: Callable[..., list], arguments: Array) -> Array:
    """Evaluate to shape (results, states)."""
    return np.array([np.broadcast_to(row, arguments.shape[1]) for row in function(*arguments)], dtype=float)


def close(found: Array, expected: Array, tolerance: float, scale: float) -> bool:
    return bool(np.max(np.abs(found - expected), initial=0) <= tolerance * scale)


@dataclass(frozen=True)
class Motion:
    """What both sides say about a tree at all its states, the states along the last axis."""

    mass_matrix: Array
    accelerations: Array
    energies: Array


def by_package(tree: Tree, lambdified: Callable, arguments: Array) -> Motion:
    equations, n = derive(build(tree)[0]), len(tree.names)
    energies = equations.energies
    entries = [entry for row in equations.mass_matrix for entry in row]
    results = [*entries, *equations.accelerations, energies.kinetic, energies.potential]
    found = evaluated(lambdified(equations.program, equations.arguments, results), arguments)
    return Motion(found[: n * n].reshape(n, n, -1), found[n * n : -2], found[-2:])


def by_engine(tree: Tree, arguments: Array) -> Motion:
    engine, n = Engine(tree), len(tree.names)
    found = []
    for state in arguments.T:
        engine.move_to(state[:n], state[n : 2 * n], state[3 * n : 3 * n + len(tree.pushes)])
        found.append((engine.mass_matrix, engine.accelerations, engine.energies))
    return Motion(*(np.stack(parts, axis=-1) for parts in zip(*found, strict=True)))


@settings(RANDOM, max_examples=10)
@given(tree=trees(most_bodies=6))
def test_motion(tree: Tree, lambdified: Callable) -> None:
    """Mass matrix, accelerations under random pushes, and energies, of a few small trees in every run."""
    check_motion(tree, lambdified)


@pytest.mark.slow
@settings(RANDOM, max_examples=100)
@given(tree=trees(most_bodies=10))
def test_motion_of_many_trees(tree: Tree, lambdified: Callable) -> None:
    """The same of a hundred trees of up to ten bodies."""
    check_motion(tree, lambdified)


def check_motion(tree: Tree, lambdified: Callable) -> None:
    """Compare with MuJoCo.

    Accelerations agree to 1e-12 of their norm as long as M has a condition number below 1000. Rounding in M
    comes back multiplied by it, so that the tolerance grows in proportion: 1e-9 at 1e6.
    """
    arguments, n = random_arguments(tree), len(tree.names)
    found, expected = by_package(tree, lambdified, arguments), by_engine(tree, arguments)
    matrices = np.moveaxis(expected.mass_matrix, -1, 0)
    assert close(found.mass_matrix, expected.mass_matrix, MATRIX_TOLERANCE, np.abs(matrices).max())
    error = np.linalg.norm(found.accelerations - expected.accelerations, axis=0)
    size = max(1, np.linalg.norm(expected.accelerations, axis=0).max())
    loosened = np.maximum(1, np.linalg.cond(matrices) / WELL_CONDITIONED)
    assert np.all(error <= MOTION_TOLERANCE * loosened * size)
    kinetic, rates = expected.energies[0], arguments[n : 2 * n].T
    assert close(found.energies[0], kinetic, MATRIX_TOLERANCE, kinetic.max())
    quadratic = np.einsum("si,sij,sj->s", rates, matrices, rates) / 2
    assert close(found.energies[0], quadratic, MATRIX_TOLERANCE, kinetic.max())
    # Where the potential energy is zero is a convention; states share it.
    lifted = [motion.energies[1] - motion.energies[1, 0] for motion in (found, expected)]
    assert close(lifted[0], lifted[1], MATRIX_TOLERANCE, 100 * len(tree.links))


def measured_twist(name: str, probe: Twist, frame: Twist, axes: Array, observer: Twist) -> dict[str, Array]:
    """What an observer sees of a point, or the body it is on, along axes given in the ground's.

    Transport theorem: v' = v - v_o - w x r, a' = a - a_o - w' x r - w x (w x r) - 2 w x v', and for a body's
    own spin W: W' - w' - w x W.
    """
    arm, spin = probe.place - observer.place, observer.spin
    velocity = probe.velocity - observer.velocity - np.cross(spin, arm)
    carried = observer.acceleration + np.cross(observer.spin_up, arm) + np.cross(spin, np.cross(spin, arm))
    acceleration = probe.acceleration - carried - 2 * np.cross(spin, velocity)
    spin_up = probe.spin_up - observer.spin_up - np.cross(spin, probe.spin)
    return {
        f"{name}_position": frame.rotation.T @ (probe.place - frame.place),
        f"{name}_velocity": axes.T @ velocity,
        f"{name}_acceleration": axes.T @ acceleration,
        f"{name}_spin": axes.T @ (probe.spin - spin),
        f"{name}_spin_up": axes.T @ spin_up,
    }


@dataclass(frozen=True)
class Look:
    """Which bodies a body's point is measured from: frame of its position, axes, observer; and the axis."""

    frame: int
    axes: int
    observer: int
    axis: Array


def add_outputs(mechanism: Mechanism, bodies: dict[int, Body], tree: Tree, looks: list[Look]) -> None:
    for i, look in enumerate(looks):
        point = mechanism.point(f"probe{i}", bodies[i], tree.links[i].probe.tolist())
        axis, frame = look.axis.tolist(), bodies[look.frame]
        seen = (axis, bodies[look.axes], bodies[look.observer])
        for output in (
            PointPosition(f"body{i}_position", point, axis, frame),
            PointVelocity(f"body{i}_velocity", point, *seen),
            PointAcceleration(f"body{i}_acceleration", point, *seen),
            AngularVelocity(f"body{i}_spin", bodies[i], *seen),
            AngularAcceleration(f"body{i}_spin_up", bodies[i], *seen),
        ):
            mechanism.add_output(output)


def random_looks(tree: Tree) -> list[Look]:
    """Draw who looks: the ground or any body, before or behind the one that is looked at or beside it."""
    numbers, count = Numbers(tree.seed + 1), len(tree.links)
    anyone = [[numbers.index(GROUND, count) for _ in range(3)] for _ in tree.links]
    return [Look(*bodies, numbers.axis()) for bodies in anyone]


@settings(RANDOM, max_examples=12)
@given(tree=trees(most_bodies=5))
def test_measurements(tree: Tree, lambdified: Callable) -> None:
    """Positions, velocities, accelerations of points and spins of bodies, as other bodies see them."""
    (mechanism, bodies), looks, n = build(tree), random_looks(tree), len(tree.names)
    add_outputs(mechanism, bodies, tree, looks)
    equations, engine, arguments = derive(mechanism), Engine(tree), random_arguments(tree)
    expected = []
    for state in arguments.T:
        engine.move_to(state[:n], state[n : 2 * n], state[3 * n : 3 * n + len(tree.pushes)])
        state[2 * n : 3 * n] = engine.accelerations
        seen: dict[str, Array] = {}
        for i, look in enumerate(looks):
            frames = [engine.frame(body) for body in (look.frame, look.axes, look.observer)]
            twist = measured_twist(f"body{i}", engine.probe(i), frames[0], frames[1].rotation, frames[2])
            seen |= {name: float(look.axis @ vector) for name, vector in twist.items()}
        expected.append([seen[name] for name in equations.outputs])
    results = list(equations.outputs.values())
    found = evaluated(lambdified(equations.program, equations.arguments, results), arguments)
    truth = np.array(expected).T
    assert close(found, truth, MOTION_TOLERANCE, max(1, np.abs(truth).max()))


def test_order_of_products_of_inertia() -> None:
    """MuJoCo reads ixx iyy izz ixy ixz iyz as elements of the tensor: both sides have equal bodies."""
    tree = Tree([link(Numbers(4), 0, GROUND, a_free)], 0.0, [], 0)
    engine = Engine(tree).model
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, engine.body_iquat[1])
    axes = turned.reshape(3, 3)
    np.testing.assert_allclose(axes * engine.body_inertia[1] @ axes.T, tree.links[0].inertia, rtol=1e-12)

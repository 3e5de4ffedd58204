"""Conservation laws and symmetry of the reference car.

Positions of all bodies are written out here by rotation matrices; energies and momentum follow from them and
the parameters alone, so that only the accelerations under test come from the derived equations.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from chassym.derivation import Model

AXLES, SIDES = ("front", "rear"), {"left": 1, "right": -1}
CORNERS = [(axle, side) for axle in AXLES for side in SIDES]

Array = np.ndarray


@dataclass(frozen=True)
class Motion:
    """A vector or matrix with its first and second derivatives by time."""

    value: Array
    rate: Array
    second: Array

    def __add__(self, other: "Motion") -> "Motion":
        return Motion(self.value + other.value, self.rate + other.rate, self.second + other.second)

    def __matmul__(self, other: "Motion") -> "Motion":
        return Motion(
            self.value @ other.value,
            self.rate @ other.value + self.value @ other.rate,
            self.second @ other.value + 2 * self.rate @ other.rate + self.value @ other.second,
        )


def fixed(vector: Array) -> Motion:
    return Motion(vector, 0 * vector, 0 * vector)


def turn(axis: int, angle: float, rate: float, second: float) -> Motion:
    """Give the rotation matrix about a coordinate axis: R = 1 + sin K + (1 - cos) K^2 with K r = axis x r."""
    by_sine = np.cross(np.eye(3)[axis], np.eye(3)).T
    by_cosine = -by_sine @ by_sine
    s, c = np.sin(angle), np.cos(angle)
    return Motion(
        np.eye(3) + s * by_sine + (c - 1) * by_cosine,
        (c * by_sine - s * by_cosine) * rate,
        (c * by_sine - s * by_cosine) * second - (s * by_sine + c * by_cosine) * rate**2,
    )


@dataclass(frozen=True)
class Moving:
    """A rigid body: motion of its mass centre, rotation matrix, mass and principal moments."""

    centre: Motion
    rotation: Motion
    mass: float
    inertia: Array

    @property
    def kinetic_energy(self) -> float:
        """Half m v^2 + omega I omega, with omega x = R^T dR/dt."""
        spin = self.rotation.value.T @ self.rotation.rate
        omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        return float(self.mass * np.sum(self.centre.rate**2) + np.sum(self.inertia * omega**2)) / 2


class WrittenOut:
    """Bodies, displacements of the contact patches and wheel travels of the car at one state."""

    def __init__(self, model: Model, q: Array, v: Array, a: Array) -> None:
        self.value, self.preloads, self.state = model.parameters.flat(), model.preloads, np.array([q, v, a])
        self.bodies: list[Moving] = []
        self.patches: list[Array] = []
        self.travels: list[float] = []
        centre = self._place("body.middle.mass_centre")
        at = fixed(centre) + Motion(q[:3], v[:3], a[:3])
        turned = self._turn(2, 3) @ self._turn(1, 4) @ self._turn(0, 5)
        self._add("body.middle", at, turned)
        for axle in AXLES:
            self._section(axle, at, centre, turned)

    def _turn(self, axis: int, coordinate: int) -> Motion:
        return turn(axis, *self.state[:, coordinate])

    def _place(self, name: str) -> Array:
        return np.array([self.value[f"{name}.x"], 0.0, self.value[f"{name}.z"]])

    def _add(self, prefix: str, centre: Motion, rotation: Motion) -> None:
        inertia = np.array([self.value[f"{prefix}.inertia.{axes}"] for axes in ("xx", "yy", "zz")])
        self.bodies.append(Moving(centre, rotation, self.value[f"{prefix}.mass"], inertia))

    def _section(self, axle: str, at: Motion, origin: Array, turned: Motion) -> None:
        """One end of the body and the two arms on it; `at` is where the design position `origin` has gone."""
        centre = self._place(f"body.{axle}.mass_centre")
        axis = np.array([centre[0], 0.0, self.value[f"body.{axle}.torsion_axis.z"]])
        hinge = at + turned @ fixed(axis - origin)
        own = turned @ self._turn(0, 6 + AXLES.index(axle))
        self._add(f"body.{axle}", hinge + own @ fixed(centre - axis), own)
        for side, sign in SIDES.items():
            pivot, wheel, patch = (
                self._hard_point(axle, p, sign) for p in ("arm_pivot", "wheel_centre", "contact_patch")
            )
            swing = self._turn(0, 8 + CORNERS.index((axle, side)))
            place, arm = hinge + own @ fixed(pivot - axis), own @ swing
            self._add(f"suspension.{axle}.unsprung", place + arm @ fixed(wheel - pivot), arm)
            self.patches.append((place + arm @ fixed(patch - pivot)).value - patch)
            self.travels.append((pivot + swing.value @ (wheel - pivot) - wheel)[2])

    def _hard_point(self, axle: str, name: str, sign: int) -> Array:
        y, z = (self.value[f"suspension.{axle}.{name}.{axis}"] for axis in "yz")
        return np.array([self.value[f"axle.{axle}.x"], sign * y, z])

    @property
    def kinetic_energy(self) -> float:
        """Of all bodies (J)."""
        return sum(body.kinetic_energy for body in self.bodies)

    @property
    def mean_acceleration(self) -> Array:
        """Acceleration of the total mass centre (m/s^2)."""
        total = sum(body.mass * body.centre.second for body in self.bodies)
        return np.asarray(total / sum(body.mass for body in self.bodies))

    @property
    def potential_energy(self) -> float:
        """Of weights, springs with their preloads, body torsion, anti-roll bars and tyres (J)."""
        weight = self.value["gravity"] * sum(body.mass * body.centre.value[2] for body in self.bodies)
        return float(weight + sum(map(self._axle_energy, AXLES)) + sum(map(self._tyre_energy, CORNERS)))

    def _axle_energy(self, axle: str) -> float:
        value, torsion = self.value, self.state[0, 6 + AXLES.index(axle)]
        place, total = f"suspension.{axle}", value[f"body.{axle}.torsional_stiffness"] * torsion**2 / 2
        left, right = (self.travels[CORNERS.index((axle, side))] for side in SIDES)
        total += value[f"{place}.anti_roll_bar.rate"] * (left - right) ** 2 / 2
        total += self.preloads[f"{axle}_left_spring.preload"] * left
        total += self.preloads[f"{axle}_right_spring.preload"] * right
        wheel_rate = value[f"{place}.spring.rate"] / value[f"{place}.spring.lever_ratio"] ** 2
        return total + wheel_rate * (left**2 + right**2) / 2

    def _tyre_energy(self, corner: tuple[str, str]) -> float:
        axle, side = corner
        patch = self.patches[CORNERS.index(corner)]
        stiffness = [self.value[f"tyre.{axle}.stiffness.{axis}"] for axis in "xyz"]
        preload = self.preloads[f"{axle}_{side}_tyre_z.preload"]
        return float(np.sum(stiffness * patch**2) / 2 + preload * patch[2])


IDLE = np.zeros(12)


def without_dampers(car: Model) -> Model:
    changes: dict[str, float | list[float]] = {}
    for axle in AXLES:
        changes[f"body.{axle}.stiffness_proportional_damping"] = 0.0
        changes |= {f"tyre.{axle}.damping.{axis}": 0.0 for axis in "xyz"}
        changes[f"suspension.{axle}.damper.force"] = [0.0] * 5
    return car.with_parameters(changes)


def without_ground(car: Model) -> Model:
    """Take the tyres and every preload away: the car falls freely."""
    floating = car.scaled("tyre", factor=0.0)
    return Model(floating.parameters, floating.compiled, dict.fromkeys(car.preloads, 0.0))


def random_state(generator: np.random.Generator, position: float, rate: float) -> tuple[Array, Array]:
    return position * generator.uniform(-1, 1, 12), rate * generator.uniform(-1, 1, 12)


def all_arguments(model: Model, q: Array, v: Array) -> Array:
    inputs = 2 * len(model.system.inputs)
    return np.concatenate([q, v, np.zeros(12 + inputs)])


def test_kinetic_energy_is_that_of_the_mass_matrix(sedan: Model, lambdified: Callable) -> None:
    """T of the written-out bodies is half v^T M v."""
    equations = sedan.equations
    entries = [entry for row in equations.mass_matrix for entry in row]
    values = {sympy.Symbol(name, real=True): value for name, value in sedan.values.items()}
    coordinates = [c.position for c in equations.coordinates]
    mass_matrix = lambdified(equations.program, [*values, *coordinates], entries)
    generator = np.random.default_rng(1)
    for _ in range(10):
        q, v = random_state(generator, 0.5, 3.0)
        own = np.reshape(mass_matrix(*values.values(), *q), (12, 12))
        assert v @ own @ v / 2 == pytest.approx(WrittenOut(sedan, q, v, IDLE).kinetic_energy, rel=1e-13)


def test_energy_is_conserved_without_dampers(sedan: Model) -> None:
    """10 s of free vibration from a large state: 2 cm and 0.02 rad, 0.2 m/s and rad/s."""
    car = without_dampers(sedan)
    accelerate = car.accelerations.single()
    arguments = np.zeros(car.argument_count)

    def slope(_: float, state: Array) -> Array:
        arguments[:24] = state
        return np.concatenate([state[12:], accelerate(arguments)])

    start = np.concatenate(random_state(np.random.default_rng(7), 0.02, 0.2))
    start[6:8] /= 20  # the body's torsion springs are stiff: a twist of 0.02 rad stores 1000 J
    run = solve_ivp(
        slope, (0, 10), start, method="DOP853", rtol=1e-11, atol=1e-12, t_eval=np.linspace(0, 10, 101)
    )
    assert run.success
    moments = [WrittenOut(car, *state.reshape(2, 12), IDLE) for state in run.y.T]
    kinetic, potential = (
        np.array([getattr(m, f"{k}_energy") for m in moments]) for k in ("kinetic", "potential")
    )
    total = kinetic + potential
    assert np.ptp(potential) > 0.5 * kinetic.max()
    assert np.abs(total - total[0]).max() < 1e-8 * kinetic.max()


def test_dampers_take_energy_away(sedan: Model) -> None:
    """With the pads at rest the power of all forces, dT/dt + dV/dt, is negative in every state that moves."""
    generator, h = np.random.default_rng(5), 1e-4
    for _ in range(20):
        q, v = random_state(generator, 0.1, 1.0)
        a = sedan.accelerations(all_arguments(sedan, q, v)[:, None])[:, 0]
        energies = []
        for t in (-h, h):
            moved, rate = q + v * t + a * t**2 / 2, v + a * t
            moment = WrittenOut(sedan, moved, rate, IDLE)
            energies.append(moment.kinetic_energy + moment.potential_energy)
        assert (energies[1] - energies[0]) / (2 * h) < 0


def test_internal_forces_move_no_mass_centre(sedan: Model) -> None:
    """Without tyres the total mass centre falls with gravity and nothing else, however the car twists."""
    car = without_ground(sedan)
    generator = np.random.default_rng(2)
    for _ in range(20):
        q, v = random_state(generator, 0.5, 5.0)
        a = car.accelerations(all_arguments(car, q, v)[:, None])[:, 0]
        mean = WrittenOut(car, q, v, a).mean_acceleration
        assert mean == pytest.approx([0, 0, -9.81], abs=1e-15 * np.abs(a).max())


def test_free_fall_is_free_of_internal_motion(sedan: Model) -> None:
    """At rest at the design position, without tyres and preloads, every part falls alike."""
    car = without_ground(sedan)
    fall = car.accelerations(np.zeros((car.argument_count, 1)))[:, 0]
    assert fall == pytest.approx(-9.81 * np.eye(12)[2], abs=1e-12)


def mirrored(values: Array) -> Array:
    """Reflect coordinates, rates or accelerations, shape (12, states), in the plane y = 0."""
    signs = np.array([1, -1, 1, -1, 1, -1, -1, -1, -1, -1, -1, -1])
    order = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8, 11, 10]
    return signs[:, None] * values[order]


def mirrored_pads(values: Array) -> Array:
    """Reflect pad positions or rates, shape (12, states): corners exchanged, y reversed."""
    pads = values.reshape(4, 3, -1)[[1, 0, 3, 2]]
    return (pads * np.array([1, -1, 1])[None, :, None]).reshape(12, -1)


def test_left_and_right_are_alike(sedan: Model) -> None:
    """The mirror image of a state has the mirror image of its accelerations."""
    generator, states = np.random.default_rng(4), 40
    q, v = (scale * generator.uniform(-1, 1, (12, states)) for scale in (0.4, 4.0))
    u, w = (scale * generator.uniform(-1, 1, (12, states)) for scale in (0.1, 1.0))
    idle = np.zeros((12, states))
    found = sedan.accelerations(np.vstack([q, v, idle, u, w]))
    reflected = [mirrored(q), mirrored(v), idle, mirrored_pads(u), mirrored_pads(w)]
    image = sedan.accelerations(np.vstack(reflected))
    difference = np.abs(image - mirrored(found)).max(axis=1)
    assert np.all(difference < 1e-12 * np.abs(found).max(axis=1))


def test_the_car_feels_no_place_and_no_heading_without_tyres(sedan: Model) -> None:
    """Moved along the ground and turned about the vertical, a car without tyres accelerates the same way."""
    car = without_ground(sedan)
    q, v = random_state(np.random.default_rng(6), 0.4, 4.0)
    angle = 0.7
    turn = np.eye(12)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    moved = turn @ q
    moved[:4] += [3.0, -2.0, 1.0, angle]
    here, there = (
        car.accelerations(all_arguments(car, *state)[:, None])[:, 0] for state in ((q, v), (moved, turn @ v))
    )
    assert there == pytest.approx(turn @ here, abs=1e-12 * np.abs(here).max())

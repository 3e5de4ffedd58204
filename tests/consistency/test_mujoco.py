"""The reference car against MuJoCo: accelerations and outputs at random states far from the design position.

MuJoCo gets the same tree of bodies, without springs. Springs, dampers, bars and tyres are computed here from
MuJoCo's own positions and Jacobians and brought in through `qfrc_applied`, so that nothing of chassym but its
parameters and preloads is used.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chassym.derivation import Model
from chassym.nonlinear import rig, simulate

AXLES, SIDES = ("front", "rear"), {"left": 1.0, "right": -1.0}
CORNERS = [f"{axle}_{side}" for axle, side in product(AXLES, SIDES)]
STATES = 200
TOLERANCE = 1e-9
RANGES = {"m": (0.2, 2.0), "rad": (0.5, 5.0)}  # coordinates and rates

Array = np.ndarray
TableForce = Callable[[Array, Array, Array], Array]


class Places:
    """Design positions of the car's points, from its parameters."""

    def __init__(self, model: Model) -> None:
        self._value = model.parameters.flat()

    def section(self, name: str) -> Array:
        """Origin of a body section's frame: the mass centre, or the torsion axis at the same station."""
        x = self._value[f"body.{name}.mass_centre.x"]
        height = "mass_centre.z" if name == "middle" else "torsion_axis.z"
        return np.array([x, 0.0, self._value[f"body.{name}.{height}"]])

    def mass_centre(self, section: str) -> Array:
        """Mass centre of a body section."""
        return np.array(
            [self._value[f"body.{section}.mass_centre.x"], 0.0, self._value[f"body.{section}.mass_centre.z"]]
        )

    def corner(self, corner: str, point: str) -> Array:
        """Arm pivot, wheel centre or contact patch of one corner."""
        axle, side = corner.split("_")
        y, z = (self._value[f"suspension.{axle}.{point}.{axis}"] for axis in "yz")
        return np.array([self._value[f"axle.{axle}.x"], SIDES[side] * y, z])


def text(numbers: Sequence[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def inertial(model: Model, prefix: str, place: Array) -> str:
    value = model.parameters.flat()
    moments = [value[f"{prefix}.inertia.{axes}"] for axes in ("xx", "yy", "zz")]
    mass = value[f"{prefix}.mass"]
    return f'<inertial pos="{text(place)}" mass="{mass!r}" diaginertia="{text(moments)}"/>'


def arm(model: Model, corner: str, parent: Array) -> str:
    places, axle = Places(model), corner.split("_")[0]
    pivot, wheel, patch = (places.corner(corner, p) for p in ("arm_pivot", "wheel_centre", "contact_patch"))
    return f"""
      <body name="{corner}_arm" pos="{text(pivot - parent)}">
        <joint name="{corner}_arm_angle" type="hinge" axis="1 0 0"/>
        {inertial(model, f"suspension.{axle}.unsprung", wheel - pivot)}
        <site name="{corner}_wheel" pos="{text(wheel - pivot)}"/>
        <site name="{corner}_patch" pos="{text(patch - pivot)}"/>
      </body>"""


def end_section(model: Model, axle: str, parent: Array) -> str:
    places = Places(model)
    origin = places.section(axle)
    arms = "".join(arm(model, f"{axle}_{side}", origin) for side in SIDES)
    return f"""
    <body name="{axle}" pos="{text(origin - parent)}">
      <joint name="{axle}_torsion" type="hinge" axis="1 0 0"/>
      {inertial(model, f"body.{axle}", places.mass_centre(axle) - origin)}{arms}
    </body>"""


def mjcf(model: Model) -> str:
    """Write the tree of bodies as MuJoCo reads it."""
    places = Places(model)
    origin = places.section("middle")
    slides = (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1"))
    hinges = (("yaw", "0 0 1"), ("pitch", "0 1 0"), ("roll", "1 0 0"))
    joints = "".join(f'<joint name="{n}" type="slide" axis="{a}"/>' for n, a in slides)
    joints += "".join(f'<joint name="{n}" type="hinge" axis="{a}"/>' for n, a in hinges)
    gravity = -model.parameters.flat()["gravity"]
    return f"""
<mujoco>
  <compiler angle="radian" inertiafromgeom="false" autolimits="false"/>
  <option gravity="0 0 {gravity!r}"><flag contact="disable" constraint="disable"/></option>
  <worldbody><body name="middle" pos="{text(origin)}">{joints}
    {inertial(model, "body.middle", places.mass_centre("middle") - origin)}
    {"".join(end_section(model, axle, origin) for axle in AXLES)}
  </body></worldbody>
</mujoco>"""


@dataclass
class Engine:
    """MuJoCo's car at one state, with the forces of the force elements applied."""

    model: Model
    table_force: TableForce

    def __post_init__(self) -> None:
        self.engine = mujoco.MjModel.from_xml_string(mjcf(self.model))
        self.data = mujoco.MjData(self.engine)
        self.values = self.model.values
        self.columns = [self.engine.joint(c.name).dofadr[0] for c in self.model.system.coordinates]

    def move_to(self, position: Array, rate: Array, pads: Array, pad_rates: Array) -> None:
        """Set the state, work out all forces and then the accelerations; pads have shape (4, 3)."""
        self.data.qpos[self.columns], self.data.qvel[self.columns] = position, rate
        self.data.qfrc_applied[:] = 0
        mujoco.mj_forward(self.engine, self.data)
        self.applied = np.zeros(self.engine.nv)
        self.outputs: dict[str, float] = {}
        for axle in AXLES:
            self._body_torsion(axle)
            self._suspension(axle)
        for corner, pad, pad_rate in zip(CORNERS, pads, pad_rates, strict=True):
            self._tyre(corner, pad, pad_rate)
        self.data.qfrc_applied[:] = self.applied
        mujoco.mj_forward(self.engine, self.data)

    def _resist(self, jacobian: Array, force: float) -> None:
        self.applied -= jacobian * force

    def _body_torsion(self, axle: str) -> None:
        stiffness = self.values[f"body.{axle}.torsional_stiffness"]
        damping = stiffness * self.values[f"body.{axle}.stiffness_proportional_damping"]
        column = self.engine.joint(f"{axle}_torsion").dofadr[0]
        moment = stiffness * self.data.qpos[column] + damping * self.data.qvel[column]
        self._resist(np.eye(self.engine.nv)[column], moment)

    def _suspension(self, axle: str) -> None:
        """Springs, dampers and anti-roll bar of one axle, by the wheel centres' travels in their section."""
        travels, jacobians = zip(*(self._travel(f"{axle}_{side}") for side in SIDES), strict=True)
        place = f"suspension.{axle}"
        lever = self.values[f"{place}.spring.lever_ratio"]
        table = [np.array(self.model.parameters.value(f"{place}.damper.{n}")) for n in ("velocity", "force")]
        for side, travel, jacobian in zip(SIDES, travels, jacobians, strict=True):
            spring = self.values[f"{place}.spring.rate"] / lever**2 * travel
            spring += self.model.preloads[f"{axle}_{side}_spring.preload"]
            damper = self.table_force(jacobian @ self.data.qvel, *table)
            self._resist(jacobian, spring + damper / self.values[f"{place}.damper.lever_ratio"] ** 2)
            self.outputs[f"{axle}_{side}_wheel_travel"] = travel
        bar = self.values[f"{place}.anti_roll_bar.rate"] * (travels[0] - travels[1])
        self._resist(jacobians[0] - jacobians[1], bar)

    def _travel(self, corner: str) -> tuple[float, Array]:
        """Travel of a wheel centre along its section's z axis, and its derivative by MuJoCo's coordinates."""
        axle, places = corner.split("_")[0], Places(self.model)
        section, wheel = self.engine.body(axle).id, self.data.site(f"{corner}_wheel")
        up = self.data.body(axle).xmat.reshape(3, 3)[:, 2]
        inside = up @ (wheel.xpos - self.data.body(axle).xpos)
        design = places.corner(corner, "wheel_centre")[2] - places.section(axle)[2]
        own, beneath = (
            self._jacobian(wheel.xpos, self.engine.body(f"{corner}_arm").id),
            self._jacobian(wheel.xpos, section),
        )
        self.outputs[f"{corner}_wheel_displacement"] = (
            wheel.xpos[2] - places.corner(corner, "wheel_centre")[2]
        )
        return float(inside - design), up @ (own - beneath)

    def _tyre(self, corner: str, pad: Array, pad_rate: Array) -> None:
        axle = corner.split("_")[0]
        place = self.data.site(f"{corner}_patch").xpos
        jacobian = self._jacobian(place, self.engine.body(f"{corner}_arm").id)
        stretch = place - Places(self.model).corner(corner, "contact_patch") - pad
        rate = jacobian @ self.data.qvel - pad_rate
        preload = (0, 0, self.model.preloads[f"{corner}_tyre_z.preload"])
        for i, axis in enumerate("xyz"):
            stiffness, damping = (
                self.values[f"tyre.{axle}.{kind}.{axis}"] for kind in ("stiffness", "damping")
            )
            force = stiffness * stretch[i] + damping * rate[i] + preload[i]
            self._resist(jacobian[i], force)
            self.outputs[f"{corner}_patch_force_{axis}"] = -force

    def _jacobian(self, place: Array, body: int) -> Array:
        found = np.zeros((3, self.engine.nv))
        mujoco.mj_jac(self.engine, self.data, found, None, place, body)
        return found

    def read_sensors(self) -> None:
        """Acceleration of the middle section's mass centre and angular velocity, in ground and body axes."""
        body = self.engine.body("middle").id
        motion, spin = np.zeros(6), np.zeros(6)
        mujoco.mj_rnePostConstraint(self.engine, self.data)
        mujoco.mj_objectAcceleration(self.engine, self.data, mujoco.mjtObj.mjOBJ_BODY, body, motion, 0)
        mujoco.mj_objectVelocity(self.engine, self.data, mujoco.mjtObj.mjOBJ_BODY, body, spin, 0)
        # An accelerometer at rest reads -g; the acceleration of the place does not contain it.
        acceleration = motion[3:] + self.engine.opt.gravity
        axes = self.data.body("middle").xmat.reshape(3, 3)
        for prefix, turn in (("", np.eye(3)), ("body_axes_", axes.T)):
            for name, value in zip(("longitudinal", "lateral", "vertical"), turn @ acceleration, strict=True):
                self.outputs[f"{prefix}{name}_acceleration"] = value
            for name, value in zip(("roll", "pitch", "yaw"), turn @ spin[:3], strict=True):
                self.outputs[f"{prefix}{name}_rate"] = value
        centre = Places(self.model).mass_centre("middle")
        self.outputs["body_displacement"] = self.data.body("middle").xipos[2] - centre[2]


def random_arguments(model: Model, generator: np.random.Generator, scale: float) -> Array:
    """Draw coordinates, rates, no accelerations, pads and pad rates; shape (arguments, states)."""
    limits = np.array([RANGES[c.unit] for c in model.system.coordinates]) * scale
    n, m = len(limits), len(model.system.inputs)
    low_high = np.concatenate(
        [limits[:, 0], limits[:, 1], np.zeros(n), np.full(m, 0.1 * scale), np.full(m, scale)]
    )
    return low_high[:, None] * generator.uniform(-1, 1, (len(low_high), STATES))


@dataclass(frozen=True)
class Comparison:
    """Both engines' answers at the same states: accelerations (n, states) and outputs (names, states)."""

    accelerations: Array
    outputs: Array
    expected_accelerations: Array
    expected_outputs: Array


def compare(model: Model, table_force: TableForce, scale: float) -> Comparison:
    arguments = random_arguments(model, np.random.default_rng(20), scale)
    n, m = model.size, len(model.system.inputs)
    arguments[2 * n : 3 * n] = model.accelerations(arguments)
    engine, expected, outputs = Engine(model, table_force), [], []
    for state in arguments.T:
        pads, pad_rates = state[3 * n : 3 * n + m].reshape(4, 3), state[3 * n + m :].reshape(4, 3)
        engine.move_to(state[:n], state[n : 2 * n], pads, pad_rates)
        engine.read_sensors()
        expected.append(engine.data.qacc[engine.columns])
        outputs.append([engine.outputs[name] for name in model.output_names])
    return Comparison(
        arguments[2 * n : 3 * n], model.outputs(arguments), np.array(expected).T, np.array(outputs).T
    )


@pytest.fixture(scope="module", params=[1.0, 0.02], ids=["large motion", "small motion"])
def comparison(request: pytest.FixtureRequest, sedan: Model, table_force: TableForce) -> Iterator[Comparison]:
    """Give both engines' answers at 200 states, up to 0.5 rad and 5 rad/s or a fiftieth of it."""
    yield compare(sedan, table_force, request.param)


def test_accelerations(comparison: Comparison) -> None:
    difference = np.linalg.norm(comparison.accelerations - comparison.expected_accelerations, axis=0)
    assert np.all(difference < TOLERANCE * np.linalg.norm(comparison.expected_accelerations, axis=0))


def test_every_coordinate_on_its_own_scale(comparison: Comparison) -> None:
    """The torsions' large accelerations hide no error in the body's small ones."""
    difference = np.abs(comparison.accelerations - comparison.expected_accelerations).max(axis=1)
    assert np.all(difference < TOLERANCE * np.abs(comparison.expected_accelerations).max(axis=1))


def test_every_output_on_its_own_scale(comparison: Comparison) -> None:
    difference = np.abs(comparison.outputs - comparison.expected_outputs).max(axis=1)
    assert np.all(difference < TOLERANCE * np.abs(comparison.expected_outputs).max(axis=1))


def test_other_parameters(sedan: Model, table_force: TableForce) -> None:
    """Mass centres off the torsion axes, patches beside the wheel centres, a soft body."""
    variant = sedan.with_parameters(
        {
            "body.front.mass_centre.x": 0.3,
            "body.front.mass_centre.z": 0.5,
            "body.rear.torsion_axis.z": 0.1,
            "body.middle.inertia.xx": 150.0,
            "body.rear.inertia.zz": 200.0,
            "body.front.torsional_stiffness": 1e4,
            "suspension.front.contact_patch.y": -0.8,
            "suspension.rear.wheel_centre.z": 0.05,
            "suspension.rear.unsprung.mass": 80.0,
            "suspension.front.damper.velocity": [-0.8, -0.3, 0.1, 0.4, 0.5],
            "tyre.rear.stiffness.x": 9e4,
        }
    )
    found = compare(variant, table_force, 1.0)
    for own, other in (
        (found.accelerations, found.expected_accelerations),
        (found.outputs, found.expected_outputs),
    ):
        assert np.all(np.abs(own - other).max(axis=1) < TOLERANCE * np.abs(other).max(axis=1))


@pytest.mark.parametrize("name", ["lateral", "vertical"])
def test_the_engine_s_accelerations_integrated_give_the_same_motion(
    sedan: Model, table_force: TableForce, name: str
) -> None:
    """A third of a period from rest by steps of order five across the knots, all dynamics from MuJoCo."""
    excitation, end_s, n = getattr(rig, name)(), 0.1, sedan.size
    engine = Engine(sedan, table_force)

    def rates(time_s: float, state: Array) -> Array:
        pads, pad_rates = (each.reshape(4, 3) for each in excitation.signals(sedan, np.array([time_s])))
        engine.move_to(state[:n], state[n:], pads, pad_rates)
        return np.concatenate([state[n:], engine.data.qacc[engine.columns]])

    expected = solve_ivp(rates, (0, end_s), np.zeros(2 * n), rtol=1e-7, atol=1e-10).y[:, -1]
    found = simulate(sedan, excitation, np.array([0.0, end_s]), relative_tolerance=1e-9)
    assert found.events["knot"] > 3 and np.abs(expected[:n]).max() > 1e-3
    np.testing.assert_allclose(found.states[:, -1], expected, atol=1e-6)

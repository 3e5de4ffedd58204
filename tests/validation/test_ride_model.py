"""Ride models of books and papers, with the frequencies and poles that they print, and their closed forms.

Every test names its source. Printed numbers are compared to half a unit of their last digit, models whose
matrices are printed with the eigenvalues of these matrices, written out here by hand.
"""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.linalg import eigh

from chassym.derivation import (
    Body,
    CombinedPort,
    Linear,
    Mechanism,
    Model,
    Port,
    TravelPort,
    build_model,
    load_model,
    prismatic,
    revolute,
)
from chassym.linear import LinearModel, damped_modes, frequency_response, linearise, undamped_modes

Array = np.ndarray

AXLES = ("front", "rear")


def circular_frequencies(linear: LinearModel) -> Array:
    """Undamped natural frequencies (rad/s), ascending."""
    return 2 * np.pi * undamped_modes(linear).frequencies_hz


def poles(linear: LinearModel) -> Array:
    """Eigenvalues on the real axis and above it, sorted."""
    return np.sort_complex([mode.eigenvalue for mode in damped_modes(linear)])


def height(car: Mechanism, body: Body, x: float, y: float = 0.0) -> Port:
    """How far a point of a body rises above the design position."""
    name = f"{body.name} at {x:g}, {y:g}"
    return TravelPort(car.point(name, body, (x, y, 0)), car.ground, "z")


# Quarter cars


def quarter_car(
    masses: tuple[float, float], springs: tuple[float, float], dampers: tuple[float, float]
) -> Model:
    """Give the built-in quarter car, the body's before the wheel's, its damper's table on a straight line."""
    velocities = [-1.0, -0.15, 0.0, 0.1, 1.0]
    changes: dict[str, list[float] | float] = {
        "sprung.mass": masses[0],
        "unsprung.mass": masses[1],
        "spring.rate": springs[0],
        "tyre.stiffness": springs[1],
        "damper.velocity": velocities,
        "damper.force": [dampers[0] * velocity for velocity in velocities],
        "tyre.damping": dampers[1],
    }
    return load_model("quarter_car").with_parameters(changes)


def test_rear_corner_of_a_saloon_car() -> None:
    """D. C. Barton and J. D. Fieldhouse, Automotive Chassis Engineering, Springer, 2018, section 3.13.

    317.5 and 45.4 kg, 22 and 192 kN/m: 1.25 and 10.9 Hz; in the first mode the wheel moves 0.104 times as far
    as the body. The 7.87 and 68.73 rad/s, printed too, are the roots of w^4 - 4786 w^2 + 293000, whose middle
    coefficient is 4783 before the book's rounding: the model's are 7.88 and 68.71.
    """
    modes = undamped_modes(linearise(quarter_car((317.5, 45.4), (22e3, 192e3), (0.0, 0.0))))
    assert [float(f"{frequency:.3g}") for frequency in modes.frequencies_hz] == [1.25, 10.9]
    assert 2 * np.pi * modes.frequencies_hz == pytest.approx([7.87, 68.73], rel=2e-3)
    assert modes.shapes[1, 0] / modes.shapes[0, 0] == pytest.approx(0.104, abs=0.0005)


def test_corner_of_a_bus() -> None:
    """B. Messner and D. Tilbury, Control Tutorials for MATLAB and Simulink, Suspension: Root Locus.

    2500 and 320 kg, 80 and 500 kN/m, 350 and 15020 N s/m; the open-loop poles are printed to four decimals.
    """
    found = poles(linearise(quarter_car((2500, 320), (80e3, 500e3), (350, 15020))))
    np.testing.assert_allclose(found.real, [-23.9758, -0.1098], rtol=0, atol=5e-5)
    np.testing.assert_allclose(found.imag, [35.1869, 5.2504], rtol=0, atol=5e-5)


# Half cars


def test_bounce_and_pitch_of_an_automobile() -> None:
    """S. S. Rao, Mechanical Vibrations, example "Frequencies and Modes of an Automobile".

    1000 kg, radius of gyration 0.9 m, 18 kN/m 1.0 m ahead of the mass centre and 22 kN/m 1.5 m behind it:
    5.8593 and 9.4341 rad/s, with amplitudes bounce / pitch of -2.6461 and 0.3061 m; x points forward.
    """
    car = Mechanism("automobile", gravity=0)
    joint = prismatic("bounce", "z").then(revolute("pitch", "y"))
    inertia = (0, 1000 * 0.9**2, 0)
    body = car.add_body("body", car.ground, joint, (0, 0, 0), mass=1000, inertia=inertia)
    car.add_force_element("front", height(car, body, 1.0), Linear(18e3))
    car.add_force_element("rear", height(car, body, -1.5), Linear(22e3))
    linear = linearise(build_model(car, {}))
    assert circular_frequencies(linear) == pytest.approx([5.8593, 9.4341], abs=5e-5)
    bounce, pitch = undamped_modes(linear).shapes
    assert bounce / pitch == pytest.approx([-2.6461, 0.3061], abs=5e-5)


# An articulated vehicle

BODIES = ((5e3, 4e3), (30e3, 20e3), (20e3, 10e3))
"""Mass (kg) and pitch inertia (kg m^2)."""

HINGE, REACH = 2.0, 6.0
"""From the first body's mass centre back to the hinge, and from there to the second one's (m)."""

GROUPS = (
    (0, -1.0, 0.5e6, 750.0, 0.0, (0.0,)),
    (0, 3.0, 2e6, 1500.0, 200.0, (-1.0, 1.0)),
    (1, 2.0, 3e6, 2250.0, 300.0, (-1.2, 0.0, 1.2)),
    (2, -2.5, 1e6, 750.0, 0.0, (0.0,)),
    (2, 2.5, 1e6, 750.0, 0.0, (0.0,)),
)
"""The body on it, place behind its mass centre (m), spring (N/m), mass (kg), inertia (kg m^2), axles (m)."""

TYRES = (1.75e6, *(3.5e6,) * 7)
"""Stiffness (N/m) under every axle."""

ABAQUS = (1.4010, 1.5923, 1.9731, 4.8321, 7.3248, 8.8112, 12.351, 12.367, 12.661, 13.422, 29.174, 29.775)
"""Frequencies (Hz) printed by Abaqus."""


def articulated_vehicle() -> Mechanism:
    """Two bodies hinged to each other and a third one by itself, on five groups of one to three axles."""
    car = Mechanism("articulated_vehicle", gravity=0)
    places = (0.0, HINGE + REACH, 20.0)
    bodies: list[Body] = []
    for i, (x, (mass, inertia)) in enumerate(zip(places, BODIES, strict=True)):
        rise, turn = prismatic(f"bounce_{i}", "z"), revolute(f"pitch_{i}", "y")
        parent, joint, origin = (bodies[0], turn, HINGE) if i == 1 else (car.ground, rise.then(turn), x)
        centre, moments = (x, 0, 0), (0, inertia, 0)
        body = car.add_body(
            f"body_{i}", parent, joint, (origin, 0, 0), mass=mass, mass_centre=centre, inertia=moments
        )
        bodies.append(body)
    tyres = iter(TYRES)
    for j, (i, offset, stiffness, mass, inertia, axles) in enumerate(GROUPS):
        x, joint = places[i] + offset, prismatic(f"hop_{j}", "z")
        if inertia:
            joint = joint.then(revolute(f"tandem_{j}", "y"))
        moments = (0, inertia, 0)
        group = car.add_body(f"group_{j}", car.ground, joint, (x, 0, 0), mass=mass, inertia=moments)
        ends = height(car, group, x), height(car, bodies[i], x)
        travel = CombinedPort(tuple(zip(ends, (1, -1), strict=True)))
        car.add_force_element(f"suspension_{j}", travel, Linear(stiffness))
        for k, axle in enumerate(axles):
            name = f"group {j} axle {k}"
            tread = TravelPort(car.point(name, group, (x + axle, 0, 0)), car.ground, "z")
            car.add_force_element(f"tyre_{j}_{k}", tread, Linear(next(tyres)))
    return car


def test_articulated_vehicle_against_abaqus() -> None:
    """D. Cantero, VEqMon2D - Equations of motion generation tool of 2D vehicles with Matlab.

    SoftwareX 19, 2022, 101103. The vehicle 3A3_2_G_1_2_3_1_1 of the program's validation, 12 degrees of
    freedom, whose frequencies a separate model in Abaqus printed to five digits.
    """
    linear = linearise(build_model(articulated_vehicle(), {}))
    found = undamped_modes(linear).frequencies_hz
    assert tuple(float(f"{frequency:.5g}") for frequency in found) == ABAQUS


# The full car of 7 degrees of freedom

JAZAR = {"m": 840, "Ix": 820, "Iy": 1100, "mf": 53, "mr": 76, "a1": 1.4, "a2": 1.47, "b1": 0.7, "b2": 0.75}
JAZAR |= {"kf": 10e3, "kr": 13e3, "ktf": 200e3, "ktr": 200e3, "kR": 25e3}


def matrices_of_jazar(p: dict[str, float]) -> tuple[Array, Array]:
    """Give M and K in (x, roll, pitch, x1 .. x4), wheels front left, front right, rear right, rear left."""
    a1, a2, b1, b2, kf, kr = (p[name] for name in ("a1", "a2", "b1", "b2", "kf", "kr"))
    w, kR = b1 + b2, p["kR"]
    k12 = b1 * kf - b2 * kf - b1 * kr + b2 * kr
    k13 = 2 * a2 * kr - 2 * a1 * kf
    k22 = kR + b1**2 * kf + b2**2 * kf + b1**2 * kr + b2**2 * kr
    k23 = a1 * b2 * kf - a1 * b1 * kf - a2 * b1 * kr + a2 * b2 * kr
    k24, k25 = -b1 * kf - kR / w, b2 * kf + kR / w
    k33 = 2 * kf * a1**2 + 2 * kr * a2**2
    k44, k45 = kf + p["ktf"] + kR / w**2, -kR / w**2
    stiffness = [
        [2 * kf + 2 * kr, k12, k13, -kf, -kf, -kr, -kr],
        [k12, k22, k23, k24, k25, b1 * kr, -b2 * kr],
        [k13, k23, k33, a1 * kf, a1 * kf, -a2 * kr, -a2 * kr],
        [-kf, k24, a1 * kf, k44, k45, 0, 0],
        [-kf, k25, a1 * kf, k45, k44, 0, 0],
        [-kr, b1 * kr, -a2 * kr, 0, 0, kr + p["ktr"], 0],
        [-kr, -b2 * kr, -a2 * kr, 0, 0, 0, kr + p["ktr"]],
    ]
    mass = [p[name] for name in ("m", "Ix", "Iy", "mf", "mf", "mr", "mr")]
    return np.diag(mass), np.array(stiffness)


def full_car(
    p: dict[str, float], corners: Sequence[tuple[float, float]], body_in_bar: float = -1.0
) -> Mechanism:
    """Wheels at the corners, two front ones first; x forward, y to the left, z up; an anti-roll bar in front.

    The bar's deflection is the difference of the front wheels' heights and, times `body_in_bar`, of the
    body's above them.
    """
    car = Mechanism("full_car", gravity=9.81)
    joint = prismatic("x", "z").then(revolute("roll", "x")).then(revolute("pitch", "y"))
    inertia = (p["Ix"], p["Iy"], p["Iy"])
    body = car.add_body("body", car.ground, joint, (0, 0, 0), mass=p["m"], inertia=inertia)
    bar: list[tuple[Port, float]] = []
    for i, ((x, y), axle) in enumerate(zip(corners, "ffrr", strict=True), start=1):
        slide = prismatic(f"x{i}", "z")
        wheel = car.add_body(f"wheel_{i}", car.ground, slide, (x, y, 0), mass=p[f"m{axle}"])
        hub, seat = height(car, wheel, x, y), height(car, body, x, y)
        travel = CombinedPort(((hub, 1), (seat, -1)))
        car.add_force_element(f"suspension_{i}", travel, Linear(p[f"k{axle}"]), preloaded=True)
        car.add_force_element(f"tyre_{i}", hub, Linear(p[f"kt{axle}"]), preloaded=True)
        if axle == "f":
            side = 1.0 if y > 0 else -1.0
            bar += [(hub, side), (seat, side * body_in_bar)]
    track = corners[0][1] - corners[1][1]
    car.add_force_element("anti_roll_bar", CombinedPort(tuple(bar)), Linear(p["kR"] / track**2))
    return car


def full_car_of_jazar(p: dict[str, float]) -> Mechanism:
    """Numbered as in the book: front left, front right, rear right, rear left."""
    return full_car(p, [(p["a1"], p["b1"]), (p["a1"], -p["b2"]), (-p["a2"], -p["b1"]), (-p["a2"], p["b2"])])


@pytest.mark.parametrize("bar", [25e3, 0.0])
def test_full_car_of_jazar(bar: float) -> None:
    """R. N. Jazar, Vehicle Dynamics: Theory and Application, chapter "Vehicle Vibrations", full car.

    The book's example has the mass centre off the middle plane, the rear wheels' distances from it exchanged
    and an anti-roll bar in front. Proved are its matrices and their eigenvalues.
    """
    p = JAZAR | {"kR": bar}
    linear = linearise(build_model(full_car_of_jazar(p), {}))
    mass, stiffness = matrices_of_jazar(p)
    np.testing.assert_allclose(linear.mass, mass, rtol=1e-13)
    np.testing.assert_allclose(linear.stiffness, stiffness, rtol=1e-13, atol=1e-13 * stiffness.max())
    expected = np.sqrt(eigh(stiffness, mass, eigvals_only=True))
    np.testing.assert_allclose(circular_frequencies(linear), expected, rtol=1e-12)


def ride_model_of_jazar() -> Model:
    """Give the built-in ride model the book's numbers, with the half tracks at their mean."""
    p, w = JAZAR, JAZAR["b1"] + JAZAR["b2"]
    changes = {"body.mass": p["m"], "body.inertia.xx": p["Ix"], "body.inertia.yy": p["Iy"]}
    changes |= {"body.mass_centre.x": p["a1"], "axle.front.x": 0, "axle.rear.x": p["a1"] + p["a2"]}
    for axle in AXLES:
        changes |= {
            f"axle.{axle}.track": w,
            f"suspension.{axle}.spring.rate": p[f"k{axle[0]}"],
            f"suspension.{axle}.anti_roll_bar.rate": p["kR"] / w**2 if axle == "front" else 0,
            f"suspension.{axle}.unsprung.mass": p[f"m{axle[0]}"],
            f"tyre.{axle}.stiffness": p[f"kt{axle[0]}"],
        }
    return load_model("ride_model", {name: float(value) for name, value in changes.items()})


def test_ride_model_is_the_full_car_of_jazar_with_its_mass_centre_in_the_middle() -> None:
    mean = (JAZAR["b1"] + JAZAR["b2"]) / 2
    mass, stiffness = matrices_of_jazar(JAZAR | {"b1": mean, "b2": mean})
    expected = np.sqrt(eigh(stiffness, mass, eigvals_only=True))
    found = circular_frequencies(linearise(ride_model_of_jazar()))
    np.testing.assert_allclose(found, expected, rtol=1e-12)


SENSING_VEHICLE = {"m": 1040, "Ix": 1180, "Iy": 1580, "mf": 53, "mr": 76, "a": 1.5, "b": 0.9}
SENSING_VEHICLE |= {"kf": 10e3, "kr": 13e3, "ktf": 200e3, "ktr": 200e3, "kR": 25e3}
SENSING_VEHICLE_HZ = (
    *(1.0061430552, 1.1418316040, 1.2692971359),
    *(8.4273122483, 8.4314567807, 10.0211566850, 10.3800481352),
)

EXCITATION_VEHICLE = {"m": 20800, "Ix": 23600, "Iy": 31600, "mf": 1060, "mr": 1520, "a": 3, "b": 1.35}
EXCITATION_VEHICLE |= {"kf": 200e3, "kr": 260e3, "ktf": 4e6, "ktr": 4e6, "kR": 500e3}
EXCITATION_VEHICLE_HZ = (
    *(1.0190489607, 1.5061605300, 2.5016628867),
    *(8.4294490300, 8.4428541695, 10.0267543805, 10.1807148534),
)


@pytest.mark.parametrize(
    ("p", "published_hz"),
    [(SENSING_VEHICLE, SENSING_VEHICLE_HZ), (EXCITATION_VEHICLE, EXCITATION_VEHICLE_HZ)],
    ids=["sensing", "excitation"],
)
def test_vehicles_of_a_bridge_test(p: dict[str, float], published_hz: Sequence[float]) -> None:
    """X. Jian, Y. Xia and L. Sun, Mechanical Systems and Signal Processing 177 (2022) 109155, two vehicles.

    Their data, github.com/JxdEngineer/3D-Simulation-of-Vehicle-Bridge-Interaction, commit 6fbdc61,
    output.mat, hold the frequencies of both. In their stiffness matrix the bar feels the sum of the body's
    roll and the wheels'; with a bar that feels the difference, as a real one does, the modes that leave it
    alone (bounce and pitch, the wheels alike on both sides) have the same frequencies.
    """
    a, b = p["a"], p["b"]
    corners = [(a, b), (a, -b), (-a, b), (-a, -b)]
    found = circular_frequencies(linearise(build_model(full_car(p, corners, body_in_bar=1.0), {})))
    np.testing.assert_allclose(found / (2 * np.pi), published_hz, rtol=0, atol=5.001e-11)
    real = circular_frequencies(linearise(build_model(full_car(p, corners), {}))) / (2 * np.pi)
    unmoved = np.abs(real - published_hz) < 5.001e-11
    assert unmoved.sum() == 4


RACE_CAR = {
    "body.mass": 785.0,
    "body.mass_centre.x": 1.80,
    "body.inertia.xx": 300.0,
    "body.inertia.yy": 1350.0,
    "axle.front.x": 0.0,
    "axle.front.track": 1.75,
    "axle.rear.x": 3.50,
    "axle.rear.track": 1.85,
    "suspension.front.spring.rate": 67.5e3,
    "suspension.front.damper.coefficient": 1400.0,
    "suspension.front.anti_roll_bar.rate": 0.0,
    "suspension.front.unsprung.mass": 15.0,
    "suspension.rear.spring.rate": 100e3,
    "suspension.rear.damper.coefficient": 1800.0,
    "suspension.rear.anti_roll_bar.rate": 0.0,
    "suspension.rear.unsprung.mass": 17.5,
    "tyre.front.stiffness": 400e3,
    "tyre.front.damping": 0.0,
    "tyre.rear.stiffness": 400e3,
    "tyre.rear.damping": 0.0,
}

RACE_CAR_MODES = (
    (2.949616, 0.153854, -2.851383, 18.312323),
    (4.065413, 0.193339, -4.938605, 25.061783),
    (4.446342, 0.214994, -6.006335, 27.283887),
    (26.546949, 0.321600, -53.642762, 157.938259),
    (26.550953, 0.320707, -53.501855, 158.012607),
    (27.799646, 0.274530, -47.952255, 167.959236),
    (27.928210, 0.269513, -47.293714, 168.984837),
)
"""Frequency (Hz), damping ratio and pole (rad/s), as printed."""


def test_race_car_of_seven_degrees_of_freedom() -> None:
    """C. Nimsara, 7-DOF Active Suspension Modelling and Control for a Race Vehicle, MATLAB program.

    github.com/ChamikaNimsara/7DOF_Active_Suspension_RaceCar, commit 456406f: Results/LQR/
    lqr_state_space_validation.txt prints the modes of the passive car, without control, to six decimals. Its
    state matrix leaves out the anti-roll bars that its list of parameters has, and its tyres have no damping.
    """
    modes = damped_modes(linearise(load_model("ride_model", RACE_CAR)))
    found = [
        (mode.frequency_hz, mode.damping_ratio, mode.eigenvalue.real, mode.eigenvalue.imag)
        for mode in sorted(modes, key=lambda mode: mode.frequency_hz)
    ]
    np.testing.assert_allclose(found, RACE_CAR_MODES, rtol=0, atol=5.001e-7)


# Cars that fall apart into quarter cars


def quartic(mass: float, unsprung: float, k: float, c: float, kt: float, ct: float) -> Array:
    """Poles of a quarter car on the real axis and above it."""
    coefficients = [
        mass * unsprung,
        mass * (c + ct) + unsprung * c,
        mass * (k + kt) + unsprung * k + c * ct,
        c * kt + k * ct,
        k * kt,
    ]
    roots = np.roots(coefficients)
    return roots[roots.imag >= 0]


def axle_values(model: Model, axle: str) -> tuple[float, float, float, float, float]:
    """Unsprung mass, spring, damper, tyre's stiffness and damping of one wheel."""
    value, own, tyre = model.values, f"suspension.{axle}", f"tyre.{axle}"
    mass = f"{own}.unsprung.mass" if model.system.name == "ride_model" else f"axle.{axle}.mass"
    return (
        value[mass],
        value[f"{own}.spring.rate"],
        value[f"{own}.damper.coefficient"],
        value[f"{tyre}.stiffness"],
        value[f"{tyre}.damping"],
    )


def with_equal_axles(model: Model) -> Model:
    """Give both axles what the front one has, at the same distance from the mass centre."""
    front = {name: parameter.value for name, parameter in model.parameters.items() if ".front." in name}
    same = {name.replace(".front.", ".rear."): value for name, value in front.items()}
    return model.with_parameters(
        {**same, "axle.front.x": -1.35, "axle.rear.x": 1.35, "body.mass_centre.x": 0.0}
    )


@pytest.mark.parametrize("damper", [900.0, 9000.0])
def test_equal_axles_make_heave_pitch_and_roll_quarter_cars_of_their_own(damper: float) -> None:
    """All 14 poles in closed form. By symmetry no corner's motion mixes these patterns:

    heave (+ + + +) on m / 4, pitch (+ + - -) on I_yy / 4 a^2, roll (+ - + -) on I_xx / 4 b^2 with 2 k_bar
    more stiffness, and the warp (+ - - +) of the wheels alone, m_w s^2 + (c + c_t) s + k + 2 k_bar + k_t = 0.
    """
    model = with_equal_axles(load_model("ride_model", {"suspension.front.damper.coefficient": damper}))
    p = model.values
    unsprung, k, c, kt, ct = axle_values(model, "front")
    stiffer = k + 2 * p["suspension.front.anti_roll_bar.rate"]
    pitch = p["body.inertia.yy"] / (4 * 1.35**2)
    roll = p["body.inertia.xx"] / p["axle.front.track"] ** 2
    warp = np.roots([unsprung, c + ct, stiffer + kt])
    expected = [
        quartic(p["body.mass"] / 4, unsprung, k, c, kt, ct),
        quartic(pitch, unsprung, k, c, kt, ct),
        quartic(roll, unsprung, stiffer, c, kt, ct),
        warp[warp.imag >= 0],
    ]
    np.testing.assert_allclose(poles(linearise(model)), np.sort_complex(np.concatenate(expected)), rtol=1e-12)


def with_dynamic_index_of_one(name: str) -> tuple[Model, dict[str, float]]:
    """Give the model, and the mass that every wheel carries by its axle."""
    model = load_model(name)
    p = model.values
    ahead, behind = (abs(p[f"axle.{axle}.x"] - p["body.mass_centre.x"]) for axle in AXLES)
    changes = {"body.inertia.yy": p["body.mass"] * ahead * behind}
    if name == "half_car":  # its wheels slide along the body's axis: level with the mass centre
        changes["body.mass_centre.z"] = 0.0
    whole = p["body.mass"] / (ahead + behind) / (2 if name == "ride_model" else 1)
    return model.with_parameters(changes), {"front": whole * behind, "rear": whole * ahead}


@pytest.mark.parametrize("name", ["ride_model", "half_car"])
def test_dynamic_index_of_one_makes_the_ends_quarter_cars(name: str) -> None:
    """With I_yy = m a_1 a_2 each end of the car is a quarter car of the mass that it carries.

    T. D. Gillespie, Fundamentals of Vehicle Dynamics, 1992, chapter 5, "Bounce/Pitch Frequencies": the
    oscillation centres are then at the axles.
    """
    model, carried = with_dynamic_index_of_one(name)
    found = poles(linearise(model))
    for axle in AXLES:
        for pole in quartic(carried[axle], *axle_values(model, axle)):
            assert np.abs(found / pole - 1).min() < 1e-12


@pytest.mark.parametrize("name", ["ride_model", "half_car"])
def test_dynamic_index_of_one_leaves_the_rear_at_rest_on_a_bump_in_front(name: str) -> None:
    linear = linearise(with_dynamic_index_of_one(name)[0])
    response = frequency_response(linear, np.geomspace(0.1, 50, 40))
    bump = {road: 1.0 for road in linear.inputs if road.startswith("front")}
    travels = [output for output in linear.outputs if output.endswith("wheel_travel")]
    assert len(travels) == 2 * len(bump)
    for output in travels:
        largest = np.abs(response.combined(output, bump)).max()
        assert largest > 1 if output.startswith("front") else largest < 1e-13

"""The built-in vehicles: classical matrices, the rigid limit, a body in n sections, what all of them do."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np
import pytest
import sympy

from chassym.derivation import (
    CompiledEquations,
    Mechanism,
    Model,
    ParameterError,
    Parameters,
    load_model,
    vehicle_names,
)
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.vehicles.body_sections import SectionedBody
from chassym.derivation.vehicles.full_car import add_body_sections, full_car
from chassym.linear import LinearModel, damped_modes, linearise, undamped_modes

from .variants import scaled_at_random

PLACES = ("front", "middle", "rear")
AXLES = ("front", "rear")
WHEELS = ("axle", "suspension", "tyre")
BODY = 6
"""Degrees of freedom of a free body; the torsion coordinates follow."""


def random_arguments(model: Model, samples: int, seed: int = 0) -> np.ndarray:
    """Draw positions of 0.05, rates of 0.3, accelerations of 3, in SI, and pads like positions and rates."""
    size, inputs = model.size, len(model.system.inputs)
    scales = np.repeat([0.05, 0.3, 3.0, 0.02, 0.2], [size, size, size, inputs, inputs])
    return scales[:, None] * np.random.default_rng(seed).uniform(-1, 1, (model.argument_count, samples))


# Every vehicle


@cache
def linear_model(name: str) -> LinearModel:
    return linearise(load_model(name))


@pytest.mark.parametrize("name", vehicle_names())
def test_every_vehicle_stands_moves_and_is_described(name: str) -> None:
    model = load_model(name)
    assert model.parameters.description.strip()
    forces = np.abs([*model.preloads.values(), 1.0]).max()
    assert np.abs(model.design_residual).max() < 1e-9 * forces
    arguments = random_arguments(model, 5)
    for function in (model.residual, model.accelerations, model.outputs):
        assert np.isfinite(function(arguments)).all()


@pytest.mark.parametrize("name", vehicle_names())
def test_every_vehicle_is_stable_about_the_design_position(name: str) -> None:
    linear = linear_model(name)
    assert linear.mass == pytest.approx(linear.mass.T, rel=1e-12)
    assert np.linalg.eigvalsh(linear.mass).min() > 0
    assert all(mode.eigenvalue.real <= 1e-9 * abs(mode.eigenvalue) for mode in damped_modes(linear))


@pytest.mark.parametrize("name", vehicle_names())
def test_a_road_that_rises_everywhere_lifts_the_vehicle_as_it_is(name: str) -> None:
    linear = linear_model(name)
    vertical = [i for i, u in enumerate(linear.inputs) if u.endswith(("pad_z", "road"))]
    if not vertical:
        pytest.skip("no road")
    rise = np.linalg.solve(linear.stiffness, linear.input_stiffness[:, vertical].sum(axis=1))
    level = {"z", "bounce", "body_bounce", "wheel_bounce"}
    expected = [float(c in level or c.endswith("_wheel_bounce")) for c in linear.coordinates]
    assert rise == pytest.approx(expected, abs=1e-9)


# Classical matrices


def blocks(count: int, entries: dict[tuple[int, int], float]) -> np.ndarray:
    """Fill a symmetric matrix from its upper triangle."""
    matrix = np.zeros((count, count))
    for (i, j), value in entries.items():
        matrix[i, j] = matrix[j, i] = value
    return matrix


def half_car_in_roll(p: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give M, C, K in (z, roll, z_left, z_right).

    Jazar, Vehicle Dynamics: Theory and Application, chapter "Vehicle Vibrations", half car, with equal sides,
    b the half track and k_R the torsion spring of the anti-roll bar against (z_right - z_left) / 2 b.
    """
    b = p["axle.track"] / 2
    k, c = p["suspension.spring.rate"], p["suspension.damper.coefficient"]
    k_t, c_t, m_w = p["tyre.stiffness"], p["tyre.damping"], p["suspension.unsprung.mass"]
    k_R = p["suspension.anti_roll_bar.rate"] * 4 * b**2
    w = 2 * b

    def of(k: float, k_t: float, k_R: float) -> np.ndarray:
        return np.array(
            [
                [2 * k, 0, -k, -k],
                [0, 2 * k * b**2 + k_R, k * b + k_R / w, -k * b - k_R / w],
                [-k, k * b + k_R / w, k + k_t + k_R / w**2, -k_R / w**2],
                [-k, -k * b - k_R / w, -k_R / w**2, k + k_t + k_R / w**2],
            ]
        )

    return np.diag([p["body.mass"], p["body.inertia.xx"], m_w, m_w]), of(c, c_t, 0), of(k, k_t, k_R)


def ride_model(p: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give M, C, K in (z, pitch, roll, z_1 .. z_4), wheels front left, front right, rear left, rear right.

    Jazar, Vehicle Dynamics: Theory and Application, chapter "Vehicle Vibrations", full car: a1, a2 are the
    axles' distances from the mass centre, b_f, b_r half the tracks, and every axle has an anti-roll bar.
    """
    a1 = p["body.mass_centre.x"] - p["axle.front.x"]
    a2 = p["axle.rear.x"] - p["body.mass_centre.x"]
    bf, br = (p[f"axle.{axle}.track"] / 2 for axle in AXLES)
    mf, mr = (p[f"suspension.{axle}.unsprung.mass"] for axle in AXLES)
    springs = [p[f"suspension.{axle}.spring.rate"] for axle in AXLES]
    dampers = [p[f"suspension.{axle}.damper.coefficient"] for axle in AXLES]
    tyres = [[p[f"tyre.{axle}.{what}"] for axle in AXLES] for what in ("stiffness", "damping")]
    bars = [p[f"suspension.{axle}.anti_roll_bar.rate"] for axle in AXLES]

    def of(suspension: list[float], tyre: list[float], bar: list[float]) -> np.ndarray:
        (kf, kr), (tf, tr), (sf, sr) = suspension, tyre, bar
        entries = {(0, 0): 2 * (kf + kr), (0, 1): 2 * (kf * a1 - kr * a2)}
        entries |= {(0, 3): -kf, (0, 4): -kf, (0, 5): -kr, (0, 6): -kr}
        entries |= {(1, 1): 2 * (kf * a1**2 + kr * a2**2)}
        entries |= {(1, 3): -kf * a1, (1, 4): -kf * a1, (1, 5): kr * a2, (1, 6): kr * a2}
        entries |= {(2, 2): 2 * kf * bf**2 + 2 * kr * br**2 + 4 * sf * bf**2 + 4 * sr * br**2}
        entries |= {(2, 3): kf * bf + 2 * sf * bf, (2, 4): -kf * bf - 2 * sf * bf}
        entries |= {(2, 5): kr * br + 2 * sr * br, (2, 6): -kr * br - 2 * sr * br}
        entries |= {(3, 3): kf + tf + sf, (4, 4): kf + tf + sf, (3, 4): -sf}
        entries |= {(5, 5): kr + tr + sr, (6, 6): kr + tr + sr, (5, 6): -sr}
        return blocks(7, entries)

    mass = np.diag([p["body.mass"], p["body.inertia.yy"], p["body.inertia.xx"], mf, mf, mr, mr])
    return mass, of(dampers, tyres[1], [0.0, 0.0]), of(springs, tyres[0], bars)


@pytest.mark.parametrize("seed", [None, 0, 1])
@pytest.mark.parametrize(
    ("name", "classical"), [("half_car_roll", half_car_in_roll), ("ride_model", ride_model)]
)
def test_classical_matrices(name: str, classical: object, seed: int | None) -> None:
    model = load_model(name) if seed is None else scaled_at_random(load_model(name), seed)
    linear = linearise(model)
    expected = classical(model.values)  # type: ignore[operator]
    for matrix, by_hand in zip((linear.mass, linear.damping, linear.stiffness), expected, strict=True):
        assert matrix == pytest.approx(by_hand, rel=1e-12, abs=1e-12 * np.abs(by_hand).max())


@pytest.mark.parametrize("name", ["half_car_roll", "ride_model"])
def test_classical_mass_matrix_is_diagonal_and_the_same_at_any_angle(name: str) -> None:
    equations = load_model(name).equations
    matrix = sympy.Matrix([equations.program.expand(row) for row in equations.mass_matrix])
    assert matrix.is_diagonal()
    assert not matrix.free_symbols & set(equations.arguments)


def test_ride_model_of_equal_axles_rolls_like_the_half_car() -> None:
    """Two half cars side by side: the same four frequencies of bounce, roll and hops are in both."""
    half = load_model("half_car_roll")
    p = half.parameters
    grouped = [(*name.split(".", 1), p.value(name)) for name in p if name.split(".")[0] in WHEELS]
    axles = {f"{group}.{axle}.{rest}": value for group, rest, value in grouped for axle in AXLES}
    body = {f"body.{rest}": 2 * half.values[f"body.{rest}"] for rest in ("mass", "inertia.xx")}
    places = {"axle.front.x": -1.3, "axle.rear.x": 1.3, "body.mass_centre.x": 0.0}
    whole = load_model("ride_model").with_parameters({**axles, **body, **places})
    found = undamped_modes(linearise(whole)).frequencies_hz
    for frequency in undamped_modes(linearise(half)).frequencies_hz:
        assert np.abs(found / frequency - 1).min() < 1e-12


# The rigid body as a limit


def welded(car: Model, like: Model) -> Model:
    """Give the rigid car whose body is that of a full car with its sections welded."""
    p = car.parameters
    m = np.array([p.value(f"body.{place}.mass") for place in PLACES])
    r = np.array([[p.value(f"body.{place}.mass_centre.{axis}") for axis in "xz"] for place in PLACES])
    own = np.array([[p.value(f"body.{q}.inertia.{a}") for a in ("xx", "yy", "zz")] for q in PLACES])
    centre = m @ r / m.sum()
    x, z = (r - centre).T
    inertia = own.sum(axis=0) + [m @ z**2, m @ (x**2 + z**2), m @ x**2]
    body = {"body.mass": m.sum(), "body.mass_centre.x": centre[0], "body.mass_centre.z": centre[1]}
    body |= {f"body.inertia.{a}": value for a, value in zip(("xx", "yy", "zz"), inertia, strict=True)}
    body |= {"body.inertia.xz": -m @ (x * z)}
    body |= {f"sensor.{axis}": p.value(f"body.middle.mass_centre.{axis}") for axis in "xz"}
    shared = {name: p.value(name) for name in p if name in like.parameters}
    return like.with_parameters({**shared, **{name: float(value) for name, value in body.items()}})


def without_twist(car: Model, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Draw arguments of a full car without twist, and the rows of them that a rigid car has, too."""
    twists = car.size - BODY - 4
    arguments = random_arguments(car, 20, seed)
    rows = [BODY + i + block * car.size for block in range(3) for i in range(twists)]
    arguments[rows] = 0
    return arguments, np.delete(np.arange(car.argument_count), rows)


@pytest.fixture(scope="module")
def rigid_sedan(cache_directory: str) -> Model:
    return load_model("rigid_sedan")


def test_rigid_sedan_is_the_sedan_with_its_sections_welded(sedan: Model, rigid_sedan: Model) -> None:
    expected = welded(sedan, rigid_sedan).parameters.flat()
    assert rigid_sedan.parameters.flat() == pytest.approx(expected, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("sections", [3, 6, 7])
@pytest.mark.parametrize("seed", [None, 0, 1])
def test_without_twist_any_number_of_sections_is_the_rigid_car(
    rigid_sedan: Model, sections: int, seed: int | None
) -> None:
    """d'Alembert's principle with the twists held: mass, mass centre and inertia tensor are kept."""
    car = load_model("sedan", sections=sections)
    car = car if seed is None else scaled_at_random(car, seed)
    rigid = welded(car, rigid_sedan)
    arguments, kept = without_twist(car, seed=5)
    free = [i for i in range(car.size) if not BODY <= i < car.size - 4]
    given = Model(car.parameters, car.compiled, rigid.preloads)
    found, expected = given.residual(arguments)[free], rigid.residual(arguments[kept])
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-11 * np.abs(expected).max())


STIFFNESSES = 10.0 ** np.arange(8, 13)


def stiff(car: Model, stiffness: float) -> Model:
    return car.with_parameters({f"body.{axle}.torsional_stiffness": stiffness for axle in AXLES})


def test_rigid_modes_are_the_limit_of_a_stiff_body(sedan: Model, rigid_sedan: Model) -> None:
    """Frequencies and damping ratios converge as 1 / stiffness; those of motions without twist are equal."""

    def modes(model: Model) -> np.ndarray:
        found = [(mode.frequency_hz, mode.damping_ratio) for mode in damped_modes(linearise(model))]
        return np.array([each for each in found if each[0] < 20])

    limit = modes(rigid_sedan)
    errors = np.array([np.abs(modes(stiff(sedan, k)) / limit - 1) for k in STIFFNESSES])
    assert errors.shape[1:] == (10, 2)
    for mode, quantity in itertools.product(range(10), range(2)):
        error = errors[:, mode, quantity]
        if error[0] > 1e-8:
            exponent = np.polyfit(np.log10(STIFFNESSES[1:4]), np.log10(error[1:4]), 1)[0]
            assert exponent == pytest.approx(-1, abs=2e-3)
            assert error[-1] < 2e-7
        else:
            assert error.max() < 1e-8  # symmetric motions: rounding only, which grows with the stiffness
    assert (errors[0, :, 0] > 1e-8).sum() == 5


def test_accelerations_of_a_stiff_body_are_those_of_the_rigid_one(sedan: Model, rigid_sedan: Model) -> None:
    """The twists are those at which the springs pass on what holds the sections together."""
    arguments, kept = without_twist(sedan, seed=3)
    arguments = arguments[:, :1]
    expected = rigid_sedan.accelerations(arguments[kept])[:, 0]
    twist, free = [6, 7], [i for i in range(12) if i not in (6, 7)]
    errors = []
    for stiffness in STIFFNESSES:
        car, torques = stiff(sedan, stiffness), np.zeros(2)
        for _ in range(4):
            trials = np.repeat(arguments, 3, axis=1)
            trials[twist] = (torques[:, None] + np.hstack([np.zeros((2, 1)), 1e3 * np.eye(2)])) / stiffness
            found = car.accelerations(trials)
            slopes = (found[twist, 1:] - found[twist, :1]) / 1e3
            torques = torques - np.linalg.solve(slopes, found[twist, 0])
        errors.append(np.abs(found[free, 0] - expected).max())
    exponent = np.polyfit(np.log10(STIFFNESSES[:3]), np.log10(errors[:3]), 1)[0]
    assert exponent == pytest.approx(-1, abs=2e-3)
    assert errors[-1] < 1e-6 * np.abs(expected).max()


# A body in n sections


def body_alone(parameters: Parameters, sections: int) -> Model:
    """Give the sections without arms and wheels, free in space."""
    body = Mechanism("body", gravity=0)
    add_body_sections(body, ParameterSymbols(parameters), sections)
    return Model(parameters, CompiledEquations(body))


def numbers(model: Model, sections: int) -> tuple[SectionedBody, dict[sympy.Symbol, float]]:
    values = {sympy.Symbol(name, real=True): value for name, value in model.parameters.flat().items()}
    return SectionedBody(ParameterSymbols(model.parameters), sections), values


def inertias(model: Model, sections: int) -> np.ndarray:
    body, values = numbers(model, sections)
    return np.array([sympy.Matrix(s.inertia).xreplace(values).tolist() for s in body.sections()], dtype=float)


def torsion_springs(model: Model, sections: int) -> np.ndarray:
    """Give stiffness and damping of every spring, shape (sections - 1, 2)."""
    body, values = numbers(model, sections)
    laws = [(spring.stiffness, spring.damping) for spring in body.springs()]
    return np.array([[float(each.xreplace(values)) for each in law] for law in laws])


def stiffnesses(model: Model, sections: int) -> np.ndarray:
    return torsion_springs(model, sections)[:, 0]


def test_three_sections_are_the_parameters_themselves(sedan: Model) -> None:
    symbols = ParameterSymbols(sedan.parameters)
    body = SectionedBody(symbols, 3)
    for place, section in zip(PLACES, body.sections(), strict=True):
        own = f"body.{place}"
        moments = [symbols(f"{own}.inertia.{a}") for a in ("xx", "yy", "zz")]
        assert section.mass == symbols(f"{own}.mass")
        assert section.mass_centre == symbols.vector(f"{own}.mass_centre", "xz")
        assert sympy.Matrix(section.inertia) == sympy.diag(*moments)
    for axle, spring in zip(AXLES, body.springs(), strict=True):
        own = f"body.{axle}"
        stiffness, time = (
            symbols(f"{own}.{each}") for each in ("torsional_stiffness", "stiffness_proportional_damping")
        )
        assert (spring.stiffness, spring.damping) == (stiffness, stiffness * time)
    front, middle, rear = (section.axis_height for section in body.sections())
    assert (front, rear) == tuple(symbols(f"body.{axle}.torsion_axis.z") for axle in AXLES)
    assert middle == (front + rear) / 2


def test_full_car_has_three_sections_unless_told_otherwise(sedan: Model) -> None:
    by_default = full_car(sedan.parameters)
    assert [c.name for c in by_default.coordinates] == [
        c.name for c in full_car(sedan.parameters, 3).coordinates
    ]
    assert [c.name for c in by_default.coordinates[:8]] == [
        *("x", "y", "z", "yaw", "pitch", "roll"),
        *("front_torsion", "rear_torsion"),
    ]


@pytest.mark.parametrize(
    ("sections", "twists"),
    [(4, ["front", "section_2", "rear"]), (5, ["front", "section_2", "section_4", "rear"])],
)
def test_coordinates_are_twists_against_the_free_section(
    sedan: Model, sections: int, twists: list[str]
) -> None:
    names = [c.name for c in full_car(sedan.parameters, sections).coordinates]
    assert names[BODY:-4] == [f"{twist}_torsion" for twist in twists]


@pytest.mark.parametrize("sections", [3, 6, 12, pytest.param(24, marks=pytest.mark.slow)])
def test_first_torsion_of_the_free_body_is_kept(sedan: Model, sections: int) -> None:
    """Equal inertias, w^2 = 3 k / J, in the body's mechanism and as a chain by hand."""
    expected = math.sqrt(5e6 / 126) / (2 * math.pi)
    found = undamped_modes(linearise(body_alone(sedan.parameters, sections))).frequencies_hz
    assert found[:6] == pytest.approx(np.zeros(6), abs=1e-3)
    assert found[6] == pytest.approx(expected, rel=1e-9)
    k, roll = stiffnesses(sedan, sections), inertias(sedan, sections)[:, 0, 0]
    assert roll == pytest.approx(378 / sections, rel=1e-12)
    difference = np.diff(np.eye(sections), axis=0)
    squares = np.linalg.eigvalsh(difference.T @ np.diag(k) @ difference / roll[0])
    assert math.sqrt(squares[1]) / (2 * math.pi) == pytest.approx(expected, rel=1e-9)


def test_higher_torsions_converge_with_the_square_of_the_sections(sedan: Model) -> None:
    """To those of a uniform shaft whose first one is 31.70 Hz: the second is twice, the third thrice that."""
    first = math.sqrt(5e6 / 126) / (2 * math.pi)
    for order in (2, 3):
        errors = []
        for sections in (12, 24, 48):
            k, roll = stiffnesses(sedan, sections), inertias(sedan, sections)[:, 0, 0]
            difference = np.diff(np.eye(sections), axis=0)
            squares = np.linalg.eigvalsh(difference.T @ np.diag(k) @ difference / roll[0])
            errors.append(abs(math.sqrt(squares[order]) / (2 * math.pi) - order * first))
        assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([2, 2], abs=0.05)


@pytest.mark.parametrize("sections", [4, 7, 12])
@pytest.mark.parametrize("seed", [0, 1])
def test_springs_share_the_compliance_of_the_body_and_its_loss(
    sedan: Model, sections: int, seed: int
) -> None:
    """In series they are slowly twisted like the two springs: sums of 1 / k and of c / k^2, up to alpha."""
    car = scaled_at_random(sedan, seed)
    n, found = sections, torsion_springs(car, sections)
    k, time = (
        np.array([car.values[f"body.{axle}.{name}"] for axle in AXLES])
        for name in ("torsional_stiffness", "stiffness_proportional_damping")
    )
    alpha = 3 / (2 * n * (n - 1) * math.sin(math.pi / (2 * n)) ** 2)
    assert (1 / found[:, 0]).sum() == pytest.approx((1 / k).sum() / alpha, rel=1e-12)
    assert (found[:, 1] / found[:, 0] ** 2).sum() == pytest.approx((time / k).sum() / alpha, rel=1e-12)


@pytest.mark.parametrize("sections", [5, 6])
def test_a_body_turned_round_has_its_sections_turned_round(sedan: Model, sections: int) -> None:
    """What belongs to the front and to the rear is exchanged; the mass centres are mirrored."""
    car = scaled_at_random(sedan, 4)
    body = {name: parameter.value for name, parameter in car.parameters.items() if name.startswith("body.")}
    names = {"front": "rear", "rear": "front", "middle": "middle"}
    turned = {
        f"body.{names[place]}.{rest}": -value if rest == "mass_centre.x" else value
        for name, value in body.items()
        for _, place, rest in [name.split(".", 2)]
    }
    mirrored = car.with_parameters(turned)
    mirror = np.array([[1, 1, -1], [1, 1, 1], [-1, 1, 1]])
    assert stiffnesses(mirrored, sections)[::-1] == pytest.approx(stiffnesses(car, sections), rel=1e-12)
    expected = inertias(car, sections) * mirror
    assert inertias(mirrored, sections)[::-1] == pytest.approx(expected, rel=1e-10, abs=1e-10)


def test_twists_of_different_sections_are_not_coupled_by_mass(sedan: Model) -> None:
    """So the mass matrix keeps the pattern of an arrow and its factorisation has no fill-in."""
    matrix = load_model("sedan", sections=6).equations.mass_matrix
    for i, j in itertools.permutations(range(BODY, BODY + 5), 2):
        assert matrix[i][j] == 0


@pytest.mark.parametrize("sections", [12, 48])
def test_sections_have_inertias_of_bodies(sedan: Model, sections: int) -> None:
    """Positive, none greater than the sum of the other two."""
    moments = np.linalg.eigvalsh(inertias(sedan, sections))
    assert moments.min() == pytest.approx(378 / sections, rel=1e-9)
    assert (moments[:, 2] <= moments[:, 0] + moments[:, 1]).all()


@pytest.mark.parametrize("stiffness", [1e2, 5e6])
def test_an_odd_number_of_sections_may_have_a_loose_half(sedan: Model, stiffness: float) -> None:
    loose = sedan.with_parameters(
        {"body.front.torsional_stiffness": 0.0, "body.rear.torsional_stiffness": stiffness}
    )
    found = stiffnesses(loose, 5)
    assert (found[:2] == 0).all() and (found[2:] > 0).all()


@pytest.mark.parametrize("sections", [2, 0, -3, 3.0, True, "12", 1001])
def test_an_impossible_number_of_sections_is_refused(sections: object) -> None:
    with pytest.raises(ParameterError, match=r"^sections: received .*, expected a whole number from 3"):
        load_model("sedan", sections=sections)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", [name for name in vehicle_names() if name != "sedan"])
def test_sections_of_another_model_are_refused(name: str) -> None:
    with pytest.raises(ParameterError, match=r"^sections: received 3 for a vehicle of model .*'full_car'$"):
        load_model(name, sections=3)


def test_loaded_sections_are_those_of_the_car() -> None:
    model = load_model("sedan", {"body.front.mass": 480.0}, sections=5)
    linear: LinearModel = linearise(model)
    assert model.size == 14
    assert linear.coordinates[BODY:-4] == tuple(
        f"{name}_torsion" for name in ("front", "section_2", "section_4", "rear")
    )

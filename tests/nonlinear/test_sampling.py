"""Points of sweeps: every combination once, strata filled once, groups scaled whole, names refused."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from chassym.derivation import Model, ParameterError
from chassym.nonlinear.sweep.sampling import (
    NOMINAL,
    Points,
    SamplingError,
    grid,
    joined,
    latin_hypercube,
    one_at_a_time,
    random_sample,
    table,
    unit_of,
)

AXES = st.lists(st.floats(1, 1e6), min_size=1, max_size=5)
SHARED = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=40)


@SHARED
@given(masses=AXES, frequencies=AXES)
def test_a_grid_holds_every_combination_once(
    quarter_car: Model, masses: list[float], frequencies: list[float]
) -> None:
    points = grid(quarter_car, {"sprung.mass": masses, "frequency_hz": frequencies})
    found = [tuple(points.settings(number).values()) for number in range(len(points))]
    assert found == [(mass, frequency) for mass in masses for frequency in frequencies]
    assert points.to_xarray().sizes == {"sprung.mass": len(masses), "frequency_hz": len(frequencies)}


@SHARED
@given(
    count=st.integers(1, 60), low=st.floats(-1e3, 1e3), width=st.floats(1e-2, 1e3), seed=st.integers(0, 99)
)
def test_a_latin_hypercube_has_one_point_in_every_part_of_every_range(
    quarter_car: Model, count: int, low: float, width: float, seed: int
) -> None:
    ranges = {"sprung.mass": (low, low + width), "frequency_hz": (1.0, 2.0)}
    points = latin_hypercube(quarter_car, count, ranges, seed=seed)
    for name, (start, end) in ranges.items():
        parts = np.floor((points.numbers[name] - start) / (end - start) * count * (1 - 1e-12) + 1e-9)
        assert sorted(np.clip(parts, 0, count - 1)) == [*range(count)]


def test_logarithmic_ranges_have_as_many_points_in_every_decade(quarter_car: Model) -> None:
    points = latin_hypercube(quarter_car, 70, {"tyre.stiffness": (1e2, 1e9)}, logarithmic=["tyre.stiffness"])
    decades = np.floor(np.log10(points.numbers["tyre.stiffness"]))
    assert [int((decades == decade).sum()) for decade in range(2, 9)] == [10] * 7


@SHARED
@given(count=st.integers(1, 200), seed=st.integers(0, 99))
def test_random_points_lie_in_their_ranges_and_repeat_with_their_seed(
    quarter_car: Model, count: int, seed: int
) -> None:
    def sample(seed: int) -> np.ndarray:
        points = random_sample(quarter_car, count, {"sprung.mass": (3.0, 4.0)}, seed=seed)
        return points.numbers["sprung.mass"]

    assert np.all((sample(seed) >= 3) & (sample(seed) <= 4))
    np.testing.assert_array_equal(sample(seed), sample(seed))
    assert not np.array_equal(sample(seed), sample(seed + 1))


def test_one_at_a_time_changes_every_parameter_that_is_not_zero_and_nothing_else(sedan: Model) -> None:
    points = one_at_a_time(sedan, 0.25)
    nominal = sedan.parameters.flat()
    varied, factors = (points.coordinates[name].values for name in ("varied", "factor"))
    assert points.settings(0) == {} and varied[0] == NOMINAL and factors[0] == 1
    expected = {n for n, p in sedan.parameters.items() if np.any(p.value)}
    assert set(varied[1:]) == expected and len(points) == 1 + 2 * len(expected)
    for number in range(1, len(points)):
        for name, value in points.settings(number).items():
            assert name.partition("[")[0] == varied[number]
            assert value == pytest.approx(factors[number] * nominal[name])


def test_a_group_is_multiplied_and_a_parameter_is_set(sedan: Model) -> None:
    points = grid(sedan, {"tyre.front.stiffness": [0.5, 2.0], "body.front.mass": [400.0]})
    nominal = sedan.parameters.flat()
    assert points.settings(1) == {
        f"tyre.front.stiffness.{axis}": 2 * nominal[f"tyre.front.stiffness.{axis}"] for axis in "xyz"
    } | {"body.front.mass": 400.0}
    assert points.coordinates["tyre.front.stiffness"].unit == "1"
    assert points.coordinates["body.front.mass"].unit == "kg"


def test_a_whole_list_is_multiplied_and_one_entry_is_set(sedan: Model) -> None:
    force = "suspension.front.damper.force"
    nominal = sedan.parameters.value(force)
    assert isinstance(nominal, tuple)
    whole = grid(sedan, {force: [2.0]}).settings(0)
    assert whole == {f"{force}[{i}]": 2 * value for i, value in enumerate(nominal) if value}
    assert grid(sedan, {f"{force}[1]": [-500.0]}).settings(0) == {f"{force}[1]": -500.0}


def test_what_is_joined_by_plus_is_set_together(sedan: Model) -> None:
    both = "body.front.torsional_stiffness+body.rear.torsional_stiffness"
    points = grid(sedan, {both: [1e5, 1e6]})
    assert [set(points.settings(n).values()) for n in (0, 1)] == [{1e5}, {1e6}]
    assert len(points.settings(0)) == 2 and unit_of(sedan, both) == "N*m/rad"


def test_joined_points_leave_open_what_a_part_does_not_vary(quarter_car: Model) -> None:
    parts = [grid(quarter_car, {"sprung.mass": [1.0, 2.0]}), grid(quarter_car, {"frequency_hz": [3.0]})]
    points = joined(parts)
    assert [points.settings(n) for n in range(3)] == [
        {"sprung.mass": 1.0},
        {"sprung.mass": 2.0},
        {"frequency_hz": 3.0},
    ]
    labels = points.coordinates["sprung.mass"].values
    np.testing.assert_array_equal(labels, [1, 2, np.nan])


def test_joined_grids_keep_their_order(quarter_car: Model) -> None:
    points = joined([grid(quarter_car, {"sprung.mass": [1.0, 2.0], "frequency_hz": [3.0, 4.0, 5.0]})])
    for number in range(len(points)):
        labels = {name: each.values[number] for name, each in points.coordinates.items()}
        assert labels == points.settings(number)


def test_a_table_leaves_what_is_not_a_number(quarter_car: Model) -> None:
    points = table(quarter_car, {"sprung.mass": [300.0, np.nan], "frequency_hz": [np.nan, 2.0]})
    assert [points.settings(n) for n in (0, 1)] == [{"sprung.mass": 300.0}, {"frequency_hz": 2.0}]


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda m: grid(m, {}), "at least one"),
        (lambda m: grid(m, {"sprung.mass": []}), "one or more"),
        (lambda m: grid(m, {"sprung.mass": [1, np.inf]}), "inf"),
        (lambda m: grid(m, {"sprung.mass": ["heavy"]}), "'heavy'"),
        (lambda m: grid(m, {"sprung.mass": [1], "sprung": [1]}), "sprung.mass is varied twice"),
        (lambda m: grid(m, {"sprung.mass+frequency_hz": [1]}), "one unit"),
        (lambda m: table(m, {"sprung.mass": [1, 2], "frequency_hz": [1]}), "one length"),
        (lambda m: latin_hypercube(m, 0, {"sprung.mass": (1, 2)}), "0 points"),
        (lambda m: latin_hypercube(m, 3, {"sprung.mass": (2, 1)}), "2 to 1"),
        (lambda m: latin_hypercube(m, 3, {"sprung.mass": (0, 1)}, logarithmic=["sprung.mass"]), "above zero"),
        (lambda m: random_sample(m, 3, {"sprung.mass": (1, 2)}, logarithmic=["mass"]), "'mass'"),
        (lambda m: one_at_a_time(m, 1.5), "1.5"),
        (lambda m: joined([]), "at least one"),
    ],
)
def test_impossible_points_are_refused_in_one_line(quarter_car: Model, make, told: str) -> None:
    with pytest.raises(SamplingError) as refusal:
        make(quarter_car)
    assert told in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize("name", ["sprung.mas", "sprung.mass[0]", "wheel.radius"])
def test_unknown_parameters_are_refused(quarter_car: Model, name: str) -> None:
    with pytest.raises(ParameterError, match="unknown"):
        grid(quarter_car, {name: [1.0]})


def test_units_stand_beside_what_is_set(sedan: Model) -> None:
    points: Points = grid(sedan, {"body.front.mass": [400.0], "amplitude_m": [0.01], "lag_s": [0.1]})
    units = {name: each.attrs["units"] for name, each in points.to_xarray().data_vars.items()}
    assert units == {"set body.front.mass": "kg", "set amplitude_m": "m", "set lag_s": "s"}

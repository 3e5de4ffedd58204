"""Gauss points and their integrals against SciPy's quadrature and closed forms of powers."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BarycentricInterpolator
from scipy.special import roots_legendre

from chassym.nonlinear.orbits.gauss_points import (
    Places,
    equidistant_places,
    gauss_points,
    interpolation,
    lobatto_integrals,
    lobatto_places,
    weights_at,
)

COUNTS = [1, 2, 3, 5, 9, 16, 24]


@pytest.mark.parametrize("count", COUNTS)
def test_points_and_weights_are_scipys(count: int) -> None:
    nodes, weights = roots_legendre(count)
    points = gauss_points(count)
    assert points.places.values == pytest.approx((nodes + 1) / 2, abs=1e-15)
    assert points.first_to_end == pytest.approx(weights / 2, abs=1e-13)
    assert points.second_to_end == pytest.approx(weights / 2 * (1 - nodes) / 2, abs=1e-13)


@pytest.mark.parametrize("count", COUNTS)
def test_quadrature_is_exact_to_degree_2_p_less_1(count: int) -> None:
    points = gauss_points(count)
    for power in range(2 * count):
        found = points.first_to_end @ points.places.values**power
        assert found == pytest.approx(1 / (power + 1), rel=1e-12)
    missed = points.first_to_end @ points.places.values ** (2 * count) - 1 / (2 * count + 1)
    assert abs(missed) > 1e-13 or count > 10


@pytest.mark.parametrize("count", [2, 4, 7])
def test_integrals_to_every_point_are_those_of_the_interpolating_polynomial(count: int) -> None:
    points = gauss_points(count)
    places = points.places.values
    for column, unit in enumerate(np.eye(count)):
        basis = BarycentricInterpolator(places, unit)
        for row, place in enumerate(places):
            once, _ = quad(basis, 0, place, epsabs=1e-14)
            twice, _ = quad(lambda x, top=place, basis=basis: (top - x) * basis(x), 0, place, epsabs=1e-14)
            assert points.first[row, column] == pytest.approx(once, abs=1e-12)
            assert points.second[row, column] == pytest.approx(twice, abs=1e-12)


@pytest.mark.parametrize("count", [2, 6, 13])
def test_weights_elsewhere_are_exact_for_polynomials(count: int) -> None:
    elsewhere = np.linspace(0, 1, 11)
    value, first, second = weights_at(count, Places(elsewhere))
    for power in range(count):
        given = gauss_points(count).places.values ** power
        assert value @ given == pytest.approx(elsewhere**power, abs=1e-11)
        assert first @ given == pytest.approx(elsewhere ** (power + 1) / (power + 1), abs=1e-12)
        assert second @ given == pytest.approx(
            elsewhere ** (power + 2) / ((power + 1) * (power + 2)), abs=1e-12
        )


@pytest.mark.parametrize("count", [4, 9, 20])
def test_values_at_lobatto_places_are_interpolated_and_integrated(count: int) -> None:
    places, dense = lobatto_places(count).values, equidistant_places(21)
    assert places[0] == 0.0 and places[-1] == pytest.approx(1.0, abs=1e-15)
    once, twice = lobatto_integrals(count)
    for power in range(count):
        assert interpolation(count, dense) @ places**power == pytest.approx(dense.values**power, abs=1e-11)
    for power in range(count - 2):
        given = places[1:-1] ** power
        assert once @ given == pytest.approx(places ** (power + 1) / (power + 1), abs=1e-12)
        assert twice @ given == pytest.approx(places ** (power + 2) / (power + 1) / (power + 2), abs=1e-12)


def test_the_highest_coefficient_is_that_of_legendres_series() -> None:
    count = 5
    x = 2 * gauss_points(count).places.values - 1
    fourth = (35 * x**4 - 30 * x**2 + 3) / 8
    assert gauss_points(count).series[-1] @ (7.0 * fourth + x**3) == pytest.approx(7.0, rel=1e-12)

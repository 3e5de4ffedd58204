"""The quarter car against its closed form.

Source: the two-mass model of the textbooks, such as R. Rajamani, Vehicle Dynamics and Control, 2nd ed., 2012,
chapter 10, with tyre damping:

    ms zs'' = k (zu - zs) + c (zu' - zs')
    mu zu'' = -k (zu - zs) - c (zu' - zs') + kt (w - zu) + ct (w' - zu')

The damper enters by the mean of the two slopes of its table at rest.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from chassym.derivation import Model
from chassym.linear import LinearModel, damped_modes, frequency_response, linearise, undamped_modes

FREQUENCIES = np.geomspace(0.01, 1000, 300)


@dataclass(frozen=True)
class TwoMasses:
    """The numbers of the textbook's formulas."""

    ms: float
    mu: float
    k: float
    c: float
    kt: float
    ct: float

    @property
    def characteristic(self) -> list[float]:
        """Coefficients of the quartic, highest power first, multiplied out by hand."""
        return [
            self.ms * self.mu,
            self.ms * (self.c + self.ct) + self.mu * self.c,
            self.ms * (self.k + self.kt) + self.mu * self.k + self.c * self.ct,
            self.c * self.kt + self.k * self.ct,
            self.k * self.kt,
        ]

    def transfer(self, s: np.ndarray) -> dict[str, np.ndarray]:
        road = (self.ct * s + self.kt) / np.polyval(self.characteristic, s)
        body, wheel = (self.c * s + self.k) * road, (self.ms * s**2 + self.c * s + self.k) * road
        return {
            "body_displacement": body,
            "wheel_displacement": wheel,
            "wheel_travel": self.ms * s**2 * road,
            "vertical_acceleration": s**2 * body,
            "patch_force_z": self.ms * s**2 * body + self.mu * s**2 * wheel,
        }


def textbook(model: Model) -> TwoMasses:
    value = model.parameters.flat()
    sides = [
        (value[f"damper.force[{i + 1}]"] - value[f"damper.force[{i}]"])
        / (value[f"damper.velocity[{i + 1}]"] - value[f"damper.velocity[{i}]"])
        for i in (1, 2)
    ]
    return TwoMasses(
        value["sprung.mass"],
        value["unsprung.mass"],
        value["spring.rate"],
        sum(sides) / 2,
        value["tyre.stiffness"],
        value["tyre.damping"],
    )


VARIANTS = {
    "as in the file": {},
    "heavy wheel": {"unsprung.mass": 300.0, "tyre.damping": 0.0},
    "hard spring": {"spring.rate": 4e5, "sprung.mass": 90.0, "tyre.damping": 2500.0},
}


@pytest.fixture(params=VARIANTS.values(), ids=VARIANTS.keys())
def variant(request: pytest.FixtureRequest, quarter_car: Model) -> Model:
    return quarter_car.with_parameters(request.param)


def test_undamped_frequencies_are_the_roots_of_the_quadratic(variant: Model) -> None:
    """ms mu w^4 - (ms (k + kt) + mu k) w^2 + k kt = 0."""
    m = textbook(variant)
    middle = m.ms * (m.k + m.kt) + m.mu * m.k
    root = np.sqrt(middle**2 - 4 * m.ms * m.mu * m.k * m.kt)
    squared = np.array([middle - root, middle + root]) / (2 * m.ms * m.mu)
    found = undamped_modes(linearise(variant)).frequencies_hz
    np.testing.assert_allclose(found, np.sqrt(squared) / (2 * np.pi), rtol=1e-12)


def test_poles_are_the_roots_of_the_quartic(variant: Model) -> None:
    roots = np.roots(textbook(variant).characteristic)
    expected = np.sort_complex(roots[roots.imag >= 0])
    found = np.sort_complex([mode.eigenvalue for mode in damped_modes(linearise(variant))])
    np.testing.assert_allclose(found, expected, rtol=1e-13)


def test_every_transfer_function_is_the_closed_form(variant: Model) -> None:
    """To rounding: travel and patch force are differences, of motions almost equal at low frequency."""
    response = frequency_response(linearise(variant), FREQUENCIES)
    expected = textbook(variant).transfer(2j * np.pi * FREQUENCIES)
    assert set(expected) == set(response.outputs)
    terms = {"wheel_travel": 1.0, "patch_force_z": textbook(variant).kt}
    for output, values in expected.items():
        rounding = 2e-14 * terms.get(output, 0.0)
        np.testing.assert_allclose(
            response.select(output, "road"), values, rtol=1e-13, atol=rounding, err_msg=output
        )


@pytest.mark.parametrize("spring_rate", [3e3, 16e3, 2e5])
@pytest.mark.parametrize("damping", [0.0, 0.3, 1.0, 20.0])
def test_no_suspension_changes_the_invariant_points(
    quarter_car: Model, spring_rate: float, damping: float
) -> None:
    """J. K. Hedrick and T. Butsuen, Invariant properties of automotive suspensions, 1990, for ct = 0.

    Proc. Inst. Mech. Eng. D 204, 21-27. The suspension's force is internal: ms zs'' + mu zu'' = kt (w - zu).
    Hence zs'' = kt / ms w at w^2 = kt / mu, and zu - zs = (1 + mu / ms) w at w^2 = kt / (ms + mu).
    """
    forces = [damping * quarter_car.parameters.flat()[f"damper.force[{i}]"] for i in range(5)]
    changes: dict[str, list[float] | float] = {"spring.rate": spring_rate, "tyre.damping": 0.0}
    changes["damper.force"] = forces
    changed = quarter_car.with_parameters(changes)
    m = textbook(changed)
    frequencies = np.sqrt(m.kt / np.array([m.mu, m.ms + m.mu])) / (2 * np.pi)
    response = frequency_response(linearise(changed), frequencies)
    found = response.select("vertical_acceleration", "road")[0], response.select("wheel_travel", "road")[1]
    np.testing.assert_allclose(found, [m.kt / m.ms, 1 + m.mu / m.ms], rtol=1e-12, atol=0)


def test_an_overdamped_car_has_every_real_pole_once(quarter_car: Model) -> None:
    forces = [
        20 * quarter_car.parameters.flat()[f"damper.force[{i}]"] for i in range(5)
    ]  # the body no longer oscillates on its spring
    stiff = quarter_car.with_parameters({"damper.force": forces})
    roots = np.roots(textbook(stiff).characteristic)
    real = np.sort(roots[np.abs(roots.imag) < 1e-9].real)
    assert len(real) == 2
    modes = [mode for mode in damped_modes(linearise(stiff)) if mode.eigenvalue.imag == 0]
    np.testing.assert_allclose(np.sort([mode.eigenvalue.real for mode in modes]), real, rtol=1e-9)
    np.testing.assert_allclose([mode.damping_ratio for mode in modes], 1.0, rtol=1e-14)
    np.testing.assert_allclose(
        sorted(mode.frequency_hz for mode in modes), np.sort(-real) / (2 * np.pi), rtol=1e-9
    )
    assert len({mode.name for mode in damped_modes(linearise(stiff))}) == 3


def test_names(quarter_linear: LinearModel) -> None:
    assert undamped_modes(quarter_linear).names == ("bounce", "wheel hop")
    assert [mode.name for mode in damped_modes(quarter_linear)] == ["bounce", "wheel hop"]

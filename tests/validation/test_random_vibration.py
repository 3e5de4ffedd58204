"""Random vibration: published closed forms and the International Roughness Index of a road class.

Sources

- D. E. Newland, An Introduction to Random Vibrations, Spectral and Wavelet Analysis, appendix 1: integrals of
  rational spectra, first given by James, Nichols and Phillips (1947).
- M. Gobbi and G. Mastinu, Analytical description and optimization of the dynamic behaviour of passively
  suspended road vehicles, Journal of Sound and Vibration 245 (2001) 457-481: quarter car without tyre damping
  on a road whose vertical velocity is white noise. The forms below follow from Lyapunov's equation, too.
- M. W. Sayers, On the calculation of International Roughness Index from longitudinal road profile,
  Transportation Research Record 1501 (1995) 1-12: the parameters of the golden car.
- O. Kropac and P. Mucka, Be careful when using the International Roughness Index as an indicator of road
  unevenness, Journal of Sound and Vibration 287 (2005) 989-1003: IRI = 2.21 sqrt(C) at a waviness of 2, C the
  spectrum at 1 rad/m in 1e-6 m^3/rad.
"""

import numpy as np
import pytest

from chassym.derivation import Linear, Mechanism, Model, TravelPort, build_model, prismatic
from chassym.derivation.output import Deflection, PointVelocity
from chassym.linear import LinearModel, linearise
from chassym.linear.road.random_road import root_mean_squares
from chassym.linear.road.road_contacts import Contact, Passage, road_contacts
from chassym.linear.road.road_surface import Road, iso_8608

SPEED = 20.0
WHITE = Road(roughness=64e-6, longest=1e-6, shortest=1e6)
INTENSITY = 2 * np.pi**2 * 64e-6 * 0.1**2 * SPEED
"""W of the road's velocity, whose correlation is W delta(t): half its one-sided spectrum."""


def linear_car(model: Model, m: float, m_u: float, k: float, c: float, k_t: float) -> Model:
    """The quarter car with a linear damper and an undamped tyre."""
    return model.with_parameters(
        {
            "sprung.mass": m,
            "unsprung.mass": m_u,
            "spring.rate": k,
            "tyre.stiffness": k_t,
            "tyre.damping": 0.0,
            "damper.velocity": [-2.0, -1.0, 0.0, 1.0, 2.0],
            "damper.force": [-2 * c, -c, 0.0, c, 2 * c],
        }
    )


def rate(frequencies: np.ndarray) -> np.ndarray:
    return 2j * np.pi * frequencies


CARS = (
    {"m": 250.0, "m_u": 35.0, "k": 16e3, "c": 1e3, "k_t": 160e3},
    {"m": 400.0, "m_u": 60.0, "k": 40e3, "c": 500.0, "k_t": 200e3},
    {"m": 4000.0, "m_u": 500.0, "k": 500e3, "c": 30e3, "k_t": 2e6},
)


@pytest.mark.parametrize("values", CARS)
def test_quarter_car_on_white_noise(values: dict[str, float], quarter_car: Model) -> None:
    """Acceleration, suspension travel and its rate, and wheel load, to 1e-6."""
    m, m_u, k, c, k_t = values.values()
    model = linear_car(quarter_car, **values)
    linear, passage = linearise(model), Passage(WHITE, road_contacts(model), SPEED)
    names = ("vertical_acceleration", "wheel_travel", "patch_force_z")
    found = root_mean_squares(linear, passage, dict.fromkeys(names, np.ones_like))
    speed = root_mean_squares(linear, passage, {"wheel_travel": rate})["wheel_travel"]
    total = m + m_u
    expected = {
        "vertical_acceleration": (c * k_t + k**2 * total / c) / (2 * m**2),
        "wheel_travel": total / (2 * c),
        "patch_force_z": (
            c * k_t * total**2 + (k**2 * total**3 - 2 * k * k_t * m * m_u * total + k_t**2 * m**2 * m_u) / c
        )
        / (2 * m**2),
    }
    for name, variance in expected.items():
        assert found[name].value == pytest.approx(np.sqrt(INTENSITY * variance), rel=1e-6), name
    assert speed.value == pytest.approx(np.sqrt(INTENSITY * k_t / (2 * c)), rel=1e-6)


@pytest.fixture(scope="module")
def oscillator(cache_directory: str) -> LinearModel:
    """A mass of 2 kg on a spring and damper above a road: 3 Hz, a damping ratio of 0.014."""
    car = Mechanism("oscillator", 9.81)
    mass = car.add_body("mass", car.ground, prismatic("bounce", "z"), (0, 0, 0), mass=2.0)
    point = car.point("foot", mass, (0, 0, 0))
    road = car.add_input("road", "m")
    port = TravelPort(point, car.ground, "z").less(road)
    circular = 2 * np.pi * 3
    law = Linear(2.0 * circular**2, 2.0 * 2 * 0.014 * circular)
    car.add_force_element("spring", port, law, preloaded=True)
    car.add_output(Deflection("deflection", port))
    car.add_output(PointVelocity("velocity", point, "z", car.ground))
    return linearise(build_model(car, {}))


def test_one_mass_on_white_noise(oscillator: LinearModel) -> None:
    """Newland, appendix 1, n = 2: deflection W / (4 z w), velocity of the mass W w (1 + 4 z^2) / (4 z)."""
    passage = Passage(WHITE, {"road": Contact(0.0, 0.0)}, SPEED)
    found = root_mean_squares(oscillator, passage, dict.fromkeys(oscillator.outputs, np.ones_like))
    w, z = 2 * np.pi * 3, 0.014
    assert found["deflection"].value == pytest.approx(np.sqrt(INTENSITY / (4 * z * w)), rel=1e-6)
    assert found["velocity"].value == pytest.approx(
        np.sqrt(INTENSITY * w * (1 + 4 * z**2) / (4 * z)), rel=1e-6
    )


@pytest.mark.parametrize("road_class", ["A", "C"])
def test_roughness_index_of_a_road_class(road_class: str, quarter_car: Model) -> None:
    """Mean |suspension speed| of the golden car at 80 km/h over its speed; of a Gaussian sqrt(2/pi) sigma.

    C of class A is 1e-6 m^3: a spectrum over 1 rad/m has 1 / (2 pi) of that over cycles/m, at 1 / (2 pi)
    cycles/m. The published factor holds to its last digit, 0.01 in 2.21.
    """
    model = linear_car(quarter_car, m=250.0, m_u=0.15 * 250, k=63.3 * 250, c=6.0 * 250, k_t=653.0 * 250)
    road, speed = iso_8608(road_class), 80 / 3.6
    passage = Passage(road, road_contacts(model), speed)
    suspension = root_mean_squares(linearise(model), passage, {"wheel_travel": rate})["wheel_travel"]
    roughness_index = 1000 * np.sqrt(2 / np.pi) * suspension.value / speed
    unevenness = float(road.displacement_spectrum(1 / (2 * np.pi))) / (2 * np.pi)
    assert roughness_index / np.sqrt(unevenness * 1e6) == pytest.approx(2.21, abs=0.01)

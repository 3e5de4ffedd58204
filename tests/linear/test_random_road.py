"""Random road: surface, passage, profile and response, against Lyapunov, sampled profiles and simulation."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import solve_continuous_lyapunov
from scipy.signal import csd, lsim

from chassym.derivation import Model, load_model
from chassym.linear import LinearisationError, LinearModel, linearise
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.road.random_road import (
    dynamic_load_coefficients,
    output_spectra,
    random_response,
    root_mean_squares,
)
from chassym.linear.road.road_contacts import Contact, Passage, road_contacts
from chassym.linear.road.road_profile import sample_profile
from chassym.linear.road.road_surface import (
    Coherence,
    Road,
    exponential_coherence,
    full_coherence,
    iso_8608,
    isotropic_coherence,
    no_coherence,
)
from chassym.linear.road.stationarity import check_stationarity

CORNERS = {
    "front_left_road": Contact(0.0, -0.75),
    "front_right_road": Contact(0.0, 0.75),
    "rear_left_road": Contact(2.5, -0.8),
    "rear_right_road": Contact(2.5, 0.8),
}


@pytest.fixture(scope="module")
def ride_model(cache_directory: str) -> Model:
    return load_model("ride_model")


@pytest.fixture(scope="module")
def ride_linear(ride_model: Model) -> LinearModel:
    return linearise(ride_model)


# Surface


def test_classes_are_a_factor_of_four_apart() -> None:
    """ISO 8608:1995, table C.1: geometric means 16, 64, ... 262144 times 1e-6 m^3 at 0.1 cycles/m."""
    means = [iso_8608(name).roughness * 1e6 for name in "ABCDEFGH"]
    assert means == pytest.approx([16, 64, 256, 1024, 4096, 16384, 65536, 262144], rel=1e-12)


def test_spectrum_is_a_power_law_between_the_longest_and_the_shortest_wave() -> None:
    road = Road(2e-6, waviness=2.6, longest=0.02, shortest=1.5)
    assert road.displacement_spectrum([0.1, 1.0]) == pytest.approx([2e-6, 2e-6 * 10**-2.6], rel=1e-12)
    assert list(road.displacement_spectrum([0.0, 0.0199, 1.51])) == [0, 0, 0]
    assert (road.displacement_spectrum([0.02, 1.5]) > 0).all()


@pytest.mark.parametrize("waviness", [1.6, 2.0, 2.7])
@pytest.mark.parametrize(("n", "distance"), [(0.03, 1.5), (0.2, 1.5), (0.5, 0.6)])
def test_isotropic_coherence_is_the_integral_over_the_surface_spectrum(
    waviness: float, n: float, distance: float
) -> None:
    """Kamash and Robson 1978: one surface spectrum gives the profile's and the cross spectrum."""

    def surface(across: float) -> float:
        return float((n**2 + across**2) ** (-(waviness + 1) / 2))

    along, _ = quad(surface, 0, np.inf, epsabs=0)
    cross, error = quad(surface, 0, np.inf, weight="cos", wvar=2 * np.pi * distance, epsabs=1e-9 * along)
    found = isotropic_coherence(waviness)(np.array(n), np.array(distance))
    assert float(found) == pytest.approx(cross / along, abs=1e-8 + error / along)


@pytest.mark.parametrize(
    "coherence", [full_coherence, no_coherence, isotropic_coherence(), exponential_coherence(3.0)]
)
def test_coherence_of_a_track_with_itself_is_one_and_none_is_impossible(coherence: Coherence) -> None:
    """No combination of tracks may have a negative spectrum."""
    road = replace(iso_8608("A"), coherence=coherence)
    matrices = road.track_coherence(np.geomspace(0.01, 3, 20), [-0.8, -0.7, 0.1, 0.9])
    assert (np.diagonal(matrices, axis1=1, axis2=2) == 1).all()
    assert (np.abs(matrices) <= 1).all()
    assert np.linalg.eigvalsh(matrices).min() > -1e-12


def test_coherence_falls_with_distance_and_frequency() -> None:
    for coherence in (isotropic_coherence(2.3), exponential_coherence(2.0)):
        n, distance = np.geomspace(0.01, 3, 30)[:, None], np.linspace(0.1, 3, 7)
        values = coherence(n, distance)
        assert (np.diff(values, axis=0) < 0).all() and (np.diff(values, axis=1) < 0).all()


@pytest.mark.parametrize(
    ("refused", "message"),
    [
        (lambda: iso_8608("J"), "road_class 'J' is unknown; ISO 8608 has 'A', .*'H'"),
        (lambda: iso_8608("AB"), "road_class 'AB'"),
        (lambda: Road(-1e-6), "roughness -1e-06 received"),
        (lambda: Road(1e-6, waviness=np.nan), "waviness nan received"),
        (lambda: Road(1e-6, longest=3.0), "longest 3 received; .* below .* 2.83"),
        (lambda: isotropic_coherence(0.0), "waviness 0.0 received"),
        (lambda: exponential_coherence(-1.0), "decay -1.0 received"),
        (lambda: Contact(np.inf, 0.0), "finite place is needed"),
        (lambda: Passage(iso_8608("A"), {}, 10.0), "no contacts received"),
        (lambda: Passage(iso_8608("A"), CORNERS, 0.0), "speed 0.0 received"),
    ],
)
def test_impossible_roads_and_passages_are_refused(refused: Callable[[], object], message: str) -> None:
    with pytest.raises(LinearisationError, match=message):
        refused()


# Contacts


@pytest.mark.parametrize(
    ("vehicle", "places"),
    [
        ("quarter_car", {"road": (0, 0)}),
        ("half_car", {"front_road": (0, 0), "rear_road": (2.766, 0)}),
        ("half_car_roll", {"left_road": (0, -0.744), "right_road": (0, 0.744)}),
        (
            "sedan",
            {
                "front_left_pad_z": (0, -0.744),
                "front_right_pad_z": (0, 0.744),
                "rear_left_pad_z": (2.766, -0.744),
                "rear_right_pad_z": (2.766, 0.744),
            },
        ),
    ],
)
def test_contacts_of_the_built_in_vehicles_stand_below_their_wheels(
    vehicle: str, places: dict, cache_directory: str
) -> None:
    found = road_contacts(load_model(vehicle))
    assert {name: (contact.x, contact.y) for name, contact in found.items()} == places


def test_contacts_move_with_the_parameters(ride_model: Model) -> None:
    changed = ride_model.with_parameters({"axle.rear.x": 3.1, "axle.rear.track": 1.4})
    assert road_contacts(changed)["rear_right_road"] == Contact(3.1, 0.7)


def test_a_vehicle_without_a_road_is_refused(torsion_chain: Model) -> None:
    with pytest.raises(LinearisationError, match="contacts of 'torsion_chain': none of its inputs"):
        road_contacts(torsion_chain)


# Profile


@pytest.mark.parametrize(("j", "k"), [(0, 0), (1, 0), (2, 0), (3, 0)])
def test_profile_has_the_spectra_of_the_passage(j: int, k: int) -> None:
    """Spectrum, coherence across, delay behind, and both together, by Welch's method from 2000 s.

    About 230 half-overlapping segments scatter by some 8 % at every one of 440 frequencies, their mean by
    0.5 %; the rear's delay of 0.25 s costs 1.6 % in segments of 16 s.
    """
    passage = Passage(Road(1e-5, waviness=0.5, longest=0.001), CORNERS, speed=10.0)
    profile = sample_profile(passage, duration_s=2000.0, sample_rate_hz=64.0, seed=7)
    # scipy's csd(x, y) is E[X* Y].
    frequencies, found = csd(profile.displacements[k], profile.displacements[j], fs=64.0, nperseg=1024)
    band = slice(4, 444)
    expected = passage.input_spectra(frequencies[band])
    errors = (found[band] - expected[:, j, k]) / passage.spectrum(frequencies[band])
    turned = errors * np.exp(-1j * np.angle(expected[:, j, k]))
    assert abs(turned.mean()) < 0.025
    assert np.sqrt(np.mean(np.abs(errors) ** 2)) < 0.11


def test_rear_wheels_see_what_the_front_ones_saw() -> None:
    contacts = {"front": Contact(0.0, 0.7), "rear": Contact(2.5, 0.7)}
    profile = sample_profile(Passage(iso_8608("C"), contacts, 10.0), 120.0, 100.0, seed=3)
    front, rear = profile.displacements
    np.testing.assert_allclose(rear, np.roll(front, 25), atol=1e-12 * np.abs(front).max())


def test_rates_are_derivatives_of_the_displacements() -> None:
    """At a waviness of 2 the rate is white, with the variance 4 pi^2 G n0^2 v^2 (n_max - n_min)."""
    road = iso_8608("B")
    passage = Passage(road, {"road": Contact(0.0, 0.0)}, 15.0)
    profile = sample_profile(passage, 400.0, 2000.0, seed=11)
    height, rate = profile.displacements[0], profile.rates[0]
    central = (height[2:] - height[:-2]) * 1000.0
    assert np.abs(central - rate[1:-1]).max() < 0.01 * rate.std()
    variance = 4 * np.pi**2 * road.roughness * 0.01 * 15.0 * 15.0 * (road.shortest - road.longest)
    harmonics = 400.0 * 15.0 * (road.shortest - road.longest)
    assert rate.var() == pytest.approx(variance, rel=3 / np.sqrt(harmonics))


def test_the_seed_makes_the_profile() -> None:
    passage = Passage(iso_8608("A"), CORNERS, 20.0)
    first, same, other = (sample_profile(passage, 30.0, 200.0, seed).displacements for seed in (1, 1, 2))
    assert (first == same).all() and not (first == other).any()
    dataset = sample_profile(passage, 30.0, 200.0, 1).to_xarray()
    assert dataset.displacement.sel(input="rear_left_road").attrs["units"] == "m"
    assert (dataset.displacement.sel(input="rear_left_road") == first[2]).all()


def test_profiles_that_cannot_hold_the_road_are_refused() -> None:
    passage = Passage(iso_8608("A"), CORNERS, 20.0)
    with pytest.raises(LinearisationError, match=r"sample_rate_hz 100.0 received; more than 113.2 Hz"):
        sample_profile(passage, 60.0, 100.0, 1)
    with pytest.raises(LinearisationError, match=r"duration_s 4.0 received; more than 4.54545 s"):
        sample_profile(passage, 4.0, 200.0, 1)


# Response


def test_root_mean_squares_agree_with_lyapunov(cache_directory: str) -> None:
    """A road whose rate is white noise, from 1e-8 to 1e6 cycles/m, under tyres without damping.

    With noise of intensity W, and q_s the static response to the road, the state (q - q_s u, q') has the
    covariance P of A P + P A^T + W b b^T = 0 with b = (-q_s, 0), what a step of the road does. Left and right
    are independent. Statically no output but displacements changes, so that all others are stationary.
    """
    linear = linearise(load_model("half_car_roll", {"tyre.damping": 0.0}))
    road = Road(16e-6, longest=1e-8, shortest=1e6, coherence=no_coherence)
    passage = Passage(road, {"left_road": Contact(0.0, -0.7), "right_road": Contact(0.0, 0.7)}, 20.0)
    matrices = displacements_and_rates(linear)
    static = np.linalg.solve(linear.stiffness, linear.input_stiffness)
    step = np.vstack([-static, np.zeros_like(static)])
    intensity = 2 * np.pi**2 * road.roughness * road.reference**2 * passage.speed
    covariance = solve_continuous_lyapunov(matrices.A, -intensity * step @ step.T)
    variances = np.diag(matrices.C @ covariance @ matrices.C.T)
    expected = dict(zip(linear.outputs, np.sqrt(variances), strict=True))
    names = [name for name in linear.outputs if not name.endswith("displacement")]
    found = root_mean_squares(linear, passage, dict.fromkeys(names, np.ones_like))
    assert len(names) == 6
    for name in names:
        assert found[name].value == pytest.approx(expected[name], rel=1e-6), name
        assert found[name].error < 1e-6 * expected[name]


def test_spectra_are_those_of_the_inputs_through_the_responses(ride_linear: LinearModel) -> None:
    """Against frequency responses of the state space, solved by other means, and the full cross spectra."""
    passage = Passage(iso_8608("C"), CORNERS, 25.0)
    frequencies = np.geomspace(0.3, 60, 15)
    matrices = displacements_and_rates(ride_linear)
    spectra = output_spectra(ride_linear, passage, frequencies)
    for i, frequency in enumerate(frequencies):
        s = 2j * np.pi * frequency
        states = np.linalg.solve(s * np.eye(len(matrices.A)) - matrices.A, matrices.B)
        response = (matrices.C @ states + matrices.D) @ np.vstack([np.eye(4), s * np.eye(4)])
        full = response @ passage.input_spectra([frequency])[0] @ response.conj().T
        np.testing.assert_allclose(spectra[:, i], np.diag(full).real, rtol=1e-8)


def test_root_mean_squares_agree_with_a_long_simulation(ride_linear: LinearModel) -> None:
    """Within 3.5 standard errors, from the scatter of the means of 40 batches; every error below 10 %.

    scipy's lsim is exact for inputs that are linear between samples.
    """
    contacts = {name: Contact(c.x, np.sign(c.y) * 0.75) for name, c in CORNERS.items()}
    passage = Passage(iso_8608("B"), contacts, 20.0)
    compare_with_simulation(ride_linear, passage, duration_s=300.0, batches=40, largest_error=0.1)


@pytest.mark.slow
def test_root_mean_squares_of_the_sedan_agree_with_a_long_simulation(
    sedan: Model, sedan_linear: LinearModel
) -> None:
    """The yaw mode's damping is 1.4 %: an hour of road."""
    passage = Passage(iso_8608("C"), road_contacts(sedan), 25.0)
    compare_with_simulation(sedan_linear, passage, duration_s=3600.0, batches=60, largest_error=0.05)


def compare_with_simulation(
    linear: LinearModel, passage: Passage, duration_s: float, batches: int, largest_error: float
) -> None:
    profile = sample_profile(passage, duration_s + 40.0, 400.0, seed=2024)
    moved = [linear.inputs.index(name) for name in profile.contacts]
    inputs = np.zeros((2 * len(linear.inputs), len(profile.time_s)))
    inputs[moved], inputs[[len(linear.inputs) + i for i in moved]] = profile.displacements, profile.rates
    m = displacements_and_rates(linear)
    _, outputs, _ = lsim((m.A, m.B, m.C, m.D), inputs.T, profile.time_s)
    settled = outputs[round(40.0 * 400.0) :]
    means = (settled**2).reshape(batches, -1, len(linear.outputs)).mean(axis=1)
    expected = root_mean_squares(linear, passage, dict.fromkeys(linear.outputs, np.ones_like))
    for name, batch in zip(linear.outputs, means.T, strict=True):
        mean_square = expected[name].value ** 2
        standard_error = batch.std(ddof=1) / np.sqrt(batches)
        assert abs(batch.mean() - mean_square) < 3.5 * standard_error, name
        assert standard_error < largest_error * mean_square, name


def test_a_resonance_as_sharp_as_one_in_ten_thousand_is_integrated(quarter_linear: LinearModel) -> None:
    """The mean square is in proportion to 1 / damping; a fixed grid of frequencies would miss the peak."""
    passage = Passage(iso_8608("A"), {"road": Contact(0.0, 0.0)}, 20.0)
    found = []
    for factor in (1e-4, 1e-5):
        sharp = replace(
            quarter_linear,
            damping=factor * quarter_linear.damping,
            input_damping=factor * quarter_linear.input_damping,
        )
        rms = root_mean_squares(sharp, passage, {"wheel_travel": np.ones_like})["wheel_travel"]
        assert rms.error < 1e-6 * rms.value
        found.append(rms.value**2)
    assert found[1] / found[0] == pytest.approx(10, rel=1e-3)


def test_waves_beyond_the_road_add_what_a_wider_road_has(quarter_linear: LinearModel) -> None:
    contacts, road = {"road": Contact(0.0, 0.0)}, iso_8608("C")
    narrow = random_response(quarter_linear, Passage(road, contacts, 20.0)).rms
    wide = replace(road, longest=road.longest / 10, shortest=road.shortest * 10)
    for name, rms in random_response(quarter_linear, Passage(wide, contacts, 20.0)).rms.items():
        together = np.sqrt(
            narrow[name].value ** 2 + narrow[name].longer_waves ** 2 + narrow[name].shorter_waves ** 2
        )
        assert together == pytest.approx(rms.value, rel=1e-6)


def test_drawn_spectra_hold_the_mean_square(ride_linear: LinearModel) -> None:
    """The trapezoidal rule on the default frequencies, a coarse integral, comes close."""
    passage = Passage(iso_8608("C"), CORNERS, 20.0)
    response = random_response(ride_linear, passage)
    areas = np.trapezoid(response.spectra, response.frequencies_hz)
    for name, area in zip(response.outputs, areas, strict=True):
        assert np.sqrt(area) == pytest.approx(response.rms[name].value, rel=0.02), name
    dataset = response.to_xarray()
    assert dataset.vertical_acceleration.attrs["units"] == "(m/s^2)^2/Hz"
    assert dataset.vertical_acceleration.attrs["rms"] == response.rms["vertical_acceleration"].value


def test_drawn_spectra_show_a_sharp_resonance(quarter_linear: LinearModel) -> None:
    """At damping ratios below 1e-3 the default frequencies still hold the mean square to 5 %."""
    sharp = replace(
        quarter_linear,
        damping=1e-3 * quarter_linear.damping,
        input_damping=1e-3 * quarter_linear.input_damping,
    )
    response = random_response(sharp, Passage(iso_8608("A"), {"road": Contact(0.0, 0.0)}, 20.0))
    area = np.trapezoid(response.spectra[response.outputs.index("wheel_travel")], response.frequencies_hz)
    assert np.sqrt(area) == pytest.approx(response.rms["wheel_travel"].value, rel=0.05)


def test_tracks_alike_do_not_roll_the_car_and_more_coherence_rolls_it_less(ride_linear: LinearModel) -> None:
    contacts = {name: Contact(c.x, np.sign(c.y) * 0.75) for name, c in CORNERS.items()}
    rolls = []
    for coherence in (full_coherence, isotropic_coherence(), no_coherence):
        road = replace(iso_8608("C"), coherence=coherence)
        rms = random_response(ride_linear, Passage(road, contacts, 20.0)).rms
        rolls.append(rms["roll_rate"].value)
    assert rolls[0] < 1e-7 * rolls[1] < 1e-7 * rolls[2]


def test_no_pitch_where_the_wheelbase_holds_whole_waves(ride_linear: LinearModel) -> None:
    """Wheelbase filtering: at f = k v / l both axles move alike; at half of that, opposite."""
    passage = Passage(replace(iso_8608("C"), coherence=full_coherence), CORNERS, 20.0)
    frequency = 20.0 / 2.5
    spectra = passage.input_spectra([frequency, frequency / 2])
    difference = np.array([1, 0, -1, 0])
    found = np.einsum("j,fjk,k->f", difference, spectra, difference).real / passage.spectrum(
        [frequency, frequency / 2]
    )
    assert found == pytest.approx([0, 4], abs=1e-12)


def test_a_class_rougher_doubles_every_root_mean_square(ride_model: Model, ride_linear: LinearModel) -> None:
    contacts = road_contacts(ride_model)
    smooth, rough = (random_response(ride_linear, Passage(iso_8608(c), contacts, 20.0)) for c in "AB")
    for name in smooth.outputs:
        assert rough.rms[name].value == pytest.approx(2 * smooth.rms[name].value, rel=1e-9)
    loads = dynamic_load_coefficients(ride_linear, rough)
    assert set(loads) == {name.replace("_road", "_patch_force_z") for name in CORNERS}
    weight = sum(rough.rms[name].value / coefficient for name, coefficient in loads.items())
    parameters = ride_model.parameters.flat()
    mass = parameters["body.mass"] + 2 * sum(
        parameters[f"suspension.{axle}.unsprung.mass"] for axle in ("front", "rear")
    )
    assert weight == pytest.approx(mass * parameters["gravity"], rel=1e-9)


# Refused


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"damping": -1.0}, r"'half_car' on a random road: '.*' at .* Hz grows \(eigenvalue"),
        ({"damping": 0.0}, "does not decay .*: no root mean square exists; add damping or a spring"),
        ({"stiffness": 0.0}, "at 0 Hz does not decay"),
    ],
)
def test_motions_that_do_not_decay_are_refused(
    half_car: Model, half_linear: LinearModel, change: dict, message: str
) -> None:
    changes = {name: factor * getattr(half_linear, name) for name, factor in change.items()}
    with pytest.raises(LinearisationError, match=message):
        random_response(
            replace(half_linear, **changes), Passage(iso_8608("A"), road_contacts(half_car), 20.0)
        )


def test_every_built_in_vehicle_on_wheels_comes_to_rest(
    sedan_linear: LinearModel, half_linear: LinearModel
) -> None:
    for linear in (sedan_linear, half_linear):
        check_stationarity(linear)


def test_unknown_names_are_refused(half_linear: LinearModel) -> None:
    passage = Passage(iso_8608("A"), {"front_road": Contact(0.0, 0.0)}, 20.0)
    with pytest.raises(LinearisationError, match="output 'travel' is unknown; there are front_wheel_travel"):
        root_mean_squares(half_linear, passage, {"travel": np.ones_like})
    other = replace(passage, contacts={"road": Contact(0.0, 0.0)})
    with pytest.raises(
        LinearisationError, match="contact for 'road' received; .* inputs front_road, rear_road"
    ):
        random_response(half_linear, other)

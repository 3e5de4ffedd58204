"""Vibration on a random road: spectra and root mean squares of the outputs at a speed.

Every result is of the waves that the road has, see `Road.longest` and `Road.shortest`; what waves beyond them
would add is stated beside it.

Source: J. D. Robson and C. J. Dodds, Stochastic road inputs and vehicle response, Vehicle System Dynamics 5
(1976) 1-13.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad_vec

from chassym.derivation import ContactForce
from chassym.linear.frequency_response import frequency_response
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.road.road_contacts import Passage
from chassym.linear.road.stationarity import check_stationarity

if TYPE_CHECKING:
    import xarray

Array = np.ndarray

Weight = Callable[[Array], Array]
"""Of frequencies (Hz): a factor on an output's amplitude, real or complex, of the same shape."""

TOLERANCE = 1e-7
"""Error of a mean square that the integration aims at, relative to the mean square."""

TOLERANCE_BEYOND = 1e-3
"""The same for what waves beyond the road's would add."""

NOISE = 1e-12
"""Mean squares below this part of what they would be without cancellation are rounding."""

DECADE = 10

NODES = 8
"""Nodes of a fixed quadrature on every piece of the band."""


@dataclass(frozen=True)
class RootMeanSquare:
    """A root mean square and what limits it, all in the unit of the quantity.

    Attributes
    ----------
    value
        Of the waves that the road has.
    error
        Estimated error of its integration.
    longer_waves, shorter_waves
        Root mean square of what a decade of waves beyond the longest, and beyond the shortest, would add if
        the road's spectrum went on there: the value would be the root of the sum of the squares.
    """

    value: float
    error: float
    longer_waves: float
    shorter_waves: float


@dataclass(frozen=True, eq=False)
class RandomResponse:
    """Stationary vibration on a random road.

    Attributes
    ----------
    passage
        The road, its contacts and the speed.
    frequencies_hz
        Shape (frequencies,).
    spectra
        One-sided spectra (output unit squared per Hz), shape (outputs, frequencies).
    rms
        Root mean square of every output, by its name.
    outputs, output_units
        Names and SI units.
    description
        The linear model, with the slopes used.
    """

    passage: Passage
    frequencies_hz: Array
    spectra: Array
    rms: Mapping[str, RootMeanSquare]
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]
    description: str

    def to_xarray(self) -> xarray.Dataset:
        """Spectrum of every output over `frequency`, with unit and root mean square as attributes."""
        import xarray  # it takes a second to import: only for those who ask for it

        described = zip(self.outputs, self.output_units, self.spectra, strict=True)
        variables = {
            name: ("frequency", spectrum, {"units": f"({unit})^2/Hz", "rms": self.rms[name].value})
            for name, unit, spectrum in described
        }
        coordinates = {"frequency": ("frequency", self.frequencies_hz, {"units": "Hz"})}
        return xarray.Dataset(variables, coordinates, attrs={"description": self.description})


def random_response(
    linear: LinearModel, passage: Passage, frequencies_hz: ArrayLike | None = None
) -> RandomResponse:
    """Spectra and root mean squares of all outputs on a random road.

    Parameters
    ----------
    linear
        The linear model.
    passage
        The road, its contacts and the speed. Inputs without a contact stand still.
    frequencies_hz
        Where to give spectra (Hz), shape (frequencies,); by default where every resonance shows.

    Raises
    ------
    LinearisationError
        If a motion does not decay, so that there is no stationary response; or a contact moves no input.

    Examples
    --------
    Suspension travel (m) on an average road:

    >>> from chassym.derivation import load_model
    >>> from chassym.linear import linearise
    >>> from chassym.linear.road.road_contacts import road_contacts
    >>> from chassym.linear.road.road_surface import iso_8608
    >>> model = load_model("half_car")
    >>> passage = Passage(iso_8608("C"), road_contacts(model), speed=20.0)
    >>> response = random_response(linearise(model), passage)
    >>> round(response.rms["front_wheel_travel"].value, 4)
    0.0088
    """
    rms = root_mean_squares(linear, passage, dict.fromkeys(linear.outputs, np.ones_like))
    given = _resolving(linear, passage) if frequencies_hz is None else frequencies_hz
    frequencies = np.array(given, dtype=float, ndmin=1)
    return RandomResponse(
        passage=passage,
        frequencies_hz=frequencies,
        spectra=output_spectra(linear, passage, frequencies),
        rms=rms,
        outputs=linear.outputs,
        output_units=linear.output_units,
        description=linear.description,
    )


def root_mean_squares(
    linear: LinearModel, passage: Passage, weights: Mapping[str, Weight]
) -> dict[str, RootMeanSquare]:
    """Root mean squares of outputs behind filters, by the outputs' names.

    Parameters
    ----------
    linear, passage
        As for `random_response`.
    weights
        For every output wanted the filter's response to frequencies (Hz), real or complex:
        ``lambda f: 2j * np.pi * f`` gives the rate of an output, ``np.ones_like`` the output itself.

    Raises
    ------
    LinearisationError
        As for `random_response`, or if there is no such output.
    """
    check_stationarity(linear)
    if not weights:
        return {}
    for name in weights.keys() - set(linear.outputs):
        raise LinearisationError(f"output {name!r} is unknown; there are {', '.join(linear.outputs)}")
    road = passage.road
    value, error = _mean_squares(linear, passage, weights, TOLERANCE)
    beyond = (
        replace(road, longest=road.longest / DECADE, shortest=road.longest),
        replace(road, longest=road.shortest, shortest=road.shortest * DECADE),
    )
    added = [_mean_squares(linear, replace(passage, road=r), weights, TOLERANCE_BEYOND)[0] for r in beyond]
    root = np.sqrt(value)
    columns = zip(root, np.sqrt(value + error) - root, *np.sqrt(added), strict=True)
    found = (RootMeanSquare(*(float(number) for number in row)) for row in columns)
    return dict(zip(weights, found, strict=True))


def output_spectra(linear: LinearModel, passage: Passage, frequencies_hz: ArrayLike) -> Array:
    """One-sided spectra of the outputs: the diagonal of G S G^H, shape (outputs, frequencies).

    Raises
    ------
    LinearisationError
        If a contact moves no input of the model, or as for `frequency_response`.
    """
    return _spectra(linear, passage, np.array(frequencies_hz, dtype=float, ndmin=1))[0]


def mean_square_nodes(linear: LinearModel, passage: Passage) -> tuple[Array, Array]:
    """Frequencies (Hz) in the road's band and weights (Hz) whose sum of weighted spectra is a mean square.

    They are those of Gauss and Legendre on every piece between resonances on which spectra are smooth: for
    integrals of many quantities at once.
    """
    edges = _edges(linear, passage)
    places, weights = np.polynomial.legendre.leggauss(NODES)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (places + 1)).ravel(), (half * weights).ravel()


def dynamic_load_coefficients(linear: LinearModel, response: RandomResponse) -> dict[str, float]:
    """Root mean square of every wheel load over its static value, by the output's name.

    Wheel loads are the outputs of the kind `ContactForce` that carry weight at the operating point.
    """
    point = linear.operating_point
    at_rest = point.model.outputs(point.arguments[:, None])[:, 0]
    loads = zip(point.model.system.outputs, at_rest, strict=True)
    wheels = {y.name: load for y, load in loads if isinstance(y, ContactForce) and load > 0}
    measured = {name: load for name, load in wheels.items() if name in response.rms}
    return {name: float(response.rms[name].value / load) for name, load in measured.items()}


def _spectra(linear: LinearModel, passage: Passage, frequencies: Array) -> tuple[Array, Array]:
    """Spectra of the outputs, and what they would be if nothing cancelled, shape (outputs, frequencies)."""
    unknown = [name for name in passage.contacts if name not in linear.inputs]
    if unknown:
        raise LinearisationError(
            f"contact for {unknown[0]!r} received; {linear.name!r} has the inputs {', '.join(linear.inputs)}"
        )
    columns = [linear.inputs.index(name) for name in passage.contacts]
    response = frequency_response(linear, frequencies).response[:, columns].transpose(2, 0, 1)
    tracks = response @ passage.from_tracks(frequencies)
    coherent = tracks @ passage.coherence(frequencies)
    input_spectrum = passage.spectrum(frequencies)
    spectra = np.einsum("foi,foi->of", coherent, tracks.conj()).real * input_spectrum
    return np.maximum(spectra, 0.0), np.abs(response).sum(axis=2).T ** 2 * input_spectrum


def _mean_squares(
    linear: LinearModel, passage: Passage, weights: Mapping[str, Weight], tolerance: float
) -> tuple[Array, Array]:
    """Integrals of weighted spectra over the road's band, and their estimated errors, shape (weights,).

    The band is cut where resonances and delays want it, every piece mapped to (0, 1), and their sum
    integrated there: one adaptive quadrature refines all pieces and outputs together.
    """
    edges = _edges(linear, passage)
    widths = np.diff(edges)
    rows = [linear.outputs.index(name) for name in weights]

    def pieces(place: float) -> Array:
        frequencies = edges[:-1] + place * widths
        factors = np.abs([weight(frequencies) for weight in weights.values()]) ** 2 * widths
        return np.array(
            [(each[rows] * factors).sum(axis=1) for each in _spectra(linear, passage, frequencies)]
        )

    rough, uncancelled = np.mean([pieces(place) for place in (0.1, 0.3, 0.5, 0.7, 0.9)], axis=0)
    scale = np.maximum(rough, NOISE * uncancelled)
    scale[scale == 0] = 1.0
    found, error = quad_vec(
        lambda place: pieces(place)[0] / scale, 0.0, 1.0, epsabs=tolerance, epsrel=0.0, norm="max", limit=50
    )
    return np.maximum(found, 0.0) * scale, error * scale


def _edges(linear: LinearModel, passage: Passage) -> Array:
    """Frequencies in the road's band (Hz), its ends among them, between which spectra are smooth.

    They are close about every resonance, in proportion to its width, and no further apart than the frequency
    at which front and rear are a wave apart.
    """
    low, high = passage.band_hz
    poles = np.linalg.eigvals(displacements_and_rates(linear).A) / (2 * np.pi)
    beside = 4.0 ** np.arange(6)
    away = np.concatenate([-beside, [0.0], beside])
    resonances = (np.abs(poles.imag)[:, None] + np.abs(poles.real)[:, None] * away).ravel()
    places = [contact.x for contact in passage.contacts.values()]
    waves = int((passage.road.shortest - passage.road.longest) * np.ptp(places)) + 2
    decades = np.geomspace(low, high, 2 + int(4 * np.log10(high / low)))
    inside = np.concatenate([decades, np.linspace(low, high, waves), resonances])
    return np.unique(np.clip(inside, low, high))


def _resolving(linear: LinearModel, passage: Passage) -> Array:
    """Frequencies in the road's band at which a drawn spectrum shows its resonances (Hz)."""
    edges = _edges(linear, passage)
    steps = np.linspace(0.0, 1.0, 4, endpoint=False)
    return np.append((edges[:-1, None] + np.diff(edges)[:, None] * steps).ravel(), edges[-1])

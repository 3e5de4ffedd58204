"""Where a vehicle stands on the road, and how a random road moves its inputs at a speed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from chassym.derivation import (
    CombinedPort,
    Input,
    Mechanism,
    Model,
    Point,
    Port,
    PrescribedPort,
    TravelPort,
)
from chassym.linear.frequency_response import VERTICAL_INPUT
from chassym.linear.linear_model import LinearisationError
from chassym.linear.road.road_surface import Road

Array = np.ndarray


@dataclass(frozen=True)
class Contact:
    """A place where the road is felt.

    Attributes
    ----------
    x
        To the rear (m): what is at x feels the road x / speed later than what is at zero.
    y
        Its track: the lateral place (m).
    """

    x: float
    y: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x) and math.isfinite(self.y)):
            raise LinearisationError(f"contact at {(self.x, self.y)} received; a finite place is needed")


def road_contacts(model: Model) -> dict[str, Contact]:
    """The design position of the point above every pad, or road, that moves up and down, by the input's name.

    Raises
    ------
    LinearisationError
        If nothing moves vertically under the model, or a road is not under one point.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> road_contacts(load_model("half_car"))
    {'front_road': Contact(x=0.0, y=0.0), 'rear_road': Contact(x=2.766, y=0.0)}
    """
    system = model.system
    roads = [motion for motion in system.inputs if VERTICAL_INPUT.fullmatch(motion.name)]
    if not roads:
        raise LinearisationError(
            f"contacts of {system.name!r}: none of its inputs {[u.name for u in system.inputs]} moves it "
            "vertically; one named 'road', '..._road' or '..._pad_z' is needed"
        )
    return {motion.name: _contact(model, motion) for motion in roads}


@dataclass(frozen=True)
class Passage:
    """A road that passes under contacts at a speed.

    Attributes
    ----------
    road
        The surface.
    contacts
        Contacts by the names of the inputs that they move.
    speed
        Greater than zero (m/s).

    Raises
    ------
    LinearisationError
        If there are no contacts, or the speed is not greater than zero.
    """

    road: Road
    contacts: Mapping[str, Contact]
    speed: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.speed) and self.speed > 0):
            raise LinearisationError(
                f"speed {self.speed!r} received; a finite speed greater than zero (m/s) is needed"
            )
        if not self.contacts:
            raise LinearisationError("no contacts received; at least one input has to be moved by the road")

    @property
    def band_hz(self) -> tuple[float, float]:
        """Frequencies of the longest and the shortest waves (Hz)."""
        return self.road.longest * self.speed, self.road.shortest * self.speed

    @property
    def tracks(self) -> tuple[float, ...]:
        """The lateral places that differ (m), ascending."""
        return tuple(sorted({contact.y for contact in self.contacts.values()}))

    def spectrum(self, frequencies_hz: ArrayLike) -> Array:
        """One-sided spectrum of the height of the road under any contact (m^2/Hz), shape (frequencies,)."""
        return self.road.displacement_spectrum(np.asarray(frequencies_hz) / self.speed) / self.speed

    def coherence(self, frequencies_hz: ArrayLike) -> Array:
        """Coherence of every track with every other, shape (frequencies, tracks, tracks)."""
        return self.road.track_coherence(np.asarray(frequencies_hz) / self.speed, self.tracks)

    def from_tracks(self, frequencies_hz: ArrayLike) -> Array:
        """Contacts per unit of tracks, exp(-2 pi j f x / v), shape (frequencies, contacts, tracks)."""
        places = list(self.contacts.values())
        late = np.outer(np.asarray(frequencies_hz), [contact.x / self.speed for contact in places])
        own = np.array([[contact.y == track for track in self.tracks] for contact in places])
        return np.exp(-2j * np.pi * late)[:, :, None] * own

    def input_spectra(self, frequencies_hz: ArrayLike) -> Array:
        """One-sided cross spectra of the contacts, S_jk = E[U_j U_k*] (m^2/Hz).

        Returns
        -------
        numpy.ndarray
            Hermitian, shape (frequencies, contacts, contacts).

        Examples
        --------
        A rear wheel a quarter of a wave behind lags a quarter of a turn:

        >>> from chassym.linear.road.road_surface import iso_8608
        >>> passage = Passage(iso_8608("A"), {"front": Contact(0, 0), "rear": Contact(2.5, 0)}, speed=10)
        >>> (passage.input_spectra([1.0]) / passage.spectrum([1.0])).round(3)
        array([[[1.+0.j, 0.+1.j],
                [0.-1.j, 1.+0.j]]])
        """
        brought = self.from_tracks(frequencies_hz)
        spectra = brought @ self.coherence(frequencies_hz) @ brought.conj().swapaxes(1, 2)
        return spectra * self.spectrum(frequencies_hz)[:, None, None]


def _contact(model: Model, motion: Input) -> Contact:
    elements = model.system.elements if isinstance(model.system, Mechanism) else ()
    ports = [element.port for element in elements if motion in _motions(element.port)]
    points = {point.name: point for port in ports for point in _points(port)}
    if len(points) != 1:
        raise LinearisationError(
            f"contact of input {motion.name!r}: it moves {len(points)} points {sorted(points)}; one is "
            "needed, or a mapping from inputs to contacts given by hand"
        )
    x, y, _ = next(iter(points.values())).position
    values = {symbol: model.values[symbol.name] for symbol in (x.free_symbols | y.free_symbols)}
    return Contact(float(x.xreplace(values)), float(y.xreplace(values)))


def _motions(port: Port) -> Iterator[Input]:
    """Prescribed motions in a deflection."""
    if isinstance(port, PrescribedPort):
        yield port.motion
    if isinstance(port, CombinedPort):
        for term, _ in port.terms:
            yield from _motions(term)


def _points(port: Port) -> Iterator[Point]:
    """Points whose travel is in a deflection."""
    if isinstance(port, TravelPort):
        yield port.point
    if isinstance(port, CombinedPort):
        for term, _ in port.terms:
            yield from _points(term)

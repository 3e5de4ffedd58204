"""One-parameter families of harmonic tests: what changes along a branch of orbits, and how fast."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from chassym.derivation import BoundFunction, Model
from chassym.derivation.equilibrium import solve_preloads
from chassym.nonlinear.excitation.excitation import ExcitationError, Harmonic
from chassym.nonlinear.harmonics.harmonic_equations import HarmonicEquations

Array = np.ndarray

_STEP = 1e-5
"""Relative step of the central difference of preloads, which are smooth functions of the parameters."""


class Path(Protocol):
    """A family of harmonic tests with one parameter."""

    @property
    def name(self) -> str:
        """What the parameter is called."""

    @property
    def unit(self) -> str:
        """Unit of the parameter."""

    def at(self, value: float) -> tuple[Model, Harmonic]:
        """The test at a value of the parameter.

        Raises
        ------
        ExcitationError, ParameterError
            If the value is impossible.
        """

    def slope(self, equations: HarmonicEquations, arguments: Array, value: float) -> Array:
        """Exact derivative of the packed residual by the parameter, at fixed unknowns.

        Parameters
        ----------
        equations
            Those of the test at the value.
        arguments
            The equations' arguments at the samples.
        """


def place(path: Path, value: float) -> str:
    """A value of a path's parameter in words.

    Examples
    --------
    >>> place(FrequencyPath(None, Harmonic(1.0, {})), 2.5)
    'frequency 2.5 Hz'
    """
    unit = "" if path.unit == "1" else f" {path.unit}"
    return f"{path.name} {value:.6g}{unit}"


@dataclass(frozen=True)
class Held:
    """Which derivative of the prescribed motion keeps its amplitude when the frequency changes."""

    name: str
    order: int


DISPLACEMENT, VELOCITY, ACCELERATION = Held("displacement", 0), Held("velocity", 1), Held("acceleration", 2)


@dataclass(frozen=True, eq=False)
class FrequencyPath:
    """A test at other frequencies; the parameter is the frequency in Hz.

    Attributes
    ----------
    model, excitation
        The test at the frequency that the excitation has.
    held
        What keeps the amplitude that it has there: `DISPLACEMENT`, `VELOCITY` or `ACCELERATION`.
    lags_s
        Lag (s) of inputs by name; their phases turn with the frequency. Other phases stay.
    """

    model: Model
    excitation: Harmonic
    held: Held = DISPLACEMENT
    lags_s: Mapping[str, float] = field(default_factory=dict)

    name = "frequency"
    unit = "Hz"

    def __post_init__(self) -> None:
        for name in self.lags_s:
            if name not in self.excitation.amplitudes:
                moving = ", ".join(self.excitation.amplitudes) or "no input"
                raise ExcitationError(f"lag of input {name!r}: the excitation moves {moving}")

    def at(self, value: float) -> tuple[Model, Harmonic]:
        """The test at a frequency (Hz)."""
        if not value > 0:
            raise ExcitationError(f"frequency: {value!r} Hz received; a positive finite number is needed")
        given = self.excitation
        factor = (given.frequency_hz / value) ** self.held.order
        turn = -2j * np.pi * (value - given.frequency_hz)
        amplitudes = {
            name: factor * amplitude * (np.exp(turn * self.lags_s[name]) if name in self.lags_s else 1.0)
            for name, amplitude in given.amplitudes.items()
        }
        return self.model, Harmonic(value, amplitudes)

    @cached_property
    def _by_inputs(self) -> BoundFunction:
        return _by_inputs(self.model)

    def slope(self, equations: HarmonicEquations, arguments: Array, value: float) -> Array:
        """Exact derivative of the packed residual by the frequency."""
        model, n = equations.model, equations.model.size
        amplitudes = equations.excitation.vector(model)
        lags = np.array([self.lags_s.get(u.name, 0.0) for u in model.system.inputs])
        change = (-self.held.order / value - 2j * np.pi * lags) * amplitudes
        rates = 2j * np.pi * (amplitudes + value * change)
        changes = np.zeros_like(arguments)
        changes[n : 2 * n] = arguments[n : 2 * n] / value
        changes[2 * n : 3 * n] = 2 * arguments[2 * n : 3 * n] / value
        changes[3 * n :] = equations.input_samples(np.concatenate([change, rates]))
        return equations.balanced(_directional(self._by_inputs, model, arguments, changes))


@dataclass(frozen=True, eq=False)
class AmplitudePath:
    """A test with other amplitudes; the parameter is a factor on all of them, one for those given."""

    model: Model
    excitation: Harmonic

    name = "amplitude_factor"
    unit = "1"

    def at(self, value: float) -> tuple[Model, Harmonic]:
        """The test with the amplitudes multiplied by a factor."""
        return self.model, self.excitation.scaled(value)

    @cached_property
    def _by_inputs(self) -> BoundFunction:
        return _by_inputs(self.model)

    def slope(self, equations: HarmonicEquations, arguments: Array, value: float) -> Array:
        """Exact derivative of the packed residual by the factor."""
        amplitudes = self.excitation.vector(equations.model)
        both = np.concatenate([amplitudes, 1j * self.excitation.angular_frequency * amplitudes])
        changes = np.zeros_like(arguments)
        changes[3 * equations.model.size :] = equations.input_samples(both)
        return equations.balanced(_directional(self._by_inputs, self.model, arguments, changes))


@dataclass(frozen=True, eq=False)
class ParameterPath:
    """A test of variants of a model; `parameter` is one of its parameters that is a number, in SI.

    Raises
    ------
    ValueError
        If the equations mention no such number.
    """

    model: Model
    excitation: Harmonic
    parameter: str

    def __post_init__(self) -> None:
        self.model.compiled.jacobian(self._names)

    @property
    def name(self) -> str:
        """The parameter."""
        return self.parameter

    @property
    def unit(self) -> str:
        """Its unit, in SI."""
        return self.model.parameters[self.parameter].unit

    def at(self, value: float) -> tuple[Model, Harmonic]:
        """The test of a variant."""
        return self.model.with_parameters({self.parameter: value}), self.excitation

    @cached_property
    def _names(self) -> list[str]:
        """The parameter, and the preloads that follow it."""
        preloads = [] if self.model.given_preloads is not None else self.model.system.preloads
        return [self.parameter, *(symbol.name for symbol in preloads)]

    def slope(self, equations: HarmonicEquations, arguments: Array, value: float) -> Array:
        """Derivative of the packed residual by the parameter, preloads included."""
        model = equations.model
        function = model.compiled.jacobian(self._names).bind(model.values)
        changes = self._changes(model, value)[:, None]
        return equations.balanced(_applied(function, model.size, arguments, changes))

    def _changes(self, model: Model, value: float) -> Array:
        """Derivative of the parameter and the preloads by the parameter."""
        if len(self._names) == 1:
            return np.ones(1)
        step = _STEP * (abs(value) or 1.0)
        values: dict[str, Array | float] = dict(model.parameters.flat())
        values[self.parameter] = np.array([value - step, value + step])
        found = solve_preloads(model.compiled, values, 2)
        return np.array([1.0, *((found[n][1] - found[n][0]) / (2 * step) for n in self._names[1:])])


def _by_inputs(model: Model) -> BoundFunction:
    """Derivatives of the residual, and of outputs below it, by inputs and their rates."""
    names = model.residual.function.arguments[3 * model.size :]
    return model.compiled.jacobian(names).bind(model.values)


def _directional(by_inputs: BoundFunction, model: Model, arguments: Array, changes: Array) -> Array:
    """Derivative of the residual along changes of all arguments, shape (n, samples)."""
    moved = _applied(model.residual_jacobian, model.size, arguments, changes)
    return moved + _applied(by_inputs, model.size, arguments, changes[3 * model.size :])


def _applied(derivative: BoundFunction, n: int, arguments: Array, changes: Array) -> Array:
    """First rows of a matrix of derivatives times changes, shape (n, samples)."""
    products = derivative(arguments) * changes[derivative.columns]
    return np.asarray((np.arange(n)[:, None] == derivative.rows).astype(float) @ products)

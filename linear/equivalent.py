"""The linear model of a harmonic motion of finite size: every table with its describing function."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chassym.derivation import Model
from chassym.linear.frequency_response import checked_frequencies, index_of, motion_per_input
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.linearisation import linearise
from chassym.linear.operating_point import OperatingPoint
from chassym.linear.slope_rule import DescribingFunction, mean_slope

Array = np.ndarray

_TOLERANCE = 1e-10
"""Relative change of the amplitudes at which they have settled."""

_AT_REST = 1e-12
"""Amplitude (m/s, rad/s, m or rad) below which a table is at rest, with the mean slope."""


def linearise_for_motion(
    source: Model | OperatingPoint, frequency_hz: float, amplitudes: Mapping[str, complex]
) -> LinearModel:
    """Linearise a model for a harmonic motion of its inputs, by describing functions that suit the motion.

    The amplitude at every table determines its slope, and the slopes determine the amplitudes: those are
    found that agree. A spring table may allow several such motions; the one next to small motions is sought.
    Higher harmonics, and the shift of the mean position by unsymmetric tables, are left out; a nonlinear
    steady state has both.

    Parameters
    ----------
    source
        As for `linearise`.
    frequency_hz
        Frequency (Hz).
    amplitudes
        Complex amplitude of every input that moves, by its name: a phase lead of phi is a factor exp(j phi).

    Returns
    -------
    LinearModel
        Its `slope_rules` state the amplitude found for every table.

    Raises
    ------
    LinearisationError
        If the amplitudes cannot be made to agree, an input is unknown, or as for `linearise`.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> car = load_model("quarter_car")
    >>> [round(linearise_for_motion(car, 1.5, {"road": a}).slopes["damper"]) for a in (1e-3, 2e-2)]
    [2445, 1822]
    """
    from scipy.optimize import root  # it brings in much: only for those who ask for it

    start = linearise(source, mean_slope)
    if not start.slopes:
        return start
    frequencies = checked_frequencies(frequency_hz)
    if len(frequencies) != 1:
        raise LinearisationError(f"frequency_hz: {len(frequencies)} received; one frequency is needed")
    s = 2j * np.pi * frequencies[0]
    moved = np.zeros(len(start.inputs), dtype=complex)
    for name, amplitude in amplitudes.items():
        moved[index_of("input", name, start.inputs)] = amplitude
    by_arguments = _table_variables(start.operating_point)

    def at_tables(linear: LinearModel) -> Array:
        """Amplitude of the variable of every table."""
        motion = motion_per_input(linear, frequencies)[0] @ moved
        arguments = np.concatenate([motion, s * motion, s**2 * motion, moved, s * moved])
        return np.maximum(np.abs(by_arguments @ arguments), _AT_REST)

    def equivalent(logarithms: Array) -> LinearModel:
        rules = zip(start.slopes, np.exp(logarithms), strict=True)
        return linearise(start.operating_point, {name: DescribingFunction(a) for name, a in rules})

    found = root(
        lambda logarithms: np.log(at_tables(equivalent(logarithms))) - logarithms,
        np.log(at_tables(start)),
        tol=_TOLERANCE,
    )
    if not np.abs(found.fun).max() < np.sqrt(_TOLERANCE):
        raise LinearisationError(
            f"amplitudes at the tables of {start.name!r} do not settle at {frequency_hz:g} Hz: "
            f"{np.abs(found.fun).max():.2g} of them is left; use a nonlinear steady state"
        )
    return equivalent(found.x)


def _table_variables(point: OperatingPoint) -> Array:
    """Derivatives of the variable of every table by the arguments, shape (tables, arguments)."""
    model = point.model
    function, count = model.compiled.statics_change, model.argument_count
    samples = np.zeros((len(function.arguments), count))
    samples[:count] = point.arguments[:, None]
    samples[count : 2 * count] = np.eye(count)
    changes = function.bind(model.values)(samples)
    return changes[model.size : model.size + len(model.system.knotted)]

"""Frequency responses as python-control objects."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from chassym.linear.frequency_response import FrequencyResponse
from chassym.linear.linear_model import LinearisationError

if TYPE_CHECKING:
    import control


def to_control_frequency_response(response: FrequencyResponse) -> control.FrequencyResponseData:
    """A frequency response as a python-control object with named signals, for its plots and arithmetic.

    Its inputs are the prescribed displacements alone: each moves with its rate. The state space of
    `to_control` has the rates as inputs of their own, so that one of its columns is a part of the response.
    Draw singular values by ``control.singular_values_response(data, data.omega).plot()``: handed to
    ``control.singular_values_plot``, the data would be drawn as if they were singular values.

    Parameters
    ----------
    response
        From `frequency_response` or `heave_response`, at ascending frequencies.

    Returns
    -------
    control.FrequencyResponseData
        The same response over angular frequency (rad/s), in the same units.

    Raises
    ------
    LinearisationError
        If the frequencies do not ascend.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> from chassym.linear import frequency_response, linearise
    >>> response = frequency_response(linearise(load_model("quarter_car")), [0.5, 1.0])
    >>> data = to_control_frequency_response(response)
    >>> data.input_labels, len(data.output_labels), data.omega
    (['road'], 5, array([3.14..., 6.28...]))
    """
    import control  # it takes a second to import: only for those who ask for it

    steps = np.diff(response.frequencies_hz)
    if (steps <= 0).any():
        place = int(np.argmax(steps <= 0))
        before, after = response.frequencies_hz[place : place + 2]
        raise LinearisationError(
            f"frequencies_hz of the response holds {after:g} after {before:g}; they must ascend"
        )
    return control.FrequencyResponseData(
        response.response,
        2 * np.pi * response.frequencies_hz,
        inputs=list(response.inputs),
        outputs=list(response.outputs),
    )

"""Numbers as they are printed in a report."""

from __future__ import annotations

import numpy as np

from chassym.derivation import Parameter

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 5) -> str:
    """A number with so many significant digits, and minus signs and powers of ten as they are printed.

    Examples
    --------
    >>> number(-0.123456), number(2.9e-13)
    ('−0.12346', '2.9·10⁻¹³')
    """
    if not np.isfinite(value):
        return "–" if np.isnan(value) else "∞"
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else ""
    return (power if power and mantissa == "1" else "·".join(filter(None, [mantissa, power]))).replace(
        "-", "−"
    )


def with_error(value: float, error: float) -> str:
    """A value and its error, rounded up, in as many digits as the error allows, five at most.

    Examples
    --------
    >>> with_error(5.718281, 0.00012), with_error(852.6, 19.0), with_error(0.75, 0.0)
    ('5.7183 ± 0.0002', '850 ± 20', '0.75')
    """
    if not np.isfinite(value) or not error > 0:
        return number(value)
    leading = np.floor(np.log10(abs(value))) if value else 0.0
    decimals = int(min(-np.floor(np.log10(error)), 4 - leading))
    last = 10.0**-decimals
    rounded = np.ceil(error / last - 1e-9) * last
    shown = max(decimals, 0)
    return f"{round(value, decimals):.{shown}f} ± {rounded:.{shown}f}".replace("-", "−")


def parameter_value(parameter: Parameter) -> str:
    """A parameter's value in SI.

    Examples
    --------
    >>> parameter_value(Parameter("k", (1.0, 2.5), "N/m", "rate", "measured"))
    '[1, 2.5]'
    """
    if isinstance(parameter.value, tuple):
        return "[" + ", ".join(number(each, 8) for each in parameter.value) + "]"
    return number(parameter.value, 8)

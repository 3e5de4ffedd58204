"""Rig tests from TOML files: the built-in ones by name, anybody's own by path; every key is checked.

A file holds ``name``, ``description``, ``source``, ``frequency`` and one or more motions::

    name = "one wheel"
    description = "A single pad moves up and down, the tyre side to side a quarter of a period later."
    source = "own"
    frequency = "2 Hz"            # or "[1, 2, 5] Hz", or { from = "0.5 Hz", to = "15 Hz", step = "0.5 Hz" }

    [[motion]]
    pads = "front_left"           # a place, a part of one ("front", "left"), "all", or a list of these
    direction = "vertical"        # or "lateral", "longitudinal"
    amplitude = "25 mm"           # or of velocity, "0.1 m/s", or acceleration, "0.3 m/s^2"

    [[motion]]
    pads = "front_left"
    direction = "lateral"
    amplitude = "5 mm"
    phase = "-90 deg"             # or lag = "125 ms"

It may also hold ``extends``, the name of a built-in test whose keys it takes over where it has none of its
own; ``rear_lag``; ``body``, "free" or "held"; ``tyres``, "bonded" to the pads or "lifting" off;
``metrics``, a list of outputs; ``tolerance``; and ``[[rate]]`` with ``name``, ``of`` and ``over``, the slope
of one output over another.
"""

from __future__ import annotations

import difflib
import os
import re
import tomllib
from collections.abc import Collection, Mapping
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from chassym.derivation import ParameterDefinition, ParameterError
from chassym.derivation.quantity import parse_quantity, shown
from chassym.derivation.schema import ANY, INCREASING, POSITIVE, Domain, refusal
from chassym.nonlinear.rig.pads import DIRECTIONS
from chassym.nonlinear.rig.rig_test import ORDERS, Motion, Rate, RigTest
from chassym.nonlinear.steady.steady_state import SMALLEST_TOLERANCE

MOST_FREQUENCIES = 10_000
"""Most steps of a stepped sine."""

BODIES = {"free": False, "held": True}
"""Whether the body is held, by the word for it."""

TYRES = {"bonded": False, "lifting": True}
"""Whether tyres lift, by the word for it."""

_REQUIRED = ("name", "description", "source", "frequency", "motion")
_OPTIONAL = ("extends", "rear_lag", "body", "tyres", "metrics", "tolerance", "rate")
_MOTION = ("pads", "direction", "amplitude", "phase", "lag")
_RATE = ("name", "of", "over")
_RANGE = ("from", "to", "step")
_NONZERO = Domain("other than zero", lambda numbers: np.all(numbers != 0, axis=0))
_HERTZ = re.compile(r"[^a-zA-Z]*([eE][-+\d][^a-zA-Z]*)*\w*(hz|hertz)\s*", re.IGNORECASE)
_AMPLITUDES = "a displacement, velocity or acceleration such as '25 mm', '0.1 m/s' or '3 m/s^2'"


def rig_test_names() -> list[str]:
    """Names of the built-in tests."""
    return sorted(f.name.removesuffix(".toml") for f in _folder().iterdir() if f.name.endswith(".toml"))


def load_rig_test(test: str | Path) -> RigTest:
    """A test of the rig from its name or a TOML file.

    Raises
    ------
    ParameterError
        If there is no such test, or a key of the file is missing, unknown or has an impossible value; the
        message names file and key.

    Examples
    --------
    >>> twist = load_rig_test("warp")
    >>> twist.frequencies_hz, twist.amplitude, twist.amplitude_unit
    ((3.0,), 0.025, 'm')
    >>> load_rig_test("lateral").harmonic().amplitudes["front_left_pad_y"]
    0.016566013525522227
    """
    if str(test) in rig_test_names():
        return _parsed(_read(_folder() / f"{test}.toml", str(test)), str(test))
    if not os.path.isfile(test):
        raise ParameterError(
            f"test: received {shown(str(test))}, expected a file or one of {', '.join(rig_test_names())}"
        )
    return _parsed(_read(Path(test), str(test)), str(test))


def _folder() -> Traversable:
    return resources.files("chassym.nonlinear") / "rig_tests"


def _read(file: Traversable, origin: str) -> dict[str, Any]:
    """The contents of a file, with those of the built-in test it extends where it has none of its own."""
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise refusal(origin, "file", f"an error ({error.strerror})", "a readable TOML file") from error
    except (ValueError, RecursionError) as error:
        raise refusal(origin, "file", f"text that is not TOML ({error})", "a rig test in TOML") from error
    if "extends" not in document:
        return document
    name = document.pop("extends")
    if name not in rig_test_names() or name == origin:
        raise refusal(origin, "extends", shown(name), f"one of {', '.join(rig_test_names())}")
    return _read(_folder() / f"{name}.toml", name) | document


def _parsed(document: Mapping[str, Any], origin: str) -> RigTest:
    _check_keys(document, _REQUIRED, _OPTIONAL, origin, "")
    entries = _tables(document, "motion", origin)
    motions, units = zip(
        *(_motion(each, f"motion[{i}].", origin) for i, each in enumerate(entries)), strict=True
    )
    if len(set(units)) > 1:
        received = f"amplitudes in {', '.join(dict.fromkeys(units))}"
        raise refusal(
            origin, "motion", received, "amplitudes of one kind: displacement, velocity or acceleration"
        )
    rates = _tables(document, "rate", origin) if "rate" in document else []
    body, tyres = document.get("body", "free"), document.get("tyres", "bonded")
    return RigTest(
        name=_text(document, "name", origin),
        description=_text(document, "description", origin),
        source=_text(document, "source", origin),
        frequencies_hz=_frequencies(document["frequency"], origin),
        motions=motions,
        amplitude_unit=units[0],
        rear_lag_s=_number(document, "rear_lag", "s", origin, ANY),
        body_is_held=BODIES[_choice(body, "body", BODIES, origin)],
        tyres_lift=TYRES[_choice(tyres, "tyres", TYRES, origin)],
        metrics=_names(document["metrics"], "metrics", origin) if "metrics" in document else None,
        rates=tuple(_rate(each, f"rate[{i}].", origin) for i, each in enumerate(rates)),
        tolerance=checked_tolerance(document.get("tolerance", 1e-3), origin),
    )


def _motion(entry: Mapping[str, Any], place: str, origin: str) -> tuple[Motion, str]:
    """One motion and the unit of its amplitude."""
    _check_keys(entry, _MOTION[:3], _MOTION[3:], origin, place)
    given = entry["pads"]
    size, unit = _amplitude(entry["amplitude"], f"{place}amplitude", origin)
    motion = Motion(
        pads=_names([given] if isinstance(given, str) else given, f"{place}pads", origin),
        direction=_choice(entry["direction"], f"{place}direction", DIRECTIONS, origin),
        amplitude=size,
        phase_rad=_number(entry, "phase", "rad", origin, ANY, place),
        lag_s=_number(entry, "lag", "s", origin, ANY, place),
    )
    return motion, unit


def _rate(entry: Mapping[str, Any], place: str, origin: str) -> Rate:
    _check_keys(entry, _RATE, (), origin, place)
    return Rate(*(_text(entry, key, origin, place) for key in _RATE))


def _amplitude(given: object, key: str, origin: str) -> tuple[float, str]:
    """An amplitude and the unit of `ORDERS` that it is in."""
    text = _with_unit(given, key, origin, _AMPLITUDES)
    for unit in ORDERS:
        try:
            return _parse(ParameterDefinition(key, unit, _NONZERO), text, origin), unit
        except ParameterError:
            continue
    raise refusal(origin, key, shown(text), _AMPLITUDES)


def _frequencies(given: object, origin: str) -> tuple[float, ...]:
    """One frequency, a list, or those of a range."""
    if isinstance(given, dict):
        return _range(given, origin)
    text = _hertz(given, "frequency", origin)
    if not text.lstrip().startswith("["):
        return (_parse(ParameterDefinition("frequency", "Hz", POSITIVE), text, origin),)
    found = parse_quantity(ParameterDefinition("frequency", "Hz", INCREASING), text, origin)
    assert isinstance(found, tuple)
    if found[0] <= 0:
        raise refusal(origin, "frequency", shown(text), "frequencies greater than zero")
    return found


def _range(given: Mapping[str, Any], origin: str) -> tuple[float, ...]:
    _check_keys(given, _RANGE, (), origin, "frequency.")
    first, last, step = (
        _parse(
            ParameterDefinition(f"frequency.{key}", "Hz", POSITIVE),
            _hertz(given[key], f"frequency.{key}", origin),
            origin,
        )
        for key in _RANGE
    )
    if not last > first:
        raise refusal(origin, "frequency.to", f"{last:g} Hz", f"more than frequency.from, {first:g} Hz")
    count = (last - first) / step
    if not 1 <= count + 1e-9 <= MOST_FREQUENCIES:
        expected = f"one that makes 2 to {MOST_FREQUENCIES} frequencies"
        raise refusal(origin, "frequency.step", f"{step:g} Hz", expected)
    return tuple(float(round(first + k * step, 12)) for k in range(int(count + 1e-9) + 1))


def _hertz(given: object, key: str, origin: str) -> str:
    """Text in hertz, by name: radians per second have the same dimension."""
    text = _with_unit(given, key, origin, "text such as '3 Hz'")
    if not _HERTZ.fullmatch(text):
        raise refusal(origin, key, shown(text), "a frequency in Hz, such as '3 Hz'")
    return text


def _number(
    entry: Mapping[str, Any], key: str, unit: str, origin: str, domain: Domain, place: str = ""
) -> float:
    """A number in SI from text with a unit; zero if there is none."""
    if key not in entry:
        return 0.0
    name = f"{place}{key}"
    text = _with_unit(entry[key], name, origin, f"text with a unit, such as '0.2 {unit}'")
    return _parse(ParameterDefinition(name, unit, domain), text, origin)


def _parse(definition: ParameterDefinition, text: str, origin: str) -> float:
    value = parse_quantity(definition, text, origin)
    assert isinstance(value, float)
    return value


def _with_unit(given: object, key: str, origin: str, expected: str) -> str:
    """Text that ends in something other than a number."""
    if not isinstance(given, str) or re.fullmatch(r"[-+.,\d\seE\[\]]*", given):
        raise refusal(origin, key, shown(given), expected)
    return given


def checked_tolerance(given: object, origin: str) -> float:
    """A tolerance that steady states can be asked for.

    Raises
    ------
    ParameterError
        If it is not a number, or not in their range.
    """
    if isinstance(given, bool) or not isinstance(given, int | float) or not SMALLEST_TOLERANCE <= given < 1:
        expected = f"a number from {SMALLEST_TOLERANCE:g} to less than 1"
        raise refusal(origin, "tolerance", shown(given), expected)
    return float(given)


def _check_keys(
    entry: Mapping[str, Any], required: Collection[str], optional: Collection[str], origin: str, place: str
) -> None:
    known = [*required, *optional]
    for key in entry:
        if key not in known:
            near = [f"{place}{name}; known are " for name in difflib.get_close_matches(key, known, n=1)]
            expected = f"{''.join(near) or 'one of '}{', '.join(known)}"
            raise refusal(origin, f"{place}{key}", "an unknown key", expected)
    for key in required:
        if key not in entry:
            raise refusal(origin, f"{place}{key}", "nothing", "a value for it")


def _tables(document: Mapping[str, Any], key: str, origin: str) -> list[Mapping[str, Any]]:
    given = document[key]
    if not isinstance(given, list) or not given or not all(isinstance(each, dict) for each in given):
        raise refusal(origin, key, shown(given), f"one or more tables [[{key}]]")
    return given


def _text(entry: Mapping[str, Any], key: str, origin: str, place: str = "") -> str:
    text = entry[key]
    if not isinstance(text, str) or not text.strip():
        raise refusal(origin, f"{place}{key}", shown(text), "text")
    return text


def _names(given: object, key: str, origin: str) -> tuple[str, ...]:
    if not isinstance(given, list) or not given or not all(isinstance(each, str) and each for each in given):
        raise refusal(origin, key, shown(given), "names, one or more")
    return tuple(given)


def _choice(given: object, key: str, accepted: Collection[str], origin: str) -> str:
    if not isinstance(given, str) or given not in accepted:
        raise refusal(origin, key, shown(given), f"one of {', '.join(accepted)}")
    return given

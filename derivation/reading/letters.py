"""Which letter a symbol has in the field, and what is left of its name for the subscript."""

from __future__ import annotations

import re

import sympy
from sympy.core.alphabets import greeks

from chassym.derivation.body import Input
from chassym.derivation.joint import Coordinate, Step
from chassym.derivation.reading.typography import Glyph

WORDS = {
    "mass": ("m", ("kg",)),
    "inertia": ("I", ("kg*m^2",)),
    "stiffness": ("k", ("N/m", "N*m/rad")),
    "rate": ("k", ("N/m", "N*m/rad")),
    "damping": ("c", ("N*s/m", "N*m*s/rad")),
    "coefficient": ("c", ("N*s/m", "N*m*s/rad")),
    "force": ("F", ("N",)),
    "velocity": ("v", ("m/s",)),
    "gravity": ("g", ("m/s^2",)),
    "ratio": ("i", ("1",)),
    "length": ("l", ("m",)),
    "radius": ("r", ("m",)),
    "height": ("h", ("m",)),
    "width": ("b", ("m",)),
}
"""The letter of a parameter by a word of its name, and the units with which the word means that."""

UNITS = {
    "kg": "m",
    "kg*m^2": "I",
    "N/m": "k",
    "N*m/rad": "k",
    "N*s/m": "c",
    "N*m*s/rad": "c",
    "N": "F",
    "N*m": "M",
    "m": "l",
    "m/s": "v",
    "m/s^2": "a",
    "s": r"\tau",
    "rad": r"\alpha",
}
"""The letter of any other parameter by its unit."""

SAID = {
    "k": ("torsional stiffness", "spring"),
    "c": ("damper",),
    "i": ("lever ratio",),
    r"\tau": ("stiffness proportional damping",),
}
"""What a letter says besides the words that stand for it."""

ANGLES = {
    "roll": r"\varphi",
    "pitch": r"\theta",
    "yaw": r"\psi",
    "precession": r"\psi",
    "nutation": r"\theta",
    "spin": r"\varphi",
}
TURNS = {"x": r"\varphi", "y": r"\theta", "z": r"\psi"}
SLIDES = {"x": "surge", "y": "sway", "z": "bounce heave hop"}
TENSOR = re.compile("[xyz]{2}")

_MATHEMATICAL = re.compile(
    rf"({'|'.join(sorted(greeks, key=len, reverse=True))}|[A-Za-z])(?:_?(\d+)|_([A-Za-z]{{1,2}})|([a-z]))?"
)
_ENTRY = re.compile(r"(.*)\[(\d+)\]")


def parameter_glyph(name: str, unit: str) -> Glyph:
    """A letter by name and unit; by the name alone where the unit is empty."""
    entry = _ENTRY.fullmatch(name)
    stem, index = (entry[1], [entry[2]]) if entry else (name, [])
    if glyph := _mathematical(stem, index):
        return glyph
    parts = [part.replace("_", " ").strip() for part in stem.split(".")]
    everything = " ".join(parts)
    if unit in ("m", "") and parts[-1] in ("x", "y", "z") and not (unit == "" and _word(parts, unit)):
        return Glyph(parts[-1], " ".join(parts[:-1]), everything, ",".join(index))
    if parts[-1] in ("x", "y", "z") or TENSOR.fullmatch(parts[-1]):
        index = [parts.pop(), *index]
    word = _word(parts, unit)
    letter = WORDS[word][0] if word else UNITS.get(unit) or _initial(parts[-1])
    return Glyph(letter, _unsaid(parts, letter), " ".join(parts), ",".join(index))


def coordinate_glyph(coordinate: Coordinate, step: Step | None) -> Glyph:
    """The angles' usual letters, or that of the axis along or about which the coordinate moves."""
    if glyph := _mathematical(coordinate.name, []):
        return glyph
    words = coordinate.name.split("_")
    axis = "" if step is None else _axis(step)
    if words[-1] in ANGLES and (step is None or step.is_rotation):
        letter, said = ANGLES[words[-1]], [words[-1]]
    elif step is not None and axis:
        letter, said = (TURNS[axis], ["angle"]) if step.is_rotation else (axis, [axis, *SLIDES[axis].split()])
    else:
        letter, said = (r"\alpha", ["angle"]) if coordinate.unit == "rad" else ("q", [])
    return Glyph(letter, " ".join(word for word in words if word not in said), " ".join(words))


def input_glyph(given: Input) -> Glyph:
    """The letter u."""
    return _mathematical(given.name, []) or named_glyph("u", given.name)


def named_glyph(letter: str, name: str) -> Glyph:
    """A given letter, with the words of a name; an axis at its end stands apart."""
    words = name.split("_")
    index = words.pop() if len(words) > 1 and words[-1] in ("x", "y", "z") else ""
    return Glyph(letter, " ".join(words), " ".join(words), index)


def _mathematical(name: str, index: list[str]) -> Glyph | None:
    """What is a letter already: m, k_s, theta1."""
    match = _MATHEMATICAL.fullmatch(name)
    if match is None:
        return None
    letter, number, *suffixes = match.groups()
    words = next(filter(None, suffixes), "")
    return Glyph(sympy.latex(sympy.Symbol(letter)), words, name, ",".join([*filter(None, [number]), *index]))


def _word(parts: list[str], unit: str) -> str:
    """The last part of a name whose last word stands for a letter, if the unit does not contradict."""
    for part in reversed(parts):
        word = part.rpartition(" ")[2]
        if word in WORDS and unit in ("", *WORDS[word][1]):
            return word
    return ""


def _unsaid(parts: list[str], letter: str) -> str:
    """The parts of a name that its letter does not say; if it says all, those peculiar to this one."""
    standing = [word for word, (meant, _) in WORDS.items() if meant == letter]
    peculiar = [part for part in parts if part not in standing]
    return " ".join([part for part in peculiar if part not in SAID.get(letter, ())] or peculiar)


def _initial(part: str) -> str:
    return next((character for character in part if character.isascii() and character.isalpha()), "p")


def _axis(step: Step) -> str:
    """The axis x, y or z of a step, in either direction; empty for any other."""
    along = [name for name, component in zip("xyz", step.axis, strict=True) if component != 0]
    return along[0] if len(along) == 1 else ""

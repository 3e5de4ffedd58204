"""LaTeX of names, units and text: valid whatever a name contains, and no two names alike."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

RESERVED = ("T", "V", "D", "L", "M", "Q", "h")
"""Bare letters to which printed equations give a meaning of their own."""

_ACCENTS = ("{}", r"\dot{{{}}}", r"\ddot{{{}}}")
_CHARACTERS = {
    **{character: rf"\{character}" for character in "&%$#_{}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "\\": r"\textbackslash{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "\N{MINUS SIGN}": r"\ensuremath{-}",
    "\N{MICRO SIGN}": r"\ensuremath{\mu}",
    "\N{DEGREE SIGN}": r"\ensuremath{^{\circ}}",
    "\N{SUPERSCRIPT TWO}": r"\ensuremath{^{2}}",
    "\N{SUPERSCRIPT THREE}": r"\ensuremath{^{3}}",
    "\N{MIDDLE DOT}": r"\ensuremath{\cdot}",
    "\N{MULTIPLICATION SIGN}": r"\ensuremath{\times}",
}
_GREEK = re.compile(r"GREEK (SMALL|CAPITAL) LETTER (\w+)")
_LAST_WITH_GLYPH = 0x17F  # the end of Latin Extended-A, which LaTeX's own fonts have


@dataclass(frozen=True, eq=False)
class Glyph:
    """A letter with the words of its subscript: those that say what the letter does not, and all of them."""

    letter: str
    words: str
    all_words: str
    index: str = ""


@dataclass(frozen=True)
class Typeset:
    """A letter and its subscript, in LaTeX."""

    letter: str
    subscript: str

    def at(self, order: int) -> str:
        """As it is, with one dot for the rate, or with two for the acceleration."""
        subscript = f"_{{{self.subscript}}}" if self.subscript else ""
        return _ACCENTS[order].format(self.letter) + subscript


def typeset(glyphs: Sequence[Glyph]) -> dict[Glyph, Typeset]:
    r"""Typeset glyphs so that no two look alike: those that would get all their words, or then a number.

    >>> front, rear = Glyph("k", "front", "front spring"), Glyph("k", "rear", "rear spring")
    >>> [each.at(0) for each in typeset([front, rear, Glyph("k", "front", "front tyre")]).values()]
    ['k_{\\text{front spring}}', 'k_{\\text{rear}}', 'k_{\\text{front tyre}}']
    """
    found = {each: _typeset(each, each.words) for each in glyphs}
    for each in _alike(found):
        found[each] = _typeset(each, each.all_words)
    while alike := _alike(found):
        numbers: Counter[Typeset] = Counter()
        for each in alike:
            look = found[each]
            numbers[look] += 1
            found[each] = Typeset(look.letter, ",".join(filter(None, [look.subscript, f"({numbers[look]})"])))
    return found


def _alike(found: dict[Glyph, Typeset]) -> list[Glyph]:
    looks = Counter([*found.values(), *(Typeset(letter, "") for letter in RESERVED)])
    return [each for each, look in found.items() if looks[look] > 1]


def _typeset(glyph: Glyph, words: str) -> Typeset:
    shown = " ".join(words.split())  # TeX shows no space at an end and one for many
    text = rf"\text{{{escaped(shown)}}}" if shown else ""
    return Typeset(glyph.letter, ",".join(filter(None, [text, glyph.index])))


def escaped(text: str) -> str:
    r"""Text for LaTeX; what its fonts lack is given by its number.

    >>> print(escaped("50 % of a_b in φ"))
    50 \% of a\_b in \ensuremath{\phi}
    """
    return "".join(map(_character, text))


def _character(character: str) -> str:
    if character in _CHARACTERS:
        return _CHARACTERS[character]
    greek = _GREEK.fullmatch(unicodedata.name(character, ""))
    if greek is not None:
        name = greek[2].lower().replace("lamda", "lambda")
        return rf"\ensuremath{{\{name if greek[1] == 'SMALL' else name.capitalize()}}}"
    if character.isspace():
        return " "
    printable = character.isprintable() and ord(character) <= _LAST_WITH_GLYPH
    return character if printable else f"[U+{ord(character):04X}]"


def unit_latex(unit: str) -> str:
    r"""A unit for LaTeX's text.

    >>> print(unit_latex("kg*m^2"), unit_latex("N*m*s/rad"))
    $\mathrm{kg\,m^{2}}$ $\mathrm{N\,m\,s/rad}$
    """
    parts = re.split(r"(\*\*-?\d+|\^-?\d+|\*)", unit)
    written = []
    for part in parts:
        power = re.fullmatch(r"(?:\*\*|\^)(-?\d+)", part)
        written.append(rf"^{{{power[1]}}}" if power else r"\," if part == "*" else escaped(part))
    return rf"$\mathrm{{{''.join(written)}}}$" if unit else ""

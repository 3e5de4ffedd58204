"""The equations of motion as LaTeX: an article of its own, or a formula for a notebook."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING

import sympy

from chassym.derivation.reading.element_symbols import element_symbols
from chassym.derivation.reading.glossary import Entry, glossary
from chassym.derivation.reading.lagrange_form import is_short
from chassym.derivation.reading.typesetting import Typesetter, filled
from chassym.derivation.reading.typography import escaped, unit_latex
from chassym.derivation.reading.written_form import Row, straight_line_form, written_form

if TYPE_CHECKING:
    from chassym.derivation.equations_of_motion import EquationsOfMotion

PREAMBLE = r"""\documentclass{article}
\usepackage[utf8]{inputenc}
\usepackage[T1]{fontenc}
\usepackage[a4paper,margin=20mm]{geometry}
\usepackage{amsmath}
\usepackage{array}
\usepackage{longtable}
\usepackage{multicol}
\allowdisplaybreaks
\setlength{\parindent}{0pt}
"""

LENGTHS = "xyzlrhb"
"""Letters of constants that stand after others in a product."""

_BETWEEN_ROWS = " \\\\[1ex]\n"

LAGRANGE = (
    r"\frac{d}{dt} \frac{\partial T}{\partial \dot{q}_i} - \frac{\partial T}{\partial q_i} "
    r"+ \frac{\partial V}{\partial q_i} + \frac{\partial D}{\partial \dot{q}_i} = Q_i"
)


def to_latex(equations: EquationsOfMotion, entries: Mapping[sympy.Symbol, Entry] | None = None) -> str:
    r"""A complete article with the table of symbols and the equations; parameters stay symbols.

    A small model is written out: T, V and D, the elements' forces and one equation for every coordinate. A
    large one is given as it is evaluated: intermediate results in order, then M, h, Q, T, V and D.

    Parameters
    ----------
    equations
        What to write.
    entries
        Descriptions of the symbols: a model's `glossary`, which knows its parameters. By default what the
        equations alone tell.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> chain = load_model("torsion_chain")
    >>> article = to_latex(chain.equations, chain.glossary)
    >>> article.splitlines()[0], article.splitlines()[-1]
    ('\\documentclass{article}', '\\end{document}')
    """
    known = glossary(equations) if entries is None else entries
    title = escaped(equations.system.name.replace("_", " "))
    body = _written_out(equations, known) if is_short(equations) else _straight_line(equations, known)
    return (
        f"{PREAMBLE}\\title{{Equations of motion of {title}}}\n\\author{{}}\n\\date{{}}\n"
        f"\\begin{{document}}\n\\maketitle\n{body}\n\\end{{document}}\n"
    )


def displayed(equations: EquationsOfMotion) -> str:
    """What a notebook shows: the equations of a small model written out, or a line about a large one."""
    if not is_short(equations):
        words = escaped(equations.system.name.replace("_", " "))
        sizes = (
            f"{len(equations.coordinates)} coordinates, {len(equations.system.inputs)} inputs, "
            f"{len(straight_line_form(equations).steps)} intermediate results"
        )
        # in MathJax text is printed as it stands, so that the underscore has to be a mathematical one
        return rf"$\text{{{words}: {sizes}; all of them: }}\mathtt{{to\_latex}}\text{{(equations)}}$"
    form = written_form(equations)
    typesetter = _typesetter(equations, glossary(equations))
    lines = [_line(typesetter, row) for row in (*form.energies, *form.elements, *form.motion)]
    return "$\\displaystyle \\begin{aligned}\n" + _BETWEEN_ROWS.join(lines) + "\n\\end{aligned}$"


def _written_out(equations: EquationsOfMotion, entries: Mapping[sympy.Symbol, Entry]) -> str:
    form, typesetter = written_form(equations), _typesetter(equations, entries)
    printed = set().union(*(row.symbols for row in (*form.energies, *form.elements, *form.motion)))
    parts = [
        _section("Symbols", _symbol_table(entries, printed)),
        _section("Energies", _energies_text(equations) + _aligned(typesetter, form.energies)),
    ]
    if form.elements:
        parts.append(_section("Force elements", _aligned(typesetter, form.elements)))
    parts.append(_section("Equations of motion", _aligned(typesetter, form.motion)))
    return "\n".join(parts)


def _energies_text(equations: EquationsOfMotion) -> str:
    text = (
        "Kinetic energy $T$, potential energy $V$ and Rayleigh's dissipation function $D$ of Lagrange's "
        f"equations\n\\[ {LAGRANGE} \\]\n"
    )
    if any(equations.energies.applied):
        text += "The $Q_i$ are those of the forces that have neither an energy nor a dissipation function.\n"
    return text


def _straight_line(equations: EquationsOfMotion, entries: Mapping[sympy.Symbol, Entry]) -> str:
    form = straight_line_form(equations)
    letter = _unused_letter(entries)
    typesetter = _typesetter(
        equations, entries, {name: f"{letter}_{{{i}}}" for name, i in form.names.items()}
    )
    printed = set().union(*(row.symbols for row in (*form.steps, *form.results)))
    arguments = {symbol for c in equations.coordinates for symbol in (c.position, c.rate, c.acceleration)}
    order = ", ".join(f"${entries[c.position].latex}$" for c in equations.coordinates)
    intro = (
        "The equations of motion are $M \\ddot{q} + h = Q$ with a symmetric mass matrix $M$, of which the "
        f"upper half without zeros is given, and the coordinates $q$, in this order: {order}. The "
        f"intermediate results ${letter}_{{1}}$, ${letter}_{{2}}$, \\ldots{{}} stand in the order of "
        "evaluation. Kinetic energy $T$, potential energy $V$ and dissipation function $D$ come last.\n"
    )
    return "\n".join(
        [
            _section("Symbols", _symbol_table(entries, printed | arguments)),
            _section("Straight-line form", intro),
            _section("Intermediate results", _columns(typesetter, form.steps)),
            _section("Mass matrix, bias, forces and energies", _columns(typesetter, form.results)),
        ]
    )


def _unused_letter(entries: Mapping[sympy.Symbol, Entry]) -> str:
    """A letter for numbered results that no symbol with a number has."""
    used = {entry.latex.partition("_")[0] for entry in entries.values()}
    return next(
        letter for letter in ("x", "w", "e", r"\xi", r"\eta", r"\zeta", r"\mathcal{X}") if letter not in used
    )


def _typesetter(
    equations: EquationsOfMotion,
    entries: Mapping[sympy.Symbol, Entry],
    results: Mapping[sympy.Symbol, str] | None = None,
) -> Typesetter:
    """Numbered results first in products, then constants, gravity after masses, lengths, then what moves."""
    accelerations = {coordinate.acceleration for coordinate in equations.coordinates}
    rates = {coordinate.rate for coordinate in equations.coordinates}
    moving = {*equations.arguments, *element_symbols(equations).printed.values()}

    def rank(entry: Entry) -> int:
        if entry.symbol in moving:
            return 5 if entry.symbol in accelerations else 4 if entry.symbol in rates else 3
        return 2 if entry.latex[0] in LENGTHS else 1 if entry.latex == "g" else 0

    ranked = sorted(entries.values(), key=rank)
    return Typesetter({**(results or {}), **{entry.symbol: entry.latex for entry in ranked}})


def _line(typesetter: Typesetter, row: Row) -> str:
    """An equation in lines for an aligned environment."""
    left: list[str] = []
    for each in row.left:
        pieces = [each] if isinstance(each, str) else typesetter.terms(each)
        left += [f"+ {p}" if i == 0 and left and not p.startswith("-") else p for i, p in enumerate(pieces)]
    first, *rest = typesetter.terms(row.right)
    return filled([*(left or ["0"]), f"= {first}", *rest])


def _aligned(typesetter: Typesetter, rows: Iterable[Row]) -> str:
    lines = _BETWEEN_ROWS.join(_line(typesetter, row) for row in rows)
    return f"\\begin{{align*}}\n{lines}\n\\end{{align*}}"


def _columns(typesetter: Typesetter, rows: Iterable[Row]) -> str:
    """Equations one below the other in two columns, broken by TeX."""
    lines = []
    for row in rows:
        (left,) = row.left
        name = left if isinstance(left, str) else typesetter.latex(left)
        lines.append(f"${name} = {typesetter.latex(row.right)}$\\par")
    text = "\n".join(lines)
    return f"\\begin{{multicols}}{{2}}\\raggedright\\small\n{text}\n\\end{{multicols}}"


def _symbol_table(entries: Mapping[sympy.Symbol, Entry], printed: Collection[sympy.Symbol]) -> str:
    """The entries of the printed symbols, in a table that may be several pages long."""
    rows = "\n".join(_symbol_row(entry) for symbol, entry in entries.items() if symbol in printed)
    return (
        "\\begin{longtable}{@{}lp{0.27\\textwidth}lp{0.31\\textwidth}@{}}\n"
        "Symbol & Name & Unit & Description \\\\\n\\hline\n\\endhead\n"
        f"{rows}\n\\end{{longtable}}"
    )


def _symbol_row(entry: Entry) -> str:
    name = escaped(entry.symbol.name).replace(".", r".\allowbreak{}").replace(r"\_", r"\_\allowbreak{}")
    return (
        f"${entry.latex}$ & \\raggedright\\texttt{{{name}}} & {unit_latex(entry.unit)} & "
        f"\\raggedright\\arraybackslash {escaped(entry.description)} \\\\"
    )


def _section(title: str, text: str) -> str:
    return f"\\section*{{{title}}}\n{text}"

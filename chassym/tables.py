"""Tables and paragraphs for people: as wide as the terminal, 80 columns where there is none."""

from __future__ import annotations

import math
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table

from chassym.derivation.parameters import Parameters
from chassym.derivation.quantity import Value

if TYPE_CHECKING:
    from chassym.comparison import Comparison

MOST_COLUMNS = 100
"""Lines wider than this are tiring to read, however wide the terminal is."""

MOST_ROWS = 8
"""Topics with more statements than this are summed up in a line."""


def print_table(headings: Sequence[str], rows: Iterable[Sequence[RenderableType]]) -> None:
    """Print a table and an empty line; a heading begins with ``>`` over a column of numbers."""
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for heading in headings:
        number = heading.startswith(">")
        justify: Literal["left", "right"] = "right" if number else "left"
        table.add_column(heading.removeprefix(">"), justify=justify, overflow="fold", no_wrap=number)
    for row in rows:
        table.add_row(*row)
    console = _console()
    console.print(table, width=min(console.width, MOST_COLUMNS))
    print()


def print_paragraph(text: str, indent: str = "") -> None:
    """Print text, wrapped; its lines after the first are indented."""
    print(textwrap.fill(text, min(_console().width, MOST_COLUMNS), subsequent_indent=indent))


def print_parameters(parameters: Parameters) -> None:
    """Print values in SI with descriptions; then, for those marked, how an ambiguous source was read."""
    print_paragraph(f"{parameters.description} (model {parameters.schema.model})")
    rows = (
        (
            Group(each.name, Padding(each.description, (0, 0, 0, 2))),
            textwrap.fill(_value(each.value), 20),
            f"{each.unit} *" if each.reading else each.unit,
        )
        for each in parameters.values()
    )
    print_table(["name and description", ">value", "unit"], rows)
    names_by_reading: dict[str, list[str]] = {}
    for each in parameters.values():
        if each.reading:
            names_by_reading.setdefault(each.reading, []).append(each.name)
    if names_by_reading:
        print_paragraph("* How an ambiguous source was read:")
    for reading, names in names_by_reading.items():
        print_paragraph(f"{', '.join(names)}: {' '.join(reading.split())}", indent="  ")


def print_comparisons(comparisons: Sequence[Comparison]) -> None:
    """Print published values beside computed ones; of topics with many of them, how many agree."""
    by_topic: dict[str, list[Comparison]] = {}
    for each in comparisons:
        by_topic.setdefault(each.topic, []).append(each)
    rows = (
        (
            each.quantity,
            f"{each.published} {each.unit.removeprefix('1')}",
            with_error(each.computed, each.error),
            each.verdict,
        )
        for found in by_topic.values()
        if len(found) <= MOST_ROWS
        for each in found
    )
    print_table(["quantity", "published", ">computed", "verdict"], rows)
    for topic, found in by_topic.items():
        if len(found) > MOST_ROWS:
            agreeing = sum(each.verdict.startswith(("inside", "agrees")) for each in found)
            print_paragraph(f"{topic}: {agreeing} of {len(found)} statements confirmed")


def with_error(value: float, error: float) -> str:
    """A value to the first digit of its error, which is rounded up.

    Examples
    --------
    >>> with_error(5.718268, 0.00019972), with_error(3313.12, 0.0698), with_error(1.49308, 6e-12)
    ('5.7183 ± 0.0002', '3313.12 ± 0.07', '1.493080 ± 6e-12')
    """
    if not error > 0:
        return f"{value:.6g}"
    places = max(-math.floor(math.log10(error)), 0)
    bound = math.ceil(error * 10.0**places) / 10.0**places
    shown = f"{value:.{min(places, 6)}f}" if abs(value) >= 1e-6 else f"{value:.1g}"
    return f"{shown} ± {bound:.{places}f}" if places <= 6 else f"{shown} ± {error:.0e}"


@contextmanager
def progress_bar() -> Iterator[Callable[[str, float], None]]:
    """Give a function of what is being done and the fraction done; drawn on standard error in a terminal."""
    with Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        console=Console(stderr=True),
        transient=True,
        disable=not sys.stderr.isatty(),
    ) as progress:
        task = progress.add_task("", total=1.0)
        yield lambda doing, fraction: progress.update(task, description=doing, completed=fraction)


def _console() -> Console:
    return Console(markup=False, highlight=False, emoji=False)


def _value(value: Value) -> str:
    return f"[{', '.join(f'{one:.6g}' for one in value)}]" if isinstance(value, tuple) else f"{value:.6g}"

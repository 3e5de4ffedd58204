"""What `chassym modes` answers: as one JSON object, and as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from chassym.linear import LinearisationError, LinearModel, Mode, ModeKind, damped_modes, undamped_modes
from chassym.tables import print_paragraph, print_table

NAMED = 0.05
"""Least share of a mode's kinetic energy for a motion to be listed."""

MOST_NAMED = 3
"""Most motions that are listed of a mode."""

ROUNDED = 0.005
"""Half of the last digit of a share."""

GROWING = (ModeKind.DIVERGENCE, ModeKind.GROWING_OSCILLATION)
"""What an unstable vehicle does."""


def as_data(linear: LinearModel) -> dict[str, Any]:
    """The answer as one JSON object; without undamped frequencies where it would fall over undamped."""
    try:
        undamped = undamped_modes(linear).frequencies_hz.tolist()
    except LinearisationError:
        undamped = None
    return {
        "undamped_frequencies_hz": undamped,
        "modes": [
            {
                "frequency_hz": mode.frequency_hz,
                "damping_ratio": mode.damping_ratio,
                "name": mode.name,
                "kind": str(mode.kind),
                "eigenvalue": [mode.eigenvalue.real, mode.eigenvalue.imag],
                "kinetic_energy": dict(mode.energy),
            }
            for mode in damped_modes(linear)
        ],
        "damper_slope_rule": linear.slope_rule if linear.slopes else None,
        "damper_slopes": dict(linear.slopes),
    }


def print_modes(linear: LinearModel) -> None:
    """The answer as a table, with a warning where something would grow."""
    modes = damped_modes(linear)
    rows = [(*_numbers(mode), mode.name, _moving(mode)) for mode in modes]
    print_table([">Hz", ">damping ratio", "mode", "kinetic energy"], rows)
    print_paragraph("Frequencies and damping ratios are |l| / (2 pi) and -Re l / |l| of the eigenvalues l.")
    print_paragraph(linear.description)
    if any(share > 1 + ROUNDED for mode in modes for share in mode.energy.values()):
        print_paragraph("Shares above 100 % are balanced by negative ones of parts that lag behind.")
    print_growing(modes)


def print_growing(modes: Sequence[Mode]) -> bool:
    """A warning where something would grow, and whether there was one."""
    growing = [mode.name for mode in modes if mode.kind in GROWING]
    if growing:
        print_paragraph(f"WARNING: unstable: {', '.join(growing)} would grow.")
    return bool(growing)


def _numbers(mode: Mode) -> tuple[str, str]:
    """Frequency and damping ratio; what does not oscillate has a time constant instead."""
    if mode.kind in (ModeKind.DECAY, ModeKind.DIVERGENCE):
        return f"{mode.kind}", f"{mode.time_constant:.3g} s"
    return f"{mode.frequency_hz:.3f}", f"{mode.damping_ratio:z.4f}"


def _moving(mode: Mode) -> str:
    """The motions with the largest shares of the kinetic energy."""
    shares = sorted(mode.energy.items(), key=lambda item: item[1], reverse=True)
    return ", ".join(f"{motion} {share:.0%}" for motion, share in shares[:MOST_NAMED] if share >= NAMED)

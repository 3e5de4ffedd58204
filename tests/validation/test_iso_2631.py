"""ISO 2631-1:1997: frequency weightings against tables 3 and 4, totals and words against clauses 8 and C.2.3.

The tables print weighting factors in thousandths at the nominal centres of one-third octaves. Of the 188
values all but two, which are misprints, are reproduced to within one unit of the last digit.
"""

import math

import numpy as np
import pytest

from chassym.linear import LinearisationError
from chassym.linear.road.ride_comfort import (
    BACKREST_X,
    BACKREST_Y,
    BACKREST_Z,
    FEET_X,
    FEET_Z,
    SEAT_PITCH,
    SEAT_ROLL,
    SEAT_X,
    SEAT_YAW,
    SEAT_Z,
    WC,
    WD,
    WE,
    WF,
    WJ,
    WK,
    Weighting,
    comfort_words,
    total_value,
)

CENTRES = """
    0.02 0.025 0.0315 0.04 0.05 0.063 0.08 0.1 0.125 0.16 0.2 0.25 0.315 0.4 0.5 0.63 0.8 1 1.25 1.6 2 2.5
    3.15 4 5 6.3 8 10 12.5 16 20 25 31.5 40 50 63 80 100 125 160 200 250 315 400
""".split()  # noqa: SIM905

TABLES = {
    WK: (
        "0.1",
        "31.2 48.6 79.0 121 182 263 352 418 459 477 482 484 494 531 631 804 967 1039 1054 1036 988 902 768 "
        "636 513 405 314 246 186 132 88.7 54.0 28.5 15.2 7.90 3.98 1.95",
    ),
    WD: (
        "0.1",
        "62.4 97.3 158 243 365 530 713 853 944 992 1011 1008 968 890 776 642 512 409 323 253 212 161 125 100 "
        "80.0 63.2 49.4 38.8 29.5 21.1 14.1 8.63 4.55 2.43 1.26 0.64 0.31",
    ),
    WF: (
        "0.02",
        "24.2 37.7 59.7 97.1 157 267 461 695 895 1006 992 854 619 384 224 116 53.0 23.5 9.98 3.77 1.55 0.64 "
        "0.25 0.097",
    ),
    WC: (
        "0.1",
        "62.4 97.2 158 243 364 527 708 843 929 972 991 1000 1007 1012 1017 1022 1024 1013 974 891 776 647 "
        "512 409 325 256 199 156 118 84.4",
    ),
    WE: (
        "0.1",
        "62.5 97.5 159 245 368 536 723 862 939 941 880 772 632 512 409 323 253 202 160 125 100 80.1 62.5 "
        "50.0 39.9 31.6 24.7 19.4 14.8 10.5",
    ),
    WJ: (
        "0.1",
        "31.0 48.3 78.5 120 181 262 351 417 458 478 484 485 483 482 489 524 528 793 946 1017 1030 1026 1018 "
        "1012 1007 1001 991 972 931 843",
    ),
}
"""The first centre (Hz) and the factors in thousandths, from transcriptions of the tables."""

MISPRINTED = {(WD, "10"): 202, (WJ, "4"): 628}
"""Written 212 between 253 and 161, and 528 between 524 and 793, where the standard's own formulas give 201.7
and 628.1: a wrong digit each."""


def table() -> list:
    rows = []
    for weighting, (first, factors) in TABLES.items():
        start = CENTRES.index(first)
        for centre, factor in zip(CENTRES[start:], factors.split(), strict=False):
            rows.append(pytest.param(weighting, centre, factor, id=f"{weighting.name}-{centre}"))
    return rows


@pytest.mark.parametrize(("weighting", "centre", "factor"), table())
def test_weighting_factors_of_tables_3_and_4(weighting: Weighting, centre: str, factor: str) -> None:
    last_digit = 10.0 ** -len(factor.partition(".")[2])
    found = 1000 * abs(weighting.response(float(centre)))
    assert found == pytest.approx(MISPRINTED.get((weighting, centre), float(factor)), abs=last_digit)


@pytest.mark.parametrize("weighting", TABLES, ids=lambda weighting: weighting.name)
def test_all_but_a_few_factors_round_to_the_printed_digits(weighting: Weighting) -> None:
    first, factors = TABLES[weighting]
    rows = list(zip(CENTRES[CENTRES.index(first) :], factors.split(), strict=False))
    digits = [len(factor.partition(".")[2]) for _, factor in rows]
    found = [
        round(1000 * float(abs(weighting.response(float(c)))), d)
        for (c, _), d in zip(rows, digits, strict=True)
    ]
    wrong = [c for (c, factor), value in zip(rows, found, strict=True) if value != float(factor)]
    expected = {WK: ["1.25", "16"], WD: ["10"], WJ: ["4"]}.get(weighting, [])
    assert wrong == expected


@pytest.mark.parametrize("weighting", TABLES, ids=lambda weighting: weighting.name)
def test_the_control_system_is_the_same_filter(weighting: Weighting) -> None:
    system = weighting.to_control()
    frequencies = np.geomspace(0.02, 400, 60)
    np.testing.assert_allclose(
        system(2j * np.pi * frequencies), weighting.response(frequencies), rtol=1e-9, atol=1e-12
    )
    assert system.poles().real.max() < 0
    assert system.input_labels == ["acceleration"] and system.name == weighting.name


def test_asymptotes() -> None:
    """Acceleration-velocity transition and upward step in their limits, without the band's filters."""
    assert abs(WJ.response(30.0)) == pytest.approx(1, rel=0.005)
    assert abs(WK.response(0.9)) == pytest.approx((2.37 / 3.35) ** 2, rel=0.05)
    for weighting, corner in ((WD, 2.0), (WE, 1.0)):
        assert abs(weighting.response(25.0)) == pytest.approx(corner / 25.0, rel=0.01)


def test_factors_of_the_axes() -> None:
    """8.2.2.1 and 8.2.2.3, comfort of seated persons."""
    axes = (
        SEAT_X,
        SEAT_Z,
        SEAT_ROLL,
        SEAT_PITCH,
        SEAT_YAW,
        BACKREST_X,
        BACKREST_Y,
        BACKREST_Z,
        FEET_X,
        FEET_Z,
    )
    assert [axis.factor for axis in axes] == [1, 1, 0.63, 0.4, 0.2, 0.8, 0.5, 0.4, 0.25, 0.4]
    names = ["Wd", "Wk", "We", "We", "We", "Wc", "Wd", "Wd", "Wk", "Wk"]
    assert [axis.weighting.name for axis in axes] == names


def test_total_value() -> None:
    """8.2.3: a_v = sqrt(k_x^2 a_x^2 + k_y^2 a_y^2 + k_z^2 a_z^2)."""
    assert total_value([(0.2, 1.4), (0.1, 1.4), (0.5, 1.0)]) == pytest.approx(
        math.sqrt(0.28**2 + 0.14**2 + 0.25), rel=1e-14
    )


@pytest.mark.parametrize(
    ("total", "words"),
    [
        (0.0, ("not uncomfortable",)),
        (0.31, ("not uncomfortable",)),
        (0.4, ("a little uncomfortable",)),
        (0.6, ("a little uncomfortable", "fairly uncomfortable")),
        (0.7, ("fairly uncomfortable",)),
        (0.9, ("fairly uncomfortable", "uncomfortable")),
        (1.1, ("uncomfortable",)),
        (1.5, ("uncomfortable", "very uncomfortable")),
        (2.2, ("very uncomfortable", "extremely uncomfortable")),
        (30.0, ("extremely uncomfortable",)),
    ],
)
def test_words(total: float, words: tuple[str, ...]) -> None:
    assert comfort_words(total) == words


@pytest.mark.parametrize("total", [-0.1, math.nan])
def test_impossible_totals_are_refused(total: float) -> None:
    with pytest.raises(LinearisationError, match=r"total .* received; an acceleration of zero or more"):
        comfort_words(total)

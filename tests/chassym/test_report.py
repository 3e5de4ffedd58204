"""The report: one page that needs nothing else, data that read back as computed, and failures shown."""

import base64
import csv
import io
import math
import struct
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chassym import report
from chassym.printed import number, with_error
from chassym.report import picture, write_report
from chassym.rig_tests import Outcome
from chassym.study import StudyResults
from chassym.variants import PLACES

FIGURES = 8
EMPTY_IMAGE = "data:image/svg+xml;base64,"
LOADING = {"src", "href", "data", "poster", "srcset", "action", "background"}


class Page(HTMLParser):
    """Elements of a page, its text, and whether every element that is opened is closed."""

    EMPTY = frozenset({"meta", "img", "br"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.open: list[str] = []
        self.styles: list[str] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attributes}))
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        (self.styles if self.open and self.open[-1] == "style" else self.words).append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def folder(small_study: StudyResults, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with a report of the small study."""
    folder = tmp_path_factory.mktemp("reports") / "new" / "report"
    assert write_report(small_study, folder) == folder / "report.html"
    return folder


@pytest.fixture(scope="module")
def page(folder: Path) -> Page:
    """Give the page of the small study."""
    return Page((folder / "report.html").read_text(encoding="utf-8"))


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the figures out: drawing them takes most of the time."""
    monkeypatch.setattr(report, "_embedded", lambda figure: EMPTY_IMAGE)
    monkeypatch.setattr(report, "picture", lambda results: b"")


@pytest.fixture(scope="module")
def broken(small_study: StudyResults) -> StudyResults:
    """Give the small study with everything but the nominal tests failed."""

    def failed(outcome: Outcome) -> Outcome:
        return Outcome(outcome.test, {}, {}, math.nan, math.nan, "the iteration <went> astray & stopped")

    points = tuple(
        replace(p, amplitudes={}, minimum_patch_force=math.nan, reason="lost")
        for p in small_study.heave.points
    )
    return replace(
        small_study,
        heave=replace(small_study.heave, points=points),
        sensitivity=tuple(replace(each, outcome=failed(each.outcome)) for each in small_study.sensitivity),
        halved=tuple(replace(each, outcome=failed(each.outcome)) for each in small_study.halved),
        sweep=tuple(replace(each, outcome=failed(each.outcome)) for each in small_study.sweep),
        rereadings=tuple(replace(each, outcome=failed(each.outcome)) for each in small_study.rereadings),
    )


def rows(folder: Path, name: str) -> Iterator[dict[str, str]]:
    """Rows of a data file by the column's name."""
    return iter(list(csv.DictReader(io.StringIO((folder / name).read_text(encoding="utf-8")))))


# The page


def test_the_page_needs_nothing_else(folder: Path, page: Page) -> None:
    assert not page.open
    assert not {"script", "link", "iframe", "object", "embed", "base"} & {tag for tag, _ in page.elements}
    targets = {attributes["id"] for _, attributes in page.elements if "id" in attributes}
    for tag, attributes in page.elements:
        for name in LOADING & set(attributes):
            address = attributes[name]
            if tag == "img":
                assert address.startswith("data:image/svg+xml;base64,")
            elif address.startswith("#"):
                assert address[1:] in targets
            else:
                assert (folder / address).is_file()
    assert "://" not in (folder / "report.html").read_text(encoding="utf-8")
    assert all("url(" not in style and "@import" not in style for style in page.styles)


def test_every_figure_is_a_drawing_that_loads_nothing(page: Page) -> None:
    images = [attributes for tag, attributes in page.elements if tag == "img"]
    assert len(images) == FIGURES and all(image["alt"] for image in images)
    for image in images:
        drawing = ElementTree.fromstring(base64.b64decode(image["src"].partition(",")[2]))
        assert drawing.tag.endswith("svg")
        links = [
            value for each in drawing.iter() for name, value in each.attrib.items() if name.endswith("href")
        ]
        assert all(link.startswith("#") for link in links)


def test_the_page_says_what_was_found(page: Page, small_study: StudyResults) -> None:
    for each in small_study.comparisons:
        assert each.quantity in page.text and each.verdict in page.text and each.published in page.text
    for mode in small_study.modes:
        assert mode.name in page.text
    assert small_study.version in page.text and small_study.created.strftime("%Y-%m-%d") in page.text
    assert "mean_slope" in page.text
    assert "Not the reference car" not in page.text and "Not everything could be solved" not in page.text


def test_every_parameter_is_listed_and_every_reading_explained(page: Page, small_study: StudyResults) -> None:
    for name, parameter in small_study.parameters.items():
        assert f"{name} †" in page.text if parameter.reading else name in page.text
        assert " ".join(parameter.reading.split()) in page.text
        assert parameter.source in page.text


@pytest.mark.usefixtures("undrawn")
def test_equal_studies_make_equal_pages(small_study: StudyResults, tmp_path: Path) -> None:
    for name in ("first", "second"):
        write_report(small_study, tmp_path / name)
    for file in (tmp_path / "first").iterdir():
        assert file.read_bytes() == (tmp_path / "second" / file.name).read_bytes()


def test_equal_studies_make_equal_figures(small_study: StudyResults) -> None:
    record = small_study.tests["lateral"]
    with mpl.rc_context(report.STYLE):
        first, second = (report._embedded(report.waveform_figure(record)) for _ in range(2))
    assert first == second


@pytest.mark.usefixtures("undrawn")
def test_another_car_is_not_taken_for_the_reference(small_study: StudyResults, tmp_path: Path) -> None:
    parameters = small_study.parameters.replace({"gravity": 9.8}, origin="--set")
    other = replace(
        small_study,
        parameters=replace(parameters, description="<script>alert(1)</script>"),
        changed=("gravity",),
    )
    page = Page(write_report(other, tmp_path).read_text(encoding="utf-8"))
    assert "Not the reference car" in page.text and "gravity ‡" in page.text
    assert "script" not in {tag for tag, _ in page.elements}


def test_failures_are_shown_with_their_reasons(broken: StudyResults, tmp_path: Path) -> None:
    page = Page(write_report(broken, tmp_path).read_text(encoding="utf-8"))
    assert not page.open
    for what, reason in broken.failures:
        assert f"{what}: {reason}" in page.text
    assert len([tag for tag, _ in page.elements if tag == "img"]) == FIGURES
    sweep = list(rows(tmp_path, "stiffness_sweeps.csv"))
    assert {row["reason of failure"] for row in sweep} == {"the iteration <went> astray & stopped"}
    assert all(math.isnan(float(row["value"])) for row in sweep)
    assert {row["reason of failure"] for row in rows(tmp_path, "heave.csv")} == {"lost", ""}


@pytest.mark.usefixtures("undrawn")
def test_a_study_without_a_sweep_has_a_report(small_study: StudyResults, tmp_path: Path) -> None:
    bare = replace(small_study, sweep=(), plan=replace(small_study.plan, stiffnesses=()))
    assert write_report(bare, tmp_path).is_file()
    assert picture(bare).startswith(b"\x89PNG")


# The files


@pytest.mark.usefixtures("undrawn")
def test_files_are_replaced_and_nothing_is_left_over(small_study: StudyResults, tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("old")
    (tmp_path / "mine.txt").write_text("kept")
    write_report(small_study, tmp_path)
    names = {file.name for file in tmp_path.iterdir()}
    assert names == {
        *("mine.txt", "report.html", "stiffness_sweeps.png", "modes.csv", "wheel_rate.csv", "heave.csv"),
        *("lateral_waveforms.csv", "vertical_waveforms.csv", "metrics.csv", "sensitivity.csv"),
        *("stiffness_sweeps.csv", "readings.csv", "thesis.csv"),
    }
    assert (tmp_path / "report.html").read_text(encoding="utf-8") != "old"
    assert (tmp_path / "mine.txt").read_text() == "kept"


@pytest.mark.usefixtures("undrawn")
def test_a_write_that_fails_leaves_the_old_file(
    small_study: StudyResults, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_report(small_study, tmp_path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}

    def full(source: Path, target: Path) -> None:
        raise OSError("no space left")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match="no space"):
        write_report(replace(small_study, version="9.9"), tmp_path)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


def test_the_picture_is_small_and_wide_enough(small_study: StudyResults) -> None:
    image = picture(small_study)
    assert image.startswith(b"\x89PNG") and len(image) < 150_000
    width, _ = struct.unpack(">II", image[16:24])
    assert width >= 1000


def test_a_picture_leaves_the_settings_of_matplotlib_alone(small_study: StudyResults) -> None:
    with mpl.rc_context({"font.size": 7.25}):
        picture(small_study)
        assert mpl.rcParams["font.size"] == 7.25


# The data


def test_every_header_names_its_units(folder: Path) -> None:
    for file in folder.glob("*.csv"):
        header, *body = csv.reader(io.StringIO(file.read_text(encoding="utf-8")))
        assert len(set(header)) == len(header) and all(len(row) == len(header) for row in body) and body
        with_unit = [column for column in header if column.endswith(")") and " (" in column]
        assert with_unit or "unit" in header, file.name


def test_metrics_read_back(folder: Path, small_study: StudyResults) -> None:
    found = {(row["test"], row["quantity"]): row for row in rows(folder, "metrics.csv")}
    for name, record in small_study.tests.items():
        for metric, value in record.metrics.items():
            row = found[name, f"{metric} peak to peak"]
            assert (float(row["value"]), row["unit"]) == (value.value, value.unit)
            assert float(row["error estimate"]) == value.error
        patch = found[name, f"minimum vertical patch force ({record.contact.patch})"]
        assert float(patch["value"]) == record.contact.value
        assert float(found[name, "largest Floquet multiplier"]["value"]) == record.largest_multiplier


def test_variants_read_back(folder: Path, small_study: StudyResults) -> None:
    swept = {
        (row["test"], row["place"], float(row["stiffness (N m/rad)"]), row["metric"]): row
        for row in rows(folder, "stiffness_sweeps.csv")
    }
    scaled = {
        (row["test"], row["group"], float(row["factor (1)"]), row["metric"]): row
        for row in rows(folder, "sensitivity.csv")
    }
    reread = {(row["test"], row["reading"], row["metric"]): row for row in rows(folder, "readings.csv")}
    expected = [
        *(
            (swept[s.outcome.test, s.placement, s.stiffness, m], s.outcome, m)
            for s in (*small_study.sweep, *small_study.halved)
            for m in s.outcome.metrics
        ),
        *(
            (scaled[s.outcome.test, s.group, s.factor, m], s.outcome, m)
            for s in small_study.sensitivity
            for m in s.outcome.metrics
        ),
        *(
            (reread[r.outcome.test, r.reading, m], r.outcome, m)
            for r in small_study.rereadings
            for m in r.outcome.metrics
        ),
    ]
    assert len(expected) == len(swept) + len(scaled) + len(reread) == 3 * (2 * 3 * (3 + 1) + 16 + 4)
    for row, outcome, metric in expected:
        assert float(row["value"]) == outcome.metrics[metric].value
        assert float(row["error estimate"]) == outcome.metrics[metric].error
        assert float(row["change from nominal"]) == outcome.changes[metric].value
        assert float(row["error estimate of the change"]) == outcome.changes[metric].error
        assert float(row["minimum patch force (N)"]) == outcome.minimum_patch_force
        assert float(row["largest Floquet multiplier (1)"]) == outcome.largest_multiplier


def test_curves_read_back(folder: Path, small_study: StudyResults) -> None:
    for name, record in small_study.tests.items():
        table = list(rows(folder, f"{name}_waveforms.csv"))
        np.testing.assert_array_equal([float(row["time (s)"]) for row in table], record.time_s)
        for signal, values in record.waveforms.items():
            column = f"{signal} ({record.metrics[signal].unit})"
            np.testing.assert_array_equal([float(row[column]) for row in table], values)
    cycles = list(rows(folder, "wheel_rate.csv"))
    for loading, rates in small_study.wheel_rates.items():
        for rate in rates.values():
            chosen = [row for row in cycles if (row["loading"], row["wheel"]) == (loading, rate.wheel)]
            force = [float(row["vertical patch force (N)"]) for row in chosen]
            np.testing.assert_array_equal(force, rate.force)
            np.testing.assert_array_equal([float(row["wheel travel (m)"]) for row in chosen], rate.travel)


def test_heave_and_modes_read_back(folder: Path, small_study: StudyResults) -> None:
    table = list(rows(folder, "heave.csv"))
    stepped = [row for row in table if row["model"] == "nonlinear"]
    for row, point in zip(stepped, small_study.heave.points, strict=True):
        assert float(row["frequency (Hz)"]) == point.frequency_hz
        assert float(row["minimum patch force (N)"]) == point.minimum_patch_force
        for what, amplitude in point.amplitudes.items():
            assert float(row[f"{what} displacement amplitude (m)"]) == amplitude
    assert len(table) - len(stepped) == len(small_study.heave.linear_frequencies_hz)
    for row, mode in zip(rows(folder, "modes.csv"), small_study.modes, strict=True):
        assert row["mode"] == mode.name
        assert float(row["frequency (Hz)"]) == mode.frequency_hz
        assert float(row["damping ratio (1)"]) == mode.damping_ratio


def test_the_comparison_reads_back(folder: Path, small_study: StudyResults) -> None:
    for row, each in zip(rows(folder, "thesis.csv"), small_study.comparisons, strict=True):
        assert row["quantity"] == each.quantity and row["verdict"] == each.verdict
        np.testing.assert_equal(float(row["computed"]), each.computed)
        np.testing.assert_equal(float(row["thesis low"]), each.low)
        np.testing.assert_equal(float(row["thesis high"]), each.high)


def test_the_sweep_has_a_row_for_every_place(folder: Path) -> None:
    assert {row["place"] for row in rows(folder, "stiffness_sweeps.csv")} == set(PLACES)


# Printed numbers


@given(st.floats(1e-9, 1e9), st.floats(-9, 0), st.booleans())
def test_a_printed_interval_holds_the_true_one_up_to_its_last_digit(
    size: float, exponent: float, negative: bool
) -> None:
    value, error = (-size if negative else size), size * 10**exponent
    shown, shown_error = (float(part.replace("−", "-")) for part in with_error(value, error).split(" ± "))
    assert shown_error >= error * (1 - 1e-6)
    assert abs(shown - value) <= shown_error * (1 + 1e-6)


def test_numbers_that_are_none_are_printed_as_a_dash() -> None:
    assert number(math.nan) == "–" and with_error(math.nan, math.nan) == "–"
    assert number(1e9) == "10⁹" and number(-1.5e-7) == "−1.5·10⁻⁷"

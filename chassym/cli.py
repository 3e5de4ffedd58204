"""The command line: what is asked for, in words; what is answered, as a table or one JSON object.

What takes long to import is imported by the command that needs it, so that help and refusals come at once.
"""

from __future__ import annotations

import io
import json
import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from chassym import arguments, usage
from chassym.requested_test import AXES, TESTS, TYRES, find_test, find_vehicle

if TYPE_CHECKING:
    from pathlib import Path

    from chassym.derivation import EquationsOfMotion, Model

FAILED, WRONG_INPUT, INTERRUPTED = 1, 2, 130
"""Exit statuses: no result, an argument that cannot be accepted, Ctrl-C."""

WRITTEN_OUT = 4
"""Most degrees of freedom for which the equations are printed."""

app = typer.Typer(
    help="From a vehicle file to equations of motion, state space and the steady state of nonlinear tests.",
    add_completion=False,
    rich_markup_mode=None,
)

Vehicle = Annotated[str, typer.Argument(metavar="VEHICLE", help="A built-in vehicle, or a TOML file.")]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Change a parameter; without a unit in SI. Repeatable."),
]
Sections = Annotated[
    str | None, typer.Option(metavar="N", help="Body sections of a full car, 3 or more; 3 by default.")
]
Slopes = Annotated[
    str,
    typer.Option(
        metavar="RULE",
        help="Slope of damper tables: left, right, mean, secant(V), describing_function(A), statistical(S); "
        "rates in SI.",
    ),
]
TestName = Annotated[str, typer.Argument(metavar="|".join((*TESTS, "FILE.toml")), help="What the pads do.")]
Tolerance = Annotated[str | None, typer.Option(metavar="RATIO", help="Largest error, relative to a metric.")]
Tyres = Annotated[
    str | None, typer.Option(metavar="|".join(TYRES), help="Whether they leave the pads; bonded by default.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]


@app.command()
def study(
    vehicle: Vehicle = "sedan",
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="DIR", help="Folder of the report.")
    ] = "chassym-study",
    changes: Changes = None,
) -> None:
    """Derive, verify, run both tests, sweeps and sensitivities, and write a report."""
    folder = arguments.new_folder("--output", output)
    model = _load(vehicle, changes)
    from chassym.report import write_report
    from chassym.study import run_study
    from chassym.tables import print_comparisons, print_paragraph, progress_bar

    with progress_bar() as progress:
        results = run_study(model, progress)
        report = write_report(results, folder)
    print_comparisons(results.comparisons)
    print_paragraph(f"Report: {report}")


@app.command()
def parameters(vehicle: Vehicle = "sedan", changes: Changes = None, as_json: AsJson = False) -> None:
    """List a vehicle's parameters in SI, and where they come from."""
    found = _load(vehicle, changes).parameters
    if as_json:
        fields = ("value", "unit", "description", "source", "reading")
        _print_json({name: _fields(each, fields) for name, each in found.items()})
        return
    from chassym.tables import print_parameters

    print_parameters(found)


@app.command()
def equations(
    vehicle: Vehicle = "sedan",
    latex: Annotated[
        str | None, typer.Option(metavar="FILE.tex", help="Write them as a LaTeX article, with a glossary.")
    ] = None,
    sections: Sections = None,
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Derive the equations of motion and count their operations; write out small ones."""
    article = None if latex is None else arguments.new_file("--latex", latex, ".tex")
    model = _load(vehicle, changes, sections)
    derived, operations = model.equations, model.equations.operations
    if article is not None:
        _write_article(article, model)
    if as_json:
        counted = {"degrees_of_freedom": model.size, "operations": operations}
        _print_json(counted | {"derivation_s": derived.derivation_s})
        return
    from chassym.tables import print_paragraph, print_table

    rows = [
        ("degrees of freedom", str(model.size)),
        ("operations of mass matrix and bias", str(operations["mass_matrix_and_bias"])),
        ("operations of the whole right-hand side", str(operations["right_hand_side"])),
        ("time of the derivation", f"{derived.derivation_s:.2g} s"),
    ]
    print_table([f"equations of motion of {derived.system.name}", ">"], rows)
    print_paragraph(f"Coordinates: {', '.join(coordinate.name for coordinate in derived.coordinates)}")
    if model.size <= WRITTEN_OUT:
        _print_written_out(derived)
    if article is not None:
        print_paragraph(f"{article}: equations of motion as a LaTeX article")


def _print_written_out(derived: EquationsOfMotion) -> None:
    from chassym.tables import print_paragraph
    from chassym.written_equations import written_energies, written_equations

    energies = list(written_energies(derived))
    if energies:
        print_paragraph(
            "Kinetic energy T, potential energy V, Rayleigh's dissipation function D, where short:"
        )
    for left, right in energies:
        print_paragraph(f"{left} = {right}", indent="    ")
    print_paragraph(
        "M q'' = f. M is symmetric; F is the force with which an element resists, "
        "v the rate of its deflection."
    )
    for left, right in written_equations(derived):
        print_paragraph(f"{left} = {right}", indent="    ")


def _write_article(file: Path, model: Model) -> None:
    from chassym.derivation.files import replace_file
    from chassym.derivation.reading.latex import to_latex

    replace_file(file, to_latex(model.equations, model.glossary).encode())


@app.command()
def modes(
    vehicle: Vehicle = "sedan",
    slopes: Slopes = "mean",
    sections: Sections = None,
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Natural modes about the design position: frequency, damping, and what moves."""
    model = _load(vehicle, changes, sections)
    rule = arguments.slope_rule("--slopes", slopes)
    from chassym.linear import linearise
    from chassym.requested_modes import as_data, print_modes

    linear = linearise(model, rule)
    if as_json:
        _print_json(as_data(linear))
    else:
        print_modes(linear)


@app.command()
def bode(
    vehicle: Vehicle = "sedan",
    output: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What is measured: vertical acceleration, where there is one, by default. "
            "A wrong name lists all.",
        ),
    ] = None,
    input: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="What moves; heave is all pads, or the road, together. A wrong name lists all.",
        ),
    ] = "heave",
    lowest: Annotated[str, typer.Option("--from", metavar="HZ", help="Lowest frequency.")] = "0.1",
    highest: Annotated[str, typer.Option("--to", metavar="HZ", help="Highest frequency.")] = "30",
    points: Annotated[str, typer.Option(metavar="N", help="Number of frequencies.")] = "25",
    plot: Annotated[
        str | None, typer.Option(metavar="FILE", help="Draw it to a .png, .svg or .pdf file.")
    ] = None,
    slopes: Slopes = "mean",
    sections: Sections = None,
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Frequency response of the linear model: amplitude and phase of an output per unit of an input."""
    picture = None if plot is None else arguments.new_file("--plot", plot, ".png", ".svg", ".pdf")
    frequencies_hz = arguments.frequencies_hz(("--from", lowest), ("--to", highest), ("--points", points))
    model = _load(vehicle, changes, sections)
    rule = arguments.slope_rule("--slopes", slopes)
    from chassym.linear import linearise
    from chassym.requested_bode import Channel, as_data, draw, find_signals, print_bode

    signals = find_signals(model, output, input)
    channel = Channel(linearise(model, rule), *signals)
    if picture is not None:
        draw(channel, frequencies_hz, picture)
    if as_json:
        _print_json(as_data(channel, frequencies_hz))
    else:
        print_bode(channel, frequencies_hz, picture)


@app.command()
def test(
    name: TestName,
    vehicle: Annotated[
        str | None, typer.Argument(metavar="VEHICLE", help="A built-in vehicle, or a TOML file.")
    ] = None,
    vehicle_option: Annotated[
        str | None, typer.Option("--vehicle", metavar="VEHICLE", help="The same, as an option.")
    ] = None,
    frequency: Annotated[
        str | None, typer.Option(metavar="HZ", help="One frequency in Hz, also of a stepped sine.")
    ] = None,
    amplitude: Annotated[
        str | None,
        typer.Option(metavar="AMPLITUDE", help="Largest one, in m or with a unit; also m/s, m/s^2."),
    ] = None,
    lag: Annotated[str | None, typer.Option(metavar="S", help="Delay of the rear pads.")] = None,
    tyres: Tyres = None,
    axes: Annotated[str, typer.Option(metavar="|".join(AXES), help="Axes of what is measured.")] = "ground",
    tolerance: Tolerance = None,
    plot: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Draw one period, or the stepped sine: .png, .svg or .pdf."),
    ] = None,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="FILE", help="Write a .csv table or .nc labelled arrays."),
    ] = None,
    sections: Sections = None,
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Steady state of a rig test: peak-to-peak values with their errors, patch force and stability."""
    arguments.choice("--axes", axes, AXES)
    picture = None if plot is None else arguments.new_file("--plot", plot, ".png", ".svg", ".pdf")
    file = None if output is None else arguments.new_file("--output", output, ".csv", ".nc")
    asked = find_test(
        name, frequency=frequency, amplitude=amplitude, lag=lag, tolerance=tolerance, tyres=tyres
    )
    model = _load(find_vehicle(vehicle, vehicle_option), changes, sections)
    from chassym.rig_test_command import run_requested

    answer = run_requested(asked, model, axes, picture, file, as_json=as_json)
    if answer is not None:
        _print_json(answer)


@app.command()
def sweep(
    name: TestName,
    vehicle: Vehicle = "sedan",
    varied: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="NAME=VALUES",
            help="A parameter, a group of them (times a factor), frequency_hz, amplitude_m or lag_s: "
            "from:to:count or a,b,c, with a unit or in SI, 10:1e6:5log at equal ratios, % of the nominal "
            "value; a+b=.. together. Repeatable: every combination.",
        ),
    ] = None,
    change: Annotated[
        str | None,
        typer.Option("--one-at-a-time", metavar="SHARE", help="Every parameter less and more, as by 25%."),
    ] = None,
    hypercube: Annotated[
        str | None, typer.Option("--latin-hypercube", metavar="N", help="So many points in the ranges.")
    ] = None,
    ranges: Annotated[
        list[str] | None,
        typer.Option("--range", metavar="NAME=LOW:HIGH", help="A range of the hypercube. Repeatable."),
    ] = None,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE", help="Results: a .nc or .zarr file.")
    ] = "sweep.nc",
    metrics: Annotated[
        list[str] | None,
        typer.Option("--metric", metavar="NAME", help="An output to measure peak to peak. Repeatable."),
    ] = None,
    tolerance: Tolerance = None,
    tyres: Tyres = None,
    jobs: Annotated[str | None, typer.Option(metavar="N", help="Processes; all cores by default.")] = None,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Scheduler of a Dask cluster; DASK_SCHEDULER_ADDRESS by default, if set."
        ),
    ] = None,
    sections: Sections = None,
    changes: Changes = None,
) -> None:
    """Steady state of many variants; the same command again goes on where it was stopped."""
    from chassym.sweep_command import SweepRequest, run_requested

    asked = SweepRequest(
        test=name,
        varied=varied or (),
        change=change,
        hypercube=hypercube,
        ranges=ranges or (),
        output=output,
        metrics=metrics,
        tolerance=tolerance,
        tyres=tyres,
        jobs=jobs,
        dask=dask,
    )
    run_requested(asked, lambda: _load(vehicle, changes, sections))


@app.command()
def export(
    file: Annotated[str, typer.Argument(metavar="FILE.mat", help="MAT-file for MATLAB, Octave or Simulink.")],
    vehicle: Vehicle = "sedan",
    inputs: Annotated[
        str, typer.Option(metavar="|".join(arguments.CONVENTIONS), help="What the plant's inputs are.")
    ] = arguments.CONVENTIONS[0],
    slopes: Slopes = "mean",
    sections: Sections = None,
    changes: Changes = None,
) -> None:
    """Write the state space about the design position, with names and units."""
    arguments.choice("--inputs", inputs, arguments.CONVENTIONS)
    path = arguments.new_file("FILE.mat", file, ".mat")
    model = _load(vehicle, changes, sections)
    rule = arguments.slope_rule("--slopes", slopes)
    from chassym.linear import input_conventions, linearise, write_mat
    from chassym.tables import print_paragraph

    linear = linearise(model, rule)
    write_mat(path, linear, getattr(input_conventions, inputs))
    print_paragraph(f"{path}: {linear.description}")


def main(words: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status.

    Parameters
    ----------
    words
        The arguments; those that the program was started with by default.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # where a sign cannot be shown another one will do
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # overflow ends in a refusal of one line
            return _run(sys.argv[1:] if words is None else list(words))
    except usage.UsageError as error:
        return _refuse(usage.explain(error, typer.main.get_command(app)), WRONG_INPUT)
    except (ValueError, RuntimeError) as error:
        if not type(error).__module__.startswith("chassym."):
            raise
        return _refuse(str(error), WRONG_INPUT if isinstance(error, ValueError) else FAILED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is not written yet goes nowhere
        return FAILED
    except OSError as error:
        return _refuse(f"{error.filename or 'standard output'}: {error.strerror}", FAILED)
    except KeyboardInterrupt:
        return _refuse("interrupted", INTERRUPTED)


def _run(words: list[str]) -> int:
    """Run a command by typer's parts instead of its `main`, which has its own ways with errors and Ctrl-C."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("chassym", words) as context:
            command.invoke(context)
    except typer.Exit as finished:
        return finished.exit_code
    print(end="", flush=True)  # what cannot be written is to be noticed here, not at exit
    return 0


def _refuse(message: str, status: int) -> int:
    print(f"chassym: {' '.join(message.split())}", file=sys.stderr)
    return status


def _load(vehicle: str, changes: Sequence[str] | None, sections: str | None = None) -> Model:
    given = arguments.changes(changes or [])
    count = None if sections is None else arguments.whole("--sections", sections)
    from chassym.derivation import load_model

    return load_model(vehicle, given, origin="--set", sections=count)


def _fields(value: object, names: Sequence[str]) -> dict[str, object]:
    return {name: getattr(value, name) for name in names}


def _print_json(answer: Mapping[str, object]) -> None:
    print(json.dumps(answer, indent=2, allow_nan=False))

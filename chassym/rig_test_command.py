"""Running a rig test that was asked for, and answering: on the screen, as a picture, as a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from chassym.derivation import Model
from chassym.nonlinear.rig import RigTest, run
from chassym.requested_test import find_metrics
from chassym.rig_test_answer import as_data, print_test
from chassym.tables import print_paragraph, progress_bar


def run_requested(
    test: RigTest, model: Model, axes: str, picture: Path | None, file: Path | None, *, as_json: bool
) -> dict[str, Any] | None:
    """Run a test on a vehicle; what cannot be meant is refused before slow work starts.

    Parameters
    ----------
    test, model, axes
        The test, the vehicle, and the axes of what is measured.
    picture, file
        Where to draw and to write; None for not at all.
    as_json
        Whether to give the answer as data instead of printing it.

    Raises
    ------
    ArgumentError, ParameterError
        If the vehicle lacks what the test moves or measures.
    NoPeriodicOrbitError
        If no steady state is found.
    OSError
        If a file cannot be written.
    """
    mounted = test.mounted(model)
    test.excitation(mounted)
    labels = find_metrics(mounted, test, axes)
    measured = replace(test, metrics=tuple(labels))
    with progress_bar() as progress:
        result = run(mounted, measured, progress=lambda share: progress(f"{test.name} test", share))
    if picture is not None:
        from chassym.nonlinear.rig.plots import save_rig_test

        save_rig_test(picture, result)
    if file is not None:
        from chassym.rig_test_files import write

        write(result, labels, file)
    if as_json:
        return as_data(result, labels)
    print_test(result, labels)
    for written in filter(None, (picture, file)):
        print_paragraph(f"{written}: written")
    return None

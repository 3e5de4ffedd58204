"""Pseudo-arclength steps along a branch of periodic orbits, around its folds.

A step goes along the branch's tangent and is corrected at right angles to it, with the exact derivatives by
unknowns and parameter, so that the system stays regular where the branch folds (Krack and Gross, Harmonic
Balance for Nonlinear Vibration Problems, 2019, chapter 4; Seydel, Practical Bifurcation and Stability
Analysis, 3rd ed., chapter 4).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.linalg import LinAlgError, LinAlgWarning, solve
from scipy.optimize import brentq

from chassym.derivation import ParameterError
from chassym.nonlinear.continuation.branch_steps import Point, Step
from chassym.nonlinear.continuation.paths import Path, place
from chassym.nonlinear.errors import NoPeriodicOrbitError
from chassym.nonlinear.excitation.excitation import ExcitationError
from chassym.nonlinear.harmonics import fourier
from chassym.nonlinear.harmonics.harmonic_balance import newton, relative_correction
from chassym.nonlinear.harmonics.harmonic_equations import HarmonicEquations
from chassym.nonlinear.orbits.fourier_orbit import FourierOrbit

Array = np.ndarray

_FEW, _MOST = 4, 8
"""Iterations of a correction that leave the length of steps as it is, and after which it is given up."""

_STRAIGHT = 0.9
"""Least cosine of the angle between the tangents at the ends of a step."""

_FIRST, _SHORTEST = 0.1, 1e-6
"""Length of the first step, and that below which a branch counts as lost, relative to the longest."""

_CORNER = 1e-3
"""Length of a step, relative to the longest, below which what is ahead may be a corner."""


class Tracer:
    """Makes steps along a branch.

    Parameters
    ----------
    path
        The family of tests.
    span
        Change of the parameter that counts as much as one of the whole motion.
    harmonics, subharmonic
        Of the orbits.
    tolerance
        Relative correction of the rates at which a point is balanced.
    fewest_samples
        Of the residual along an orbit.
    """

    def __init__(
        self,
        path: Path,
        span: float,
        harmonics: int,
        subharmonic: int = 1,
        tolerance: float = 1e-9,
        fewest_samples: int = 1,
    ) -> None:
        self.path, self._span, self._tolerance = path, span, tolerance
        self._harmonics, self._subharmonic = harmonics, subharmonic
        self._fewest_samples = fewest_samples
        self._largest = 0.0

    def orbit(self, point: Point) -> FourierOrbit:
        """The orbit at a point."""
        return self._equations(point.value).orbit(point.unknowns)

    def balanced(self, start: FourierOrbit, value: float, most: int = 25) -> FourierOrbit:
        """An orbit near another one, at a value of the parameter, by at most so many of Newton's iterations.

        Raises
        ------
        NoPeriodicOrbitError
            If Newton's method finds none.
        """
        coefficients = fourier.resized(start.coefficients, self._harmonics)
        guess = FourierOrbit(*self.path.at(value), coefficients, self._subharmonic)
        return newton(guess, self._tolerance, most, fewest_samples=self._fewest_samples).orbit

    def begin(self, orbit: FourierOrbit, value: float, direction: float) -> Point:
        """The point of a balanced orbit, headed for where the parameter changes in a direction."""
        unknowns = fourier.packed(orbit.coefficients)
        ahead = np.append(np.zeros(len(unknowns)), np.sign(direction))
        matrix, _ = self._linearised(unknowns, value, ahead)
        change = _solved(matrix, np.abs(ahead))
        return self._point(unknowns, value, change, self._span * float(np.linalg.norm(change[:-1])))

    def step(self, point: Point, length: float) -> tuple[Point, int]:
        """The point an arc length further on, and the iterations it took.

        Raises
        ------
        NoPeriodicOrbitError
            If the correction does not converge.
        """
        base, normal = np.append(point.unknowns, point.value), point.tangent / point.scales
        guess = base + length * point.tangent * point.scales
        for iteration in range(1, _MOST + 1):
            matrix, residual = self._linearised(guess[:-1], float(guess[-1]), normal)
            change = _solved(matrix, np.append(residual, normal @ (guess - base) - length))
            guess = guess - change
            correction = relative_correction(self._coefficients(change), self._coefficients(guess))
            if not correction < 10.0:
                break
            if max(correction, abs(change[-1]) / self._span) < self._tolerance:
                return self._arrived(guess, normal), iteration
        raise NoPeriodicOrbitError(f"{place(self.path, point.value)}: no orbit ahead")

    def march(self, point: Point, longest: float) -> Iterator[Step]:
        """Steps from a point on, without end; their lengths follow the branch's curvature.

        Where the branch turns sharply, as it does where a sample of the forces comes to a knot, a step of no
        length leads to the direction in which it goes on.

        Raises
        ------
        NoPeriodicOrbitError
            If the branch is lost.
        """
        length = _FIRST * longest
        while True:
            if (found := self._straight(point, length)) is not None:
                step, iterations = found
                yield step
                point = step.end
                length = min(longest, length * float(np.clip(_FEW / iterations, 0.5, 2.0)))
                continue
            if length < _CORNER * longest and (corner := self._corner(point, length)) is not None:
                yield corner
                point = corner.end
                continue
            length *= 0.3
            if length < _SHORTEST * longest:
                raise NoPeriodicOrbitError(
                    f"the branch is lost at {place(self.path, point.value)}: steps along it became "
                    "too short; take more harmonics, or check that forces are continuous there"
                )

    def pieces(self, step: Step) -> tuple[Step, ...]:
        """The step, cut in two at the fold that it goes around."""
        if not step.folds or step.is_corner:
            return (replace(step, ends_in_fold=step.folds),)
        turned = self._where(step, lambda p: p.turning, step.begin.turning, step.end.turning)
        fold = turned.end
        ahead = np.append(step.end.unknowns, step.end.value) - np.append(fold.unknowns, fold.value)
        return replace(turned, ends_in_fold=True), Step(
            fold, step.end, float(ahead @ (fold.tangent / fold.scales))
        )

    def landing(self, step: Step, value: float) -> Step:
        """As much of a step as comes to a value that the parameter passes."""
        ends = step.begin.value - value, step.end.value - value
        return self._where(step, lambda p: p.value - value, *ends)

    def _straight(self, point: Point, length: float) -> tuple[Step, int] | None:
        """A step over which the branch hardly turns, and its iterations; None if there is none."""
        with suppress(NoPeriodicOrbitError, ExcitationError, ParameterError, LinAlgError):
            end, iterations = self.step(point, length)
            step = Step(point, end, length)
            return (step, iterations) if step.straightness > _STRAIGHT else None
        return None

    def _corner(self, point: Point, reach: float) -> Step | None:
        """The change of direction at a corner within reach; None if no branch is found to go on from it.

        The derivatives on both sides of a corner agree along the surface between them, so that their minors
        across it do: the branch goes on where the determinant with its tangent keeps its sign.
        """
        normal = point.tangent / point.scales
        beyond = np.append(point.unknowns, point.value) + 2 * reach * point.tangent * point.scales
        with suppress(ExcitationError, ParameterError, LinAlgError):
            before, _ = self._linearised(point.unknowns, point.value, normal)
            after, _ = self._linearised(beyond[:-1], float(beyond[-1]), normal)
            sign = np.linalg.slogdet(before)[0] * np.linalg.slogdet(after)[0]
            ahead = sign * _solved(after, np.append(np.zeros(len(point.unknowns)), 1.0))
            turned = self._point(point.unknowns, point.value, ahead)
            return None if self._straight(turned, reach) is None else Step(point, turned, 0.0)
        return None

    def _where(self, step: Step, function: Callable[[Point], float], begin: float, end: float) -> Step:
        """As much of a step as it takes to where a function, of different signs at its ends, is zero."""
        values, points = {0.0: begin, step.length: end}, {0.0: step.begin, step.length: step.end}

        def at(length: float) -> float:
            if length not in points:
                points[length], _ = self.step(step.begin, length)
                values[length] = function(points[length])
            return values[length]

        root = float(brentq(at, 0.0, step.length, xtol=1e-13 * step.length, rtol=1e-12))
        at(root)
        return Step(step.begin, points[root], root)

    def _coefficients(self, place: Array) -> Array:
        """Complex coefficients among unknowns and parameter."""
        return fourier.unpacked(place[:-1], len(place) // (2 * self._harmonics + 1))

    def _equations(self, value: float) -> HarmonicEquations:
        test, orders = self.path.at(value), (self._harmonics, self._subharmonic)
        return HarmonicEquations(*test, *orders, self._fewest_samples)

    def _linearised(self, unknowns: Array, value: float, normal: Array) -> tuple[Array, Array]:
        """Derivative of residual and arc length by unknowns and parameter, and the residual."""
        equations = self._equations(value)
        arguments = equations.arguments(unknowns)
        matrix = np.empty((len(normal), len(normal)))
        matrix[:-1, :-1] = equations.jacobian(arguments)
        matrix[:-1, -1] = self.path.slope(equations, arguments, value)
        matrix[-1] = normal
        return matrix, equations.residual(arguments)

    def _arrived(self, place: Array, normal: Array) -> Point:
        """A point of the branch where it was come to with a normal."""
        matrix, residual = self._linearised(place[:-1], float(place[-1]), normal)
        ahead = _solved(matrix, np.append(np.zeros(len(residual)), 1.0))
        return self._point(place[:-1], float(place[-1]), ahead)

    def _point(self, unknowns: Array, value: float, ahead: Array, reach: float = 0.0) -> Point:
        """A point with its scales: the motion's size, but no less than a tenth of the largest so far.

        At rest it is how far the motion reaches over the span.
        """
        size = float(np.linalg.norm(unknowns))
        self._largest = max(self._largest, size, 0.1 * reach)
        scales = np.full(len(ahead), max(size, 0.1 * self._largest) or 1.0)
        scales[-1] = self._span
        tangent = ahead / scales
        return Point(unknowns, value, tangent / np.linalg.norm(tangent), scales)


def _solved(matrix: Array, right: Array) -> Array:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LinAlgWarning)
        return np.asarray(solve(matrix, right, overwrite_a=True, check_finite=False))

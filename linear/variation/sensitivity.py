"""Exact derivatives of linear models by parameters, and of what is computed from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eig

from chassym.derivation import Model
from chassym.linear.frequency_response import checked_frequencies, index_of, motion_per_input
from chassym.linear.input_conventions import displacements_and_rates
from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.linearisation import linearise, split
from chassym.linear.operating_point import OperatingPoint
from chassym.linear.slope_rule import SlopeRules, mean_slope
from chassym.linear.variation.changes import Changes

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """A linear model and the derivatives of its matrices by parameters.

    Preloads that are found follow the parameters so that the design position stays at rest; what they do not
    balance at the operating point moves it. The slopes of tables follow by their rules. Where a knot is at an
    end of a rule's motion, as one at rest is for a secant, the derivative by its place is that of one side.

    Attributes
    ----------
    linear
        The linear model.
    parameters
        Names, p of them; an entry of a list by a name such as ``"suspension.front.damper.force[0]"``.
    values
        Their values in SI, shape (p,).
    jacobian
        Derivatives of the derivatives of residual and outputs by q, q', q'', u, u', shape (p, n + outputs,
        arguments).
    slopes
        Derivatives of the slope of every table, shape (p,), by its element's name.
    """

    linear: LinearModel
    parameters: tuple[str, ...]
    values: Array
    jacobian: Array
    slopes: Mapping[str, Array]

    @cached_property
    def matrices(self) -> dict[str, Array]:
        """Derivative of every matrix of `LinearModel` by its attribute's name, shape (p, rows, columns)."""
        return split(self.jacobian, len(self.linear.coordinates), len(self.linear.inputs))

    @cached_property
    def _nominal(self) -> Array:
        """A itself."""
        return displacements_and_rates(self.linear).A

    @cached_property
    def _eigensystem(self) -> tuple[Array, Array, Array]:
        """Eigenvalues of A, and left and right eigenvectors."""
        values, left, right = eig(self._nominal, left=True, right=True)
        return values, left, right

    @cached_property
    def state_matrix(self) -> Array:
        """Derivative of A in x' = A x, shape (p, 2 n, 2 n)."""
        linear, change = self.linear, self.matrices
        n = len(linear.coordinates)
        rates = self._nominal[n:]
        forces = np.concatenate([change["stiffness"], change["damping"]], axis=2) + change["mass"] @ rates
        full = np.zeros((len(self.parameters), 2 * n, 2 * n))
        full[:, n:] = -np.linalg.solve(linear.mass, forces)
        return full

    def eigenvalues(self, eigenvalues: Sequence[complex]) -> Array:
        """Derivatives of eigenvalues, complex, shape (eigenvalues, p).

        With left and right vectors, w^H A = l w^H and A v = l v, it is dl = w^H dA v / (w^H v): Lancaster, On
        eigenvalues of matrices dependent on a parameter, Numerische Mathematik 6 (1964), 377-387.

        Parameters
        ----------
        eigenvalues
            Some of those of the linear model, as `damped_modes` gives them; NaN stands for zero and for
            multiple ones, which have no derivatives of their own.
        """
        wanted = np.asarray(eigenvalues, dtype=complex)
        values, left, right = self._eigensystem
        scale = np.abs(values).max()
        found = np.full((len(wanted), len(self.parameters)), np.nan + 0j)
        for row, eigenvalue in zip(found, wanted, strict=True):
            distance = np.abs(values - eigenvalue)
            index, second = np.argsort(distance)[:2]
            if distance[index] > _ITS_OWN * scale:
                raise LinearisationError(
                    f"eigenvalue {eigenvalue:.6g} 1/s is none of {self.linear.name!r}; the nearest is "
                    f"{values[index]:.6g} 1/s"
                )
            product = left[:, index].conj() @ right[:, index]
            if abs(eigenvalue) <= _ZERO * scale or distance[second] <= _ZERO * scale:
                continue
            row[:] = np.einsum("i,pij,j->p", left[:, index].conj(), self.state_matrix, right[:, index])
            row /= product
        return found

    def frequencies_hz(self, eigenvalues: Sequence[complex]) -> Array:
        """Derivatives of |eigenvalue| / (2 pi), shape (eigenvalues, p)."""
        values = np.asarray(eigenvalues)[:, None]
        return (values.conj() * self.eigenvalues(eigenvalues)).real / np.abs(values) / (2 * np.pi)

    def damping_ratios(self, eigenvalues: Sequence[complex]) -> Array:
        """Derivatives of -Re(eigenvalue) / |eigenvalue|, shape (eigenvalues, p)."""
        values, changes = np.asarray(eigenvalues)[:, None], self.eigenvalues(eigenvalues)
        size, size_change = np.abs(values), (values.conj() * changes).real / np.abs(values)
        return (values.real * size_change / size - changes.real) / size

    def response(self, output: str, inputs: Sequence[str], frequencies_hz: ArrayLike) -> Array:
        """Derivatives of the frequency response of one output to some inputs, complex.

        With P = s^2 M + s C + K and y = L P^-1 F + D it is dy = dL q + L P^-1 (dF - dP q) + dD, where
        q = P^-1 F: one solution for all parameters.

        Parameters
        ----------
        output
            Name of the output.
        inputs
            Names of inputs.
        frequencies_hz
            Frequencies (Hz), shape (frequencies,).

        Returns
        -------
        numpy.ndarray
            Shape (p, inputs, frequencies).

        Raises
        ------
        LinearisationError
            If there is no such output or input, or a frequency is negative or not finite.
        """
        linear = self.linear
        row = index_of("output", output, linear.outputs)
        columns = [index_of("input", name, linear.inputs) for name in inputs]
        frequencies = checked_frequencies(frequencies_hz)
        motion = motion_per_input(linear, frequencies)[:, :, columns]
        s = 2j * np.pi * frequencies[:, None, None]
        dynamic = s**2 * linear.mass + s * linear.damping + linear.stiffness
        seen = linear.output_by_coordinates[[row]] + s * linear.output_by_rates[[row]]
        seen = seen + s**2 * linear.output_by_accelerations[[row]]
        adjoint = np.linalg.solve(dynamic.swapaxes(1, 2), seen.swapaxes(1, 2)).swapaxes(1, 2)
        found = np.empty((len(self.parameters), len(columns), len(s)), dtype=complex)
        for index in range(len(self.parameters)):
            one = {name: matrices[index] for name, matrices in self.matrices.items()}
            forces = one["input_stiffness"][:, columns] + s * one["input_damping"][:, columns]
            forces = forces - (s**2 * one["mass"] + s * one["damping"] + one["stiffness"]) @ motion
            change = one["output_by_coordinates"][[row]] + s * one["output_by_rates"][[row]]
            change = change + s**2 * one["output_by_accelerations"][[row]]
            through = one["output_by_inputs"][[row]][:, columns]
            through = through + s * one["output_by_input_rates"][[row]][:, columns]
            found[index] = (adjoint @ forces + change @ motion + through)[:, 0].T
        return found


_ITS_OWN = 1e-6
"""Part of the largest eigenvalue within which a given one is taken for one of the model's."""

_ZERO = 1e-9
"""Part of the largest eigenvalue below which one is zero, or two are equal."""


def sensitivity(
    source: Model | OperatingPoint,
    parameters: Sequence[str] | None = None,
    slope_rule: SlopeRules = mean_slope,
) -> Sensitivity:
    """Linearise a model, and differentiate the linear model by parameters, exactly.

    Parameters
    ----------
    source, slope_rule
        As for `linearise`. The reach of a secant and the amplitude of a describing function stay as they are.
    parameters
        Names of parameters; of a list every entry is taken. All by default.

    Raises
    ------
    ParameterError
        If a parameter is unknown.
    LinearisationError
        As for `linearise`, or if the position at rest cannot follow the parameters, its stiffness being
        singular.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> found = sensitivity(load_model("quarter_car"), ["sprung.mass", "spring.rate"])
    >>> found.matrices["mass"][0]
    array([[1., 0.],
           [0., 0.]])
    """
    linear = linearise(source, slope_rule)
    point = linear.operating_point
    names = _numbers(point.model, parameters)
    changes = Changes(point, linear, slope_rule)
    total = changes.total(names)
    by_everything = changes.jacobian()
    jacobian = np.tensordot(total, by_everything, axes=(0, 0))
    columns = [changes.row(symbol.name) for symbol in point.model.system.slopes.values()]
    slopes = dict(zip(point.model.system.slopes, total[columns], strict=True))
    values = point.model.parameters.flat()
    return Sensitivity(linear, tuple(names), np.array([values[name] for name in names]), jacobian, slopes)


def _numbers(model: Model, parameters: Sequence[str] | None) -> list[str]:
    """Names of all numbers of some parameters."""
    flat = model.parameters.flat()
    if parameters is None:
        return list(flat)
    if isinstance(parameters, str):
        raise TypeError(f"parameters: a sequence of names is needed; the string {parameters!r} received")
    found: list[str] = []
    for name in parameters:
        entries = [each for each in flat if each == name or each.startswith(f"{name}[")]
        if not entries:
            raise model.parameters.schema.unknown(name, "sensitivity")
        found += entries
    return found

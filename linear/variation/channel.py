"""One output and one combination of inputs of many variants: its response, by modes and directly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chassym.linear.frequency_response import index_of
from chassym.linear.linear_model import LinearisationError
from chassym.linear.variation.variants import LinearVariants

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Channel:
    """One output and one combination of inputs of every variant.

    Attributes
    ----------
    dynamics
        K, C and M, shape (variants, n, n).
    forces
        Generalised forces by the inputs and by their rates, shape (variants, n).
    seen
        Derivatives of the output by q, q', q'', shape (variants, n).
    through
        What the output takes of the inputs and of their rates directly, shape (variants,).
    eigenvalues, vectors
        Of the state matrices, shapes (variants, 2 n) and (variants, 2 n, 2 n).
    """

    dynamics: tuple[Array, ...]
    forces: tuple[Array, ...]
    seen: tuple[Array, ...]
    through: tuple[Array, ...]
    eigenvalues: Array
    vectors: Array

    @classmethod
    def of(cls, linear: LinearVariants, output: str, amplitudes: Mapping[str, complex]) -> Channel:
        """The channel from inputs with complex amplitudes to an output, by their names.

        Raises
        ------
        LinearisationError
            If there is no such output or input.
        """
        first, matrices = linear.named, linear.matrices
        row = index_of("output", output, first.outputs)
        columns = [index_of("input", name, first.inputs) for name in amplitudes]
        moved = np.array(list(amplitudes.values()), dtype=complex)

        def combined(name: str) -> Array:
            return matrices[name][:, :, columns] @ moved

        return cls(
            (matrices["stiffness"], matrices["damping"], matrices["mass"]),
            (combined("input_stiffness"), combined("input_damping")),
            (
                matrices["output_by_coordinates"][:, row],
                matrices["output_by_rates"][:, row],
                matrices["output_by_accelerations"][:, row],
            ),
            (combined("output_by_inputs")[:, row], combined("output_by_input_rates")[:, row]),
            *linear.eigensystem,
        )

    def part(self, chosen: Array) -> Channel:
        """Some of the variants."""

        def of(matrices: tuple[Array, ...]) -> tuple[Array, ...]:
            return tuple(each[chosen] for each in matrices)

        return Channel(
            of(self.dynamics),
            of(self.forces),
            of(self.seen),
            of(self.through),
            self.eigenvalues[chosen],
            self.vectors[chosen],
        )

    def by_modes(self, s: Array) -> Array:
        """Response, shape (variants, s): coordinates are summed over modes, and outputs taken of them.

        An acceleration is s^2 times a coordinate here, which loses no digits at low frequencies.
        """
        n = self.vectors.shape[1] // 2
        accelerations = np.linalg.solve(self.dynamics[2], np.stack(self.forces, axis=-1))
        pushed = np.concatenate([np.zeros_like(accelerations), accelerations], axis=1)
        weights = np.linalg.solve(self.vectors, pushed)
        shapes = np.stack(self.seen, axis=1) @ self.vectors[:, :n]
        residues = shapes[:, :, None] * weights.swapaxes(1, 2)[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):  # such variants are solved directly
            poles = 1 / (s - self.eigenvalues[:, :, None])
            sums = residues.reshape(len(shapes), 6, 2 * n) @ poles
        return self._outputs(s, (sums[:, ::2] + s * sums[:, 1::2]).swapaxes(0, 1))

    def directly(self, s: Array) -> Array:
        """Response, shape (variants, s), by dynamic stiffness, frequency by frequency."""
        seen = np.empty((3, len(self.eigenvalues), len(s)), dtype=complex)
        for column, value in enumerate(s):
            dynamic = self.dynamics[0] + value * self.dynamics[1] + value**2 * self.dynamics[2]
            force = self.forces[0] + value * self.forces[1]
            try:
                motion = np.linalg.solve(dynamic, force[:, :, None])[:, :, 0]
            except np.linalg.LinAlgError:
                raise LinearisationError(
                    f"frequencies_hz holds {abs(value) / (2 * np.pi):g}, where the response of a variant is "
                    "infinite; leave this frequency out or add damping or a spring"
                ) from None
            seen[:, :, column] = [(each * motion).sum(axis=1) for each in self.seen]
        return self._outputs(s, seen)

    def _outputs(self, s: Array, seen: Array) -> Array:
        by_motion = seen[0] + s * seen[1] + s**2 * seen[2]
        return by_motion + self.through[0][:, None] + s * self.through[1][:, None]

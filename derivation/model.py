"""A model: equations compiled once, and the parameter values of one variant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy

from chassym.derivation.compilation.compiled_function import BoundFunction
from chassym.derivation.compilation.numeric import CompiledEquations
from chassym.derivation.compilation.point_function import PointFunction
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.equilibrium import design_residual, solve_preloads
from chassym.derivation.parameters import Parameters
from chassym.derivation.reading.glossary import Entry, glossary
from chassym.derivation.schema import ParameterError
from chassym.derivation.singularity import Singularity
from chassym.derivation.system import System
from chassym.derivation.table_numbers import TableNumbers, table_numbers


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """A system with numbers.

    Attributes
    ----------
    parameters
        The variant's parameters.
    compiled
        The system's functions, shared by all variants.
    given_preloads
        Preloads by name to use instead of those that hold the design position.
    """

    parameters: Parameters
    compiled: CompiledEquations
    given_preloads: Mapping[str, float] | None = None

    def __repr__(self) -> str:
        return f"<Model {self.system.name!r}: {self.size} coordinates, {self.parameters.description}>"

    def with_parameters(
        self, changes: Mapping[str, float | Sequence[float] | str] | Mapping[sympy.Symbol, float | str]
    ) -> Model:
        """A variant with other parameter values, by name or symbol; equations and machine code are shared.

        Raises
        ------
        ParameterError
            If a name is unknown, a value impossible, or a table of another length: that is another mechanism.
        """
        changed = self.parameters.replace({str(name): value for name, value in changes.items()})
        for name in self.parameters.flat().keys() ^ changed.flat().keys():
            table = name.partition("[")[0]
            raise ParameterError(
                f"override: {table}: received {np.size(changed[table].value)} entries, expected "
                f"{np.size(self.parameters[table].value)}; load the model with a table of another length"
            )
        return replace(self, parameters=changed)

    def scaled(self, *names: str, factor: float) -> Model:
        """A variant with some parameters, or all below a prefix, multiplied by a factor."""
        return replace(self, parameters=self.parameters.scaled(*names, factor=factor))

    @property
    def system(self) -> System:
        """Coordinates, inputs and outputs; of a mechanism also bodies and force elements."""
        return self.compiled.system

    @property
    def equations(self) -> EquationsOfMotion:
        """The symbolic equations of motion."""
        return self.compiled.equations

    @cached_property
    def glossary(self) -> Mapping[sympy.Symbol, Entry]:
        """For every symbol of the equations its typeset form, unit and description."""
        return glossary(self.equations, self.parameters)

    @cached_property
    def preloads(self) -> Mapping[str, float]:
        """Preload of every preloaded element (N or N m), by the preload's name."""
        if self.given_preloads is not None:
            return self.given_preloads
        found = solve_preloads(self.compiled, self.parameters.flat(), 1)
        return {name: float(preload[0]) for name, preload in found.items()}

    @cached_property
    def values(self) -> dict[str, float]:
        """Every number that the equations mention, by name.

        Raises
        ------
        MechanismError
            If the places of a table do not increase.
        """
        _ = self.tables
        return self.parameters.flat() | dict(self.preloads)

    @cached_property
    def tables(self) -> Mapping[str, TableNumbers]:
        """Knots and slopes of every table, by its element's name.

        Raises
        ------
        MechanismError
            If the places of a table do not increase.
        """
        return table_numbers(self.compiled, self.parameters.flat(), 1)

    @cached_property
    def size(self) -> int:
        """Degrees of freedom."""
        return len(self.system.coordinates)

    @property
    def argument_count(self) -> int:
        """Length of coordinates, rates, accelerations, inputs and input rates together."""
        return self.compiled.argument_count

    @property
    def output_names(self) -> list[str]:
        """Names of the outputs, in order."""
        return [output.name for output in self.system.outputs]

    @cached_property
    def residual(self) -> BoundFunction:
        """M q'' + h - Q."""
        return self.compiled.residual.bind(self.values)

    @cached_property
    def residual_jacobian(self) -> BoundFunction:
        """Derivatives of the residual by coordinates, rates and accelerations."""
        return self.compiled.residual_jacobian.bind(self.values)

    @cached_property
    def accelerations(self) -> BoundFunction:
        """q'' from coordinates, rates, inputs and input rates."""
        return self.compiled.accelerations.bind(self.values)

    @cached_property
    def right_hand_side(self) -> PointFunction:
        """Rates of the state from coordinates, rates, inputs and input rates."""
        return PointFunction(self.compiled.right_hand_side, self.values)

    @cached_property
    def held_right_hand_side(self) -> PointFunction:
        """The same with every law held on one side of its knots: 1 or 0 for each follows the arguments."""
        return PointFunction(self.compiled.held_right_hand_side, self.values)

    @cached_property
    def right_hand_side_jacobian(self) -> PointFunction:
        """Derivatives of the right-hand side by coordinates and rates, row by row, of the same arguments."""
        return PointFunction(self.compiled.right_hand_side_jacobian, self.values)

    @cached_property
    def state_knot_distances(self) -> PointFunction:
        """The knot distances, of the same arguments."""
        return PointFunction(self.compiled.state_knot_distances, self.values)

    @cached_property
    def outputs(self) -> BoundFunction:
        """Every output of the system."""
        return self.compiled.outputs.bind(self.values)

    @cached_property
    def knot_distances(self) -> BoundFunction:
        """Distance of the rates of tables from their knots."""
        return self.compiled.knot_distances.bind(self.values)

    @cached_property
    def singularities(self) -> BoundFunction:
        """Signed distance of every rotation sequence from its singularity."""
        return self.compiled.singularities.bind(self.values)

    def nearest_singularity(self, arguments: np.ndarray) -> Singularity | None:
        """The nearest approach to the singularity of a rotation sequence; None if there is no sequence.

        Parameters
        ----------
        arguments
            Coordinates, rates, accelerations, inputs and input rates, shape (arguments, samples), at
            successive instants: a change of sign between two of them is a passage through the singularity.
        """
        bodies = self.system.rotation_sequences
        if not bodies:
            return None
        signed = self.singularities(arguments)
        distances = np.abs(signed)
        distances[:, 1:][signed[:, 1:] * signed[:, :-1] < 0] = 0.0
        row, sample = np.unravel_index(np.nanargmin(distances), distances.shape)
        return Singularity(bodies[int(row)], float(distances[row, sample]), int(sample))

    @cached_property
    def design_residual(self) -> np.ndarray:
        """What is left of the static equilibrium at the design position, length n (N or N m)."""
        return design_residual(self.compiled, self.values, 1)[:, 0]

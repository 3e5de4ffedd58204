"""The linear model of a small system in symbols: matrices as functions of parameters, preloads, slopes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import TypeAlias

import numpy as np
import sympy
from sympy.polys.matrices import DomainMatrix

from chassym.derivation import EquationsOfMotion, Model
from chassym.derivation.reading.glossary import glossary
from chassym.derivation.reading.typesetting import Typesetter
from chassym.linear.linear_model import LinearisationError

Matrix: TypeAlias = sympy.ImmutableMatrix

LARGEST = 3000
"""Most arithmetic operations of all matrices together: about three printed pages."""

LARGEST_COUPLED = 5
"""Most coordinates that the mass matrix may couple where it has to be inverted."""

_INFINITE = (sympy.zoo, sympy.nan, sympy.oo, -sympy.oo)


@dataclass(frozen=True, eq=False, repr=False)
class SymbolicStateSpace:
    """M q'' + C q' + K q = B_u u + B_u' u' about the design position in symbols, and as a state space.

    Its matrices are those of `LinearModel`, and A, B, C, D those of the input convention
    `displacements_and_rates`. Symbols are parameters, preloads and, for every element with a table, its
    slope, named ``damper.slope`` of an element ``damper``.

    Attributes
    ----------
    equations
        What was linearised.
    mass, damping, stiffness
        M, C, K, shape (n, n).
    input_stiffness, input_damping
        B_u, B_u', shape (n, p).
    output_by_coordinates, output_by_rates, output_by_accelerations
        Derivatives of the outputs by q, q', q'', shape (m, n).
    output_by_inputs, output_by_input_rates
        Derivatives of the outputs by u, u', shape (m, p).
    latex_names
        How the symbols are typeset.
    """

    equations: EquationsOfMotion
    mass: Matrix
    damping: Matrix
    stiffness: Matrix
    input_stiffness: Matrix
    input_damping: Matrix
    output_by_coordinates: Matrix
    output_by_rates: Matrix
    output_by_accelerations: Matrix
    output_by_inputs: Matrix
    output_by_input_rates: Matrix
    latex_names: Mapping[sympy.Symbol, str]

    def __repr__(self) -> str:
        words = ", ".join(sorted(symbol.name for symbol in self.symbols))
        return f"<SymbolicStateSpace of {self.equations.system.name!r} in {words}>"

    @property
    def symbols(self) -> frozenset[sympy.Symbol]:
        """Parameters, preloads and slopes in the matrices."""
        return frozenset().union(*(each.free_symbols for each in self._second_order))

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the coordinates, then of their rates."""
        return _with_rates(tuple(each.name for each in self.equations.coordinates), "_rate")

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs, then of their rates."""
        return _with_rates(tuple(each.name for each in self.equations.system.inputs), "_rate")

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(each.name for each in self.equations.system.outputs)

    @property
    def A(self) -> Matrix:
        """Shape (2 n, 2 n). Refused with a LinearisationError, as B, C and D, if the inverse is too large."""
        n = self.mass.rows
        upper = sympy.zeros(n).row_join(sympy.eye(n))
        return Matrix(upper.col_join(self._accelerations[:, : 2 * n]))

    @property
    def B(self) -> Matrix:
        """Shape (2 n, 2 p)."""
        n = self.mass.rows
        by_inputs = self._accelerations[:, 2 * n :]
        return Matrix(sympy.zeros(*by_inputs.shape).col_join(by_inputs))

    @property
    def C(self) -> Matrix:
        """Shape (m, 2 n)."""
        n = self.mass.rows
        seen = self.output_by_coordinates.row_join(self.output_by_rates)
        return Matrix(seen + self._outputs_by_accelerations[:, : 2 * n])

    @property
    def D(self) -> Matrix:
        """Shape (m, 2 p)."""
        n = self.mass.rows
        through = self.output_by_inputs.row_join(self.output_by_input_rates)
        return Matrix(through + self._outputs_by_accelerations[:, 2 * n :])

    @cached_property
    def _accelerations(self) -> Matrix:
        """Derivatives of q'' by q, q', u, u': M^-1 [-K, -C, B_u, B_u'], every entry over one denominator."""
        forces = Matrix.hstack(-self.stiffness, -self.damping, self.input_stiffness, self.input_damping)
        return _product(_inverse(self.mass, self.equations.system.name), forces)

    @cached_property
    def _outputs_by_accelerations(self) -> Matrix:
        return _product(self.output_by_accelerations, self._accelerations)

    @property
    def _second_order(self) -> tuple[Matrix, ...]:
        return (
            self.mass,
            self.damping,
            self.stiffness,
            self.input_stiffness,
            self.input_damping,
            self.output_by_coordinates,
            self.output_by_rates,
            self.output_by_accelerations,
            self.output_by_inputs,
            self.output_by_input_rates,
        )

    def _repr_latex_(self) -> str:
        rows = [
            rf"{name} &= {self._typeset(matrix)}"
            for name, matrix in zip(("M", "C", "K", "B_u", r"B_{\dot{u}}"), self._second_order, strict=False)
        ]
        return "$\\displaystyle \\begin{aligned}\n" + " \\\\[1ex]\n".join(rows) + "\n\\end{aligned}$"

    def _typeset(self, matrix: Matrix) -> str:
        typesetter = Typesetter(self.latex_names)
        rows = [" & ".join(map(typesetter.latex, matrix.row(i))) for i in range(matrix.rows)]
        return "\\begin{bmatrix} " + r" \\ ".join(rows) + " \\end{bmatrix}"


def symbolic_state_space(source: Model | EquationsOfMotion) -> SymbolicStateSpace:
    """Linearise a small system about its design position, in symbols.

    That the design position is an equilibrium is not checked: preloads stand for themselves.

    Parameters
    ----------
    source
        A model, of whose numbers nothing is used, or equations of motion.

    Raises
    ------
    LinearisationError
        If the matrices have more than `LARGEST` operations, or a derivative is not finite.

    Examples
    --------
    >>> from chassym.derivation import load_model
    >>> quarter = symbolic_state_space(load_model("quarter_car"))
    >>> quarter.damping
    Matrix([
    [ damper.slope,               -damper.slope],
    [-damper.slope, damper.slope + tyre.damping]])
    >>> quarter.A[2, 0], quarter.B[3, 1]
    (-spring.rate/sprung.mass, tyre.damping/unsprung.mass)
    """
    equations = source.equations if isinstance(source, Model) else source
    parameters = source.parameters if isinstance(source, Model) else None
    n, p = len(equations.coordinates), len(equations.system.inputs)
    jacobian = Matrix(_at_rest(equations)).reshape(n + len(equations.system.outputs), 3 * n + 2 * p)
    ends = np.cumsum([0, n, n, n, p, p]).tolist()
    forces, outputs = (
        [rows[:, start:end] for start, end in zip(ends, ends[1:], strict=False)]
        for rows in (jacobian[:n, :], jacobian[n:, :])
    )
    return SymbolicStateSpace(
        equations=equations,
        mass=forces[2],
        damping=forces[1],
        stiffness=forces[0],
        input_stiffness=-forces[3],
        input_damping=-forces[4],
        output_by_coordinates=outputs[0],
        output_by_rates=outputs[1],
        output_by_accelerations=outputs[2],
        output_by_inputs=outputs[3],
        output_by_input_rates=outputs[4],
        latex_names={symbol: each.latex for symbol, each in glossary(equations, parameters).items()},
    )


def _at_rest(equations: EquationsOfMotion) -> list[sympy.Expr]:
    """The linearisation with all arguments zero, row by row.

    Zeros are put in assignment by assignment: most of what makes a large model's derivatives long vanishes.
    """
    flat = [entry for row in equations.linearisation for entry in row]
    known: dict[sympy.Symbol, sympy.Expr] = dict.fromkeys(equations.arguments, sympy.S.Zero)
    for symbol, expression in equations.program.required(flat).items():
        known[symbol] = _checked([expression.xreplace(known)], equations)[0]
    return _checked([sympy.sympify(entry).xreplace(known) for entry in flat], equations)


def _checked(entries: list[sympy.Expr], equations: EquationsOfMotion) -> list[sympy.Expr]:
    name = equations.system.name
    if any(entry.has(*_INFINITE) for entry in entries):
        raise LinearisationError(f"a derivative of {name!r} at the design position is not finite")
    size = sum(map(sympy.count_ops, entries))
    if size > LARGEST:
        raise LinearisationError(
            f"{name!r} linearised in symbols has {size} operations; at most {LARGEST} are accepted: take "
            "linearise, or a smaller model"
        )
    return entries


def _inverse(mass: Matrix, name: str) -> Matrix:
    """The inverse, block by block, with common factors cancelled.

    Raises
    ------
    LinearisationError
        If a block is larger than `LARGEST_COUPLED`, or singular.
    """
    found = sympy.zeros(*mass.shape)
    for block in mass.connected_components():
        if len(block) > LARGEST_COUPLED:
            raise LinearisationError(
                f"mass matrix of {name!r} couples {len(block)} coordinates; at most {LARGEST_COUPLED} are "
                "inverted in symbols: use mass, damping and stiffness as they are, or linearise"
            )
        adjugate, determinant = DomainMatrix.from_Matrix(mass.extract(block, block)).to_dense().adj_det()
        if not determinant:
            raise LinearisationError(
                f"mass matrix of {name!r} is singular for all parameters: a coordinate moves without "
                "inertia; give what it moves a mass or an inertia"
            )
        field = adjugate.domain.get_field()
        scale = field.one / field.convert_from(determinant, adjugate.domain)
        inverse = adjugate.convert_to(field).scalarmul(scale).to_Matrix()
        for row, column in product(range(len(block)), repeat=2):
            found[block[row], block[column]] = inverse[row, column]
    return Matrix(found)


def _product(left: Matrix, right: Matrix) -> Matrix:
    """Matrix product, every entry cancelled."""
    return Matrix((left @ right).applyfunc(sympy.cancel))


def _with_rates(texts: tuple[str, ...], suffix: str) -> tuple[str, ...]:
    """Names or units, and those of the rates."""
    return (*texts, *(text + suffix for text in texts))

"""Equations of motion of what is written in sympy's functions of time: a Lagrangian, or bodies with loads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import sympy
from sympy.core.function import AppliedUndef

from chassym.derivation.body import Input
from chassym.derivation.equations_of_motion import EquationsOfMotion
from chassym.derivation.errors import MechanismError
from chassym.derivation.joint import Coordinate
from chassym.derivation.lagrange import derive
from chassym.derivation.lagrangian import ExpressionOutput, Lagrangian, derivatives

if TYPE_CHECKING:
    from sympy.physics.mechanics import Particle, Point, ReferenceFrame, RigidBody, Vector

TimeFunction: TypeAlias = AppliedUndef
"""A function of time q(t), such as `sympy.physics.mechanics.dynamicsymbols` makes."""

Formula: TypeAlias = sympy.Expr | float

_Part = TypeVar("_Part", Coordinate, Input)
_TIME = sympy.Symbol("t")


def from_lagrangian(
    lagrangian: Formula,
    coordinates: Sequence[Coordinate | TimeFunction],
    *,
    name: str = "lagrangian",
    units: Mapping[TimeFunction, str] | None = None,
    dissipation: Formula = 0,
    forces: Mapping[Coordinate | TimeFunction, Formula] | None = None,
    inputs: Sequence[Input | TimeFunction] = (),
    outputs: Mapping[str, Formula | tuple[Formula, str]] | None = None,
) -> EquationsOfMotion:
    """Derive d/dt(dL/dq') - dL/dq + dD/dq' = Q from L = T - V.

    Expressions may contain functions of time and their derivatives, q(t) and q(t).diff(t), as well as the
    symbols of `Coordinate` and `Input` objects; a function means the coordinate or input of its name.

    Parameters
    ----------
    lagrangian
        L (J) in coordinates, inputs and their rates. Terms with a rate, once products of sums are multiplied
        out, make the kinetic energy of the result's `energies`, the others the potential energy.
    coordinates
        The generalised coordinates, in order. The linear stage takes their zero for the position of rest.
    name
        For reading.
    units
        SI units of coordinates and inputs given as functions; "1" for those not mentioned.
    dissipation
        Rayleigh's dissipation function D (W): half the power that linear dampers lose.
    forces
        Generalised forces Q of any other origin (N or N m), in coordinates, inputs and their rates.
    inputs
        What is prescribed; every expression may contain it and its first derivative.
    outputs
        What is measured, by name: an expression, in which accelerations may occur, or a pair of an expression
        and its SI unit.

    Raises
    ------
    MechanismError
        If a name is taken twice or unknown; an expression contains time itself, an unknown function or a
        derivative too high; a coordinate has no inertia; or an input's second derivative would enter.

    Examples
    --------
    A pendulum in a wind along the ground:

    >>> from sympy.physics.mechanics import dynamicsymbols
    >>> m, l, g = sympy.symbols("m l g", positive=True)
    >>> theta, wind = dynamicsymbols("theta wind")
    >>> T, V = m * l**2 * theta.diff() ** 2 / 2, -m * g * l * sympy.cos(theta)
    >>> moment = wind * l * sympy.cos(theta)
    >>> equations = from_lagrangian(T - V, [theta], forces={theta: moment}, inputs=[wind])
    >>> equations.program.expand(equations.residual)
    [g*l*m*sin(theta) + l**2*m*theta_acceleration - l*wind*cos(theta)]
    """
    stated = dict(units or {})
    own = tuple(_part(Coordinate, each, stated) for each in coordinates)
    prescribed = tuple(_part(Input, each, stated) for each in inputs)
    if stated:
        raise MechanismError(
            f"units: {_listed(stated)} received; expected functions of time out of coordinates and inputs"
        )
    plain = _Plain([*own, *prescribed])
    return derive(
        Lagrangian(
            name=name,
            lagrangian=plain("lagrangian", lagrangian),
            coordinates=own,
            inputs=prescribed,
            outputs=tuple(_output(plain, *each) for each in (outputs or {}).items()),
            dissipation=plain("dissipation", dissipation),
            forces=_in_order(plain, own, forces or {}),
        )
    )


def from_bodies(
    frame: ReferenceFrame,
    bodies: Sequence[RigidBody | Particle],
    coordinates: Sequence[TimeFunction],
    *,
    name: str = "bodies",
    units: Mapping[TimeFunction, str] | None = None,
    loads: Iterable[tuple[Point | ReferenceFrame, Vector]] = (),
    dissipation: Formula = 0,
    inputs: Sequence[Input | TimeFunction] = (),
    outputs: Mapping[str, Formula | tuple[Formula, str]] | None = None,
) -> EquationsOfMotion:
    """Derive the equations of motion of bodies of `sympy.physics.mechanics`.

    The Lagrangian is the sum of the bodies' kinetic energies less their `potential_energy`. A load's
    generalised force is its scalar product with the partial velocity dv/dq' of its point, or dw/dq' of its
    frame (Kane and Levinson, Dynamics: Theory and Applications, 1985, section 4.4).

    Parameters
    ----------
    frame
        The inertial frame; velocities in it must be known or follow from positions.
    bodies
        `RigidBody` and `Particle` objects, their velocities in coordinates and derivatives of coordinates:
        joints of sympy are to be given ``speeds=q.diff()``.
    loads
        Pairs of a point and a force (N), or of a frame and a torque (N m); `Force` and `Torque` objects and
        what the `to_loads` method of an actuator returns are such pairs.
    name, coordinates, units, dissipation, inputs, outputs
        As for `from_lagrangian`.

    Raises
    ------
    MechanismError
        As for `from_lagrangian`; or if a velocity is unknown or contains generalised speeds.

    Examples
    --------
    >>> from sympy.physics.mechanics import Particle, Point, ReferenceFrame, dynamicsymbols
    >>> m, g, z = *sympy.symbols("m g", positive=True), dynamicsymbols("z")
    >>> ground, origin = ReferenceFrame("ground"), Point("origin")
    >>> origin.set_vel(ground, 0)
    >>> place = origin.locatenew("place", z * ground.z)
    >>> stone = Particle("stone", place, m)
    >>> equations = from_bodies(ground, [stone], [z], loads=[(place, -m * g * ground.z)])
    >>> equations.program.expand(equations.residual)
    [g*m + m*z_acceleration]
    """
    known = {_name_of(each) for each in (*coordinates, *inputs)}
    energies = [_energy(body, frame, known) for body in bodies]
    projected = [_projected(load, frame, coordinates, known) for load in loads]
    forces = dict(zip(coordinates, map(sum, zip(*projected, strict=True)), strict=False))
    return from_lagrangian(
        sympy.Add(*energies),
        coordinates,
        name=name,
        units=units,
        dissipation=dissipation,
        forces=forces,
        inputs=inputs,
        outputs=outputs,
    )


def _energy(body: RigidBody | Particle, frame: ReferenceFrame, known: set[str]) -> sympy.Expr:
    """Kinetic less potential energy of a body."""
    from sympy.physics.mechanics import Particle, RigidBody  # slow to import: whoever comes here has it

    if not isinstance(body, RigidBody | Particle):
        raise MechanismError(f"bodies: {body!r} received; expected RigidBody and Particle objects")
    what = f"body {body.name!r}"
    _velocity(what, body.masscenter, frame, known)
    if isinstance(body, RigidBody):
        _velocity(what, body.frame, frame, known)
    return body.kinetic_energy(frame) - body.potential_energy


def _projected(
    load: tuple[Point | ReferenceFrame, Vector],
    frame: ReferenceFrame,
    coordinates: Sequence[TimeFunction],
    known: set[str],
) -> list[sympy.Expr]:
    """Generalised forces of a load on all coordinates."""
    from sympy.physics.mechanics import Vector

    if not isinstance(load, tuple) or len(load) != 2 or not isinstance(load[1], Vector):
        raise MechanismError(f"loads: {load!r} received; expected pairs (point, force) and (frame, torque)")
    place, vector = load
    velocity = _velocity(f"load on {place}", place, frame, known)
    return [velocity.diff(q.diff(q.args[0]), frame, var_in_dcm=False).dot(vector) for q in coordinates]


def _velocity(what: str, place: Point | ReferenceFrame, frame: ReferenceFrame, known: set[str]) -> Vector:
    """Velocity of a point, or angular velocity of a frame, free of generalised speeds."""
    from sympy.physics.mechanics import Point, ReferenceFrame

    if not isinstance(place, Point | ReferenceFrame):
        raise MechanismError(f"{what}: expected a Point or a ReferenceFrame")
    try:
        velocity = place.vel(frame) if isinstance(place, Point) else place.ang_vel_in(frame)
    except ValueError as error:
        raise MechanismError(f"{what}: {place} has no velocity in frame {frame}; set it") from error
    functions = {each for measures, _ in velocity.args for m in measures for each in m.atoms(AppliedUndef)}
    strange = sorted(str(each) for each in functions if each.func.__name__ not in known)
    if strange:
        raise MechanismError(
            f"{what}: its velocity contains {', '.join(strange)}, neither coordinate nor input; write "
            "velocities with derivatives of coordinates, q.diff(), not with generalised speeds"
        )
    return velocity


class _Plain:
    """Translates expressions in functions of time to the symbols of coordinates and inputs."""

    def __init__(self, parts: Sequence[Coordinate | Input]) -> None:
        self._symbols = {part.name: derivatives(part) for part in parts}

    def __call__(self, what: str, given: Formula) -> sympy.Expr:
        expression = _expression(what, given)
        if any(not isinstance(each.expr, AppliedUndef) for each in expression.atoms(sympy.Derivative)):
            expression = expression.doit()
        functions, rates = expression.atoms(AppliedUndef), expression.atoms(sympy.Derivative)
        rule = {each: self._symbol(what, each, 0) for each in functions}
        rule |= {each: self._symbol(what, each.expr, each.derivative_count) for each in rates}
        plain = expression.xreplace(rule)
        for moment in plain.free_symbols & {_TIME, *(each.args[0] for each in functions)}:
            raise MechanismError(
                f"{what} contains the time {moment}; make what depends on it an input, a function of time"
            )
        return plain

    def _symbol(self, what: str, function: sympy.Expr, order: int) -> sympy.Symbol:
        """The symbol of a function of time, or of its derivative of some order."""
        name = _name_of(function)
        if name not in self._symbols:
            raise MechanismError(
                f"{what}: {function} is neither a coordinate nor an input; there are {_listed(self._symbols)}"
            )
        symbols = self._symbols[name]
        if order >= len(symbols):
            raise MechanismError(
                f"{what} contains derivative {order} of {name!r}; expected derivative {len(symbols) - 1} at "
                "most"
            )
        return symbols[order]


def _expression(what: str, given: Formula) -> sympy.Expr:
    try:
        expression = sympy.sympify(given, strict=True)  # text is not evaluated
    except sympy.SympifyError:
        expression = None
    if not isinstance(expression, sympy.Expr) or expression.is_Matrix:
        raise MechanismError(f"{what}: {type(given).__qualname__} received; expected a sympy expression")
    return expression


def _name_of(given: object) -> str:
    """The name of a coordinate, an input or a function of time."""
    if isinstance(given, Coordinate | Input):
        return given.name
    if not isinstance(given, AppliedUndef) or len(given.args) != 1 or not given.args[0].is_Symbol:
        raise MechanismError(
            f"{given!r} received; expected a function of time as dynamicsymbols makes, a Coordinate or an "
            "Input"
        )
    return str(given.func.__name__)


def _part(kind: type[_Part], given: _Part | TimeFunction, units: dict[TimeFunction, str]) -> _Part:
    """A coordinate or an input; the unit of a function is taken out of those stated."""
    return given if isinstance(given, kind) else kind(_name_of(given), units.pop(given, "1"))


def _output(plain: _Plain, name: str, given: Formula | tuple[Formula, str]) -> ExpressionOutput:
    expression, unit = given if isinstance(given, tuple) else (given, "1")
    return ExpressionOutput(name, unit, plain(f"output {name!r}", expression))


def _in_order(
    plain: _Plain, coordinates: Sequence[Coordinate], forces: Mapping[Coordinate | TimeFunction, Formula]
) -> tuple[sympy.Expr, ...]:
    """The generalised force on every coordinate; zero where none is given."""
    named = {_name_of(on): force for on, force in forces.items()}
    names = [coordinate.name for coordinate in coordinates]
    for name in named.keys() - set(names):
        raise MechanismError(f"forces: {name!r} is no coordinate; expected one of {_listed(names)}")
    return tuple(plain(f"force on {name!r}", named.get(name, 0)) for name in names)


def _listed(names: Iterable[object]) -> str:
    return ", ".join(map(str, names)) or "none"

"""A mechanism: bodies on joints, ports with force elements, inputs that enter with their rate, outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import sympy

from chassym.derivation.body import Body, Input, Point
from chassym.derivation.characteristic import Characteristic, Knotted
from chassym.derivation.joint import Coordinate, Joint, MechanismError, weld
from chassym.derivation.output import Output
from chassym.derivation.port import Port
from chassym.derivation.vector import ZERO, diagonal, vector


@dataclass(frozen=True, eq=False)
class ForceElement:
    """A characteristic at a port, with a constant preload on top where it has one."""

    name: str
    port: Port
    characteristic: Characteristic
    preload: sympy.Symbol | None


@dataclass(eq=False)
class Mechanism:
    """A tree of rigid bodies with what acts on it and what is measured.

    Examples
    --------
    A mass on a spring whose foot is moved:

    >>> import sympy
    >>> from chassym.derivation import Linear, Mechanism, TravelPort, derive, prismatic
    >>> m, k, c, g = sympy.symbols("m k c g", positive=True)
    >>> mechanism = Mechanism("oscillator", gravity=g)
    >>> mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=m)
    >>> road = mechanism.add_input("road", "m")
    >>> travel = TravelPort(mechanism.point("foot", mass, (0, 0, 0)), mechanism.ground, "z", road)
    >>> spring = mechanism.add_force_element("spring", travel, Linear(k, c))
    >>> equations = derive(mechanism)
    >>> equations.mass_matrix, equations.program.expand(equations.generalized_forces)
    (((m,),), [-c*(-road_rate + z_rate) - k*(-road + z)])
    """

    name: str
    gravity: sympy.Expr
    bodies: list[Body] = field(default_factory=list, init=False)
    elements: list[ForceElement] = field(default_factory=list, init=False)
    inputs: list[Input] = field(default_factory=list, init=False)
    outputs: list[Output] = field(default_factory=list, init=False)
    _names: set[str] = field(default_factory=set, init=False)
    _symbols: set[str] = field(default_factory=set, init=False)

    @cached_property
    def ground(self) -> Body:
        """The inertial frame: Z up."""
        return Body("ground", None, weld(), ZERO, sympy.S.Zero, ZERO, diagonal(*ZERO))

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Every coordinate, in the order of the bodies and their joints' steps."""
        return tuple(step.coordinate for body in self.bodies for step in body.joint.steps)

    @property
    def preloads(self) -> tuple[sympy.Symbol, ...]:
        """The preloads that make the design position an equilibrium."""
        return tuple(element.preload for element in self.elements if element.preload is not None)

    @property
    def slopes(self) -> dict[str, sympy.Symbol]:
        """A symbol for the slope of every element whose characteristic has knots, by the element's name."""
        return {name: sympy.Symbol(f"{name}.slope", real=True) for name in self.knotted}

    @property
    def knotted(self) -> dict[str, Knotted]:
        """Every characteristic with knots, by its element's name."""
        return {e.name: e.characteristic for e in self.elements if isinstance(e.characteristic, Knotted)}

    def add_body(
        self,
        name: str,
        parent: Body,
        joint: Joint,
        origin: Sequence[sympy.Expr | float],
        *,
        mass: sympy.Expr | float = 0,
        mass_centre: Sequence[sympy.Expr | float] | None = None,
        inertia: Sequence[sympy.Expr | float] = (0, 0, 0),
    ) -> Body:
        """Add a body; mass centre at the joint unless given, inertia as principal moments (x, y, z)."""
        self._claim(name)
        if parent is not self.ground and parent not in self.bodies:
            raise MechanismError(
                f"body {name!r}: its parent {parent.name!r} is not in mechanism {self.name!r}; add it first"
            )
        for step in joint.steps:
            own = step.coordinate
            self._claim(own.name, own.position, own.rate, own.acceleration)
        centre = vector(origin if mass_centre is None else mass_centre)
        moments = diagonal(*vector(inertia))
        body = Body(name, parent, joint, vector(origin), sympy.sympify(mass), centre, moments)
        self.bodies.append(body)
        return body

    def point(self, name: str, body: Body, position: Sequence[sympy.Expr | float]) -> Point:
        """A point fixed to a body, by its design position."""
        if body is not self.ground and body not in self.bodies:
            raise MechanismError(
                f"point {name!r}: body {body.name!r} is not in mechanism {self.name!r}; add it first"
            )
        return Point(name, body, vector(position))

    def add_input(self, name: str, unit: str) -> Input:
        """Add a prescribed motion."""
        found = Input(name, unit)
        self._claim(name, found.position, found.rate)
        self.inputs.append(found)
        return found

    def add_force_element(
        self, name: str, port: Port, characteristic: Characteristic, *, preloaded: bool = False
    ) -> ForceElement:
        """Add a force law at a port, with the constant force that holds the design position if preloaded."""
        self._claim(name)
        preload = sympy.Symbol(f"{name}.preload", real=True) if preloaded else None
        self.elements.append(ForceElement(name, port, characteristic, preload))
        return self.elements[-1]

    def add_output(self, output: Output) -> None:
        """Add a measured quantity."""
        self._claim(output.name)
        self.outputs.append(output)

    def _claim(self, name: str, *symbols: sympy.Symbol) -> None:
        """Take a part's name, and the names of its symbols in the equations."""
        if name.startswith("_"):
            raise MechanismError(
                f"mechanism {self.name!r}: the name {name!r} begins with an underscore; those are kept for "
                "intermediate results"
            )
        taken = {symbol.name for symbol in symbols} & self._symbols
        if name in self._names or name == "ground" or taken:
            double = min(taken, default=name)
            raise MechanismError(
                f"mechanism {self.name!r}: the name {double!r} is taken; every part needs its own"
            )
        self._names.add(name)
        self._symbols |= {symbol.name for symbol in symbols}

"""A mechanism: bodies on joints, ports with force elements, inputs that enter with their rate, outputs."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import sympy

from chassym.derivation.body import (
    GROUND,
    AppliedForce,
    AppliedTorque,
    Body,
    Input,
    Point,
    rotation_sequence,
)
from chassym.derivation.characteristic import Actuator, Characteristic
from chassym.derivation.direction import Direction, unit_vector
from chassym.derivation.element import ForceElement
from chassym.derivation.errors import MechanismError
from chassym.derivation.inertia import Inertia, about_mass_centre, check_inertia, inertia_tensor
from chassym.derivation.joint import Coordinate, Joint
from chassym.derivation.names import Names
from chassym.derivation.output import Output
from chassym.derivation.port import Port, TravelPort
from chassym.derivation.references import references
from chassym.derivation.symbol_names import check_symbols
from chassym.derivation.table import Knotted, knotted_part
from chassym.derivation.validation import expect, place, scalar
from chassym.derivation.vector import vector

Place = Sequence[sympy.Expr | float]
"""Three components of a design position (m)."""

INPUT_UNITS = ("m", "rad", "N", "N*m", "1")
"""Units of inputs: SI, so that nothing has to be converted in the equations."""


@dataclass(eq=False, repr=False)
class Mechanism:
    """A tree of rigid bodies with what acts on it and what is measured.

    Gravity acts against Z; all frames are parallel to the ground, and all coordinates zero, at the design
    position.

    Examples
    --------
    A mass on a spring whose foot is moved:

    >>> import sympy
    >>> from chassym.derivation import Linear, Mechanism, TravelPort, derive, prismatic
    >>> m, k, c, g = sympy.symbols("m k c g", positive=True)
    >>> mechanism = Mechanism("oscillator", gravity=g)
    >>> mass = mechanism.add_body("mass", mechanism.ground, prismatic("z", "z"), (0, 0, 0), mass=m)
    >>> road = mechanism.add_input("road", "m")
    >>> travel = TravelPort(mechanism.point("foot", mass, (0, 0, 0)), mechanism.ground, "z")
    >>> spring = mechanism.add_force_element("spring", travel.less(road), Linear(k, c))
    >>> equations = derive(mechanism)
    >>> equations.mass_matrix, equations.program.expand(equations.generalized_forces)
    (((m,),), [-c*(-road_rate + z_rate) - k*(-road + z)])
    """

    name: str
    gravity: sympy.Expr | float
    bodies: list[Body] = field(default_factory=list, init=False)
    elements: list[ForceElement] = field(default_factory=list, init=False)
    applied: list[AppliedForce | AppliedTorque] = field(default_factory=list, init=False)
    inputs: list[Input] = field(default_factory=list, init=False)
    outputs: list[Output] = field(default_factory=list, init=False)
    _names: Names = field(init=False)

    def __post_init__(self) -> None:
        scalar(f"mechanism {self.name!r}: gravity", self.gravity)
        self._names = Names(self.name)

    def snapshot(self) -> Mechanism:
        """The mechanism as it is now: what is added to this one later does not change that one."""
        taken = copy.copy(self)
        for name, value in vars(self).items():
            if isinstance(value, list | Names):
                setattr(taken, name, value.copy())
        return taken

    def with_characteristics(self, changes: Mapping[str, Characteristic]) -> Mechanism:
        """The mechanism as it is now, with other laws for some of its force elements.

        Parameters
        ----------
        changes
            Characteristic by the element's name.

        Raises
        ------
        MechanismError
            If there is no element of a name.
        """
        names = {element.name for element in self.elements}
        for name in changes:
            if name not in names:
                raise MechanismError(f"element {name!r}: {self.name} has {', '.join(sorted(names))}")
        changed = {
            element: replace(element, characteristic=changes[element.name])
            for element in self.elements
            if element.name in changes
        }
        taken = self.snapshot()
        taken.elements = [changed.get(element, element) for element in self.elements]
        taken.outputs = [output.of_elements(changed) for output in self.outputs]
        return taken

    def __repr__(self) -> str:
        counts = (
            f"{len(self.bodies)} bodies, {len(self.coordinates)} coordinates, {len(self.elements)} elements"
        )
        return f"<Mechanism {self.name!r}: {counts}>"

    @property
    def ground(self) -> Body:
        """The inertial frame: Z up."""
        return GROUND

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Every coordinate, in the order of the bodies and their joints' steps."""
        return tuple(step.coordinate for body in self.bodies for step in body.joint.steps)

    @property
    def rotation_sequences(self) -> tuple[str, ...]:
        """Bodies on three rotations in a row, which are singular in some position."""
        return tuple(body.name for body in self.bodies if rotation_sequence(body))

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
        found = {element.name: knotted_part(element.characteristic) for element in self.elements}
        return {name: law for name, law in found.items() if law is not None}

    def coordinate(self, name: str) -> Coordinate:
        """A coordinate by its name.

        Raises
        ------
        MechanismError
            If no joint has it.
        """
        found = {coordinate.name: coordinate for coordinate in self.coordinates}
        if name not in found:
            raise MechanismError(
                f"mechanism {self.name!r}: no coordinate {name!r}; there are {', '.join(found) or 'none'}"
            )
        return found[name]

    def add_body(
        self,
        name: str,
        parent: Body,
        joint: Joint,
        origin: Place,
        *,
        mass: sympy.Expr | float = 0,
        mass_centre: Place | None = None,
        inertia: Inertia = (0, 0, 0),
        inertia_about: Place | None = None,
    ) -> Body:
        """Add a body.

        Parameters
        ----------
        name
            Unique in the mechanism.
        parent
            The body it hangs on; `ground`, or one added before.
        joint
            What it may do relative to its parent.
        origin
            Design position of the joint, the origin of the body's frame (m).
        mass
            Mass (kg).
        mass_centre
            Design position of the mass centre (m); the origin unless given.
        inertia
            Principal moments about axes parallel to x, y and z, or the tensor by rows (kg m^2).
        inertia_about
            Design position of the point that the inertia is about (m); the mass centre unless given.

        Raises
        ------
        MechanismError
            If a name is taken, the parent is not in this mechanism, or no body can have such mass or inertia.
        """
        self._check_place_in_tree(name, parent)
        expect(f"body {name!r}: joint", joint, Joint)
        mass, start = scalar(f"body {name!r}: mass", mass), place(f"body {name!r}: origin", origin)
        if mass.is_negative:
            raise MechanismError(f"body {name!r}: mass {mass}; expected zero or greater")
        centre = start if mass_centre is None else place(f"body {name!r}: mass centre", mass_centre)
        about = centre if inertia_about is None else place(f"body {name!r}: inertia_about", inertia_about)
        offset = vector([a - b for a, b in zip(about, centre, strict=True)])
        tensor = about_mass_centre(inertia_tensor(name, inertia), mass, offset)
        check_inertia(name, tensor)
        own = [step.coordinate for step in joint.steps]
        symbols = [symbol for c in own for symbol in (c.position, c.rate, c.acceleration)]
        self._names.claim({name: "body"}, {c.name: "coordinate" for c in own}, symbols=symbols)
        self.bodies.append(Body(name, parent, joint, start, mass, centre, tensor))
        return self.bodies[-1]

    def point(self, name: str, body: Body, position: Place) -> Point:
        """A point fixed to a body, by its design position.

        Raises
        ------
        MechanismError
            If the body is not in this mechanism.
        """
        expect(f"point {name!r}: body", body, Body)
        found = Point(name, body, place(f"point {name!r}", position))
        self._check_references(f"point {name!r}", found)
        return found

    def add_input(self, name: str, unit: str, description: str = "") -> Input:
        """Add a prescribed motion in "m" or "rad", or the command of an actuator in "N" or "N*m".

        Raises
        ------
        MechanismError
            If the name is taken, or the unit is none of these, nor "1".
        """
        if unit not in INPUT_UNITS:
            raise MechanismError(
                f"input {name!r}: unit {unit!r} received, expected one of {', '.join(INPUT_UNITS)}"
            )
        found = Input(name, unit, description)
        self._names.claim({name: "input"}, symbols=[found.position, found.rate])
        self.inputs.append(found)
        return found

    def add_force_element(
        self, name: str, port: Port, characteristic: Characteristic, *, preloaded: bool = False
    ) -> ForceElement:
        """Add a force law at a port, with the constant force that holds the design position if preloaded.

        Raises
        ------
        MechanismError
            If the name is taken, or the port is on something that is not in this mechanism.
        """
        expect(f"force element {name!r}: port", port, Port)
        expect(f"force element {name!r}: characteristic", characteristic, Characteristic)
        preload = sympy.Symbol(f"{name}.preload", real=True) if preloaded else None
        element = ForceElement(name, port, characteristic, preload)
        self._check_references(f"force element {name!r}", element)
        if isinstance(characteristic, Actuator) and characteristic.command.unit != element.unit:
            raise MechanismError(
                f"force element {name!r}: its command is in {characteristic.command.unit}, expected "
                f"{element.unit}, which works on a deflection in {port.unit}"
            )
        self._names.claim({name: "force element"})
        self.elements.append(element)
        return element

    def add_bushing(
        self,
        name: str,
        point: Point,
        frame: Body,
        laws: Mapping[str, Characteristic],
        *,
        preloaded: bool = False,
    ) -> dict[str, ForceElement]:
        """Add force laws at one point along the axes of a frame: up to three elements, ``name_x`` and so on.

        Raises
        ------
        MechanismError
            As for `add_force_element`, and for an axis that is not "x", "y" or "z".
        """
        for axis, law in laws.items():
            unit_vector(axis, f"bushing {name!r}: axis")
            expect(f"bushing {name!r}: characteristic", law, Characteristic)
        ports = {axis: TravelPort(point, frame, axis) for axis in laws}
        self._check_references(f"bushing {name!r}", tuple(ports.values()))
        self._names.check_free([{f"{name}_{axis}": "force element"} for axis in laws])
        return {
            axis: self.add_force_element(f"{name}_{axis}", ports[axis], law, preloaded=preloaded)
            for axis, law in laws.items()
        }

    def add_applied_force(self, name: str, point: Point, axis: Direction, axes: Body) -> Input:
        """Add an input in N: a force on a point along an axis of a body's frame, without a reaction."""
        what = f"applied force {name!r}: axis"
        self._check_references(f"applied force {name!r}", (point, axes))
        return self._add_applied(name, AppliedForce(Input(name, "N"), point, unit_vector(axis, what), axes))

    def add_applied_torque(self, name: str, body: Body, axis: Direction, axes: Body) -> Input:
        """Add an input in N m: a torque on a body about an axis of a body's frame, without a reaction."""
        what = f"applied torque {name!r}: axis"
        self._check_references(f"applied torque {name!r}", (body, axes))
        return self._add_applied(name, AppliedTorque(Input(name, "N*m"), body, unit_vector(axis, what), axes))

    def _add_applied(self, name: str, load: AppliedForce | AppliedTorque) -> Input:
        self._names.claim({name: "input"}, symbols=[load.input.position, load.input.rate])
        self.inputs.append(load.input)
        self.applied.append(load)
        return load.input

    def add_output(self, output: Output) -> None:
        """Add a measured quantity.

        Raises
        ------
        MechanismError
            If the name is taken, or it measures something that is not in this mechanism.
        """
        expect("output", output, Output)
        self._check_references(f"output {output.name!r}", output)
        self._names.claim({output.name: "output"})
        self.outputs.append(output)

    def check(self) -> None:
        """Refuse what only a finished mechanism shows.

        Raises
        ------
        MechanismError
            If nothing moves; if a body that moves carries, with all that hangs on it, neither mass nor
            inertia; or if a symbol means two things.
        """
        if not self.coordinates:
            raise MechanismError(f"mechanism {self.name!r} has no coordinates: nothing in it moves")
        check_symbols(self)
        carrying = set()
        for body in reversed(self.bodies):
            if body in carrying or not body.is_massless:
                carrying.add(body.parent)
            elif body.joint.steps:
                raise MechanismError(
                    f"body {body.name!r} moves and has no mass, nor has anything that hangs on it; give it a "
                    "mass or inertia, or weld it to its parent"
                )

    def _check_place_in_tree(self, name: str, parent: Body) -> None:
        expect(f"body {name!r}: parent", parent, Body)
        placed = next((body for body in self.bodies if body.name == name), None)
        if placed is not None and placed.parent is not None and placed.parent is not parent:
            raise MechanismError(
                f"body {name!r} hangs on {placed.parent.name!r} already; a second joint to {parent.name!r} "
                "would close a loop, and a mechanism is a tree: close it with a stiff force element"
            )
        self._check_references(f"body {name!r}", parent)

    def _check_references(self, what: str, part: object) -> None:
        """Refuse a part that refers to bodies, coordinates, inputs or elements of another mechanism."""
        known = {Body: [GROUND, *self.bodies], Coordinate: self.coordinates}
        known |= {Input: self.inputs, ForceElement: [*self.elements, part]}
        for used in references(part):
            if not any(used is each or used == each for each in known[type(used)]):
                kind = type(used).__name__.lower().replace("forceelement", "force element")
                raise MechanismError(
                    f"{what}: {kind} {used.name!r} is not in mechanism {self.name!r}; add it first"
                )

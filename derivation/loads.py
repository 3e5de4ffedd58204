"""Forces on the bodies, collected point by point and brought down to the generalised coordinates."""

from __future__ import annotations

import sympy

from chassym.derivation.body import Body, Point
from chassym.derivation.joint import Coordinate
from chassym.derivation.kinematics import Kinematics
from chassym.derivation.vector import ZERO, Vector, add
from chassym.derivation.wrench import NO_WRENCH, Wrench, at, component, opposite, to_parent


class Loads:
    """What acts on a mechanism at one instant, on the straight-line program of its kinematics."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self._forces: dict[tuple[Point, Body], Vector] = {}
        self._wrenches = [NO_WRENCH] * len(kinematics.links)
        self._generalized: dict[Coordinate, sympy.Expr] = {}

    def add_force_between(self, point: Point, frame: Body, force: Vector) -> None:
        """A force on a point, in a frame's axes, with its reaction on the frame's body at the same place.

        Forces between the same two are summed before they are brought to the bodies.
        """
        so_far = self._forces.get((point, frame), ZERO)
        self._forces[point, frame] = add(self.kinematics.program, so_far, force)

    def add_force(self, point: Point, axes: Body, force: Vector) -> None:
        """A force on a point, in the axes of a frame, without a reaction."""
        kinematics = self.kinematics
        inside = kinematics.rotated(force, axes, point.body)
        self._add_wrench(point.body, at(kinematics.program, kinematics.arm(point), inside))

    def add_torque(self, body: Body, axes: Body, torque: Vector) -> None:
        """A torque on a body, in the axes of a frame, without a reaction."""
        self._add_wrench(body, Wrench(ZERO, self.kinematics.rotated(torque, axes, body)))

    def add_generalized_force(self, coordinate: Coordinate, force: sympy.Expr) -> None:
        """A force or moment on one coordinate."""
        self._generalized[coordinate] = self._generalized.get(coordinate, sympy.S.Zero) + force

    def generalized_forces(self) -> list[sympy.Expr]:
        """The generalised force on every coordinate, in order (N or N m)."""
        for (point, frame), force in self._forces.items():
            self.add_force(point, frame, force)
            place = self.kinematics.position(point, frame)
            self._add_wrench(frame, opposite(at(self.kinematics.program, place, force)))
        self._forces = {}
        let = self.kinematics.program.let
        projected = project(self.kinematics, self._wrenches)
        return [let(force + self._generalized.get(c, sympy.S.Zero)) for c, force in projected.items()]

    def _add_wrench(self, body: Body, wrench: Wrench) -> None:
        index = self.kinematics.link_of(body)
        if index is not None:
            self._wrenches[index] = self._wrenches[index].plus(self.kinematics.program, wrench)


def project(kinematics: Kinematics, wrenches: list[Wrench]) -> dict[Coordinate, sympy.Expr]:
    """Bring wrenches on the links down the tree: what reaches each coordinate.

    The virtual work of a wrench under a joint's virtual displacement is its component along the joint's axis,
    and every link passes on what its children hand it.
    """
    carried = list(wrenches)
    found: dict[Coordinate, sympy.Expr] = {}
    for index in reversed(range(len(kinematics.links))):
        link = kinematics.links[index]
        if link.step is not None:
            found[link.step.coordinate] = component(link.step, carried[index])
        if link.parent is not None:
            passed = to_parent(kinematics, link, carried[index])
            carried[link.parent] = carried[link.parent].plus(kinematics.program, passed)
    return {coordinate: found[coordinate] for coordinate in reversed(found)}

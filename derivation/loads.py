"""Forces on the bodies, collected point by point and brought down to the generalised coordinates."""

from __future__ import annotations

import sympy

from chassym.derivation.body import Body, Point
from chassym.derivation.joint import Coordinate, MechanismError
from chassym.derivation.kinematics import NO_WRENCH, Kinematics, Wrench, at, component, opposite, to_parent
from chassym.derivation.vector import ZERO, Vector, add


class Loads:
    """What acts on a mechanism at one instant, on the straight-line program of its kinematics."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self._forces: dict[tuple[Point, Body], Vector] = {}
        self._generalized: dict[Coordinate, sympy.Expr] = {}

    def add_force(self, point: Point, frame: Body, force: Vector) -> None:
        """A force on a point, in a frame's axes, with its reaction on the frame's body at the same place."""
        so_far = self._forces.get((point, frame), ZERO)
        self._forces[point, frame] = add(self.kinematics.program, so_far, force)

    def add_generalized_force(self, coordinate: Coordinate, force: sympy.Expr) -> None:
        """A force or moment on one coordinate."""
        self._generalized[coordinate] = self._generalized.get(coordinate, sympy.S.Zero) + force

    def generalized_forces(self) -> list[sympy.Expr]:
        """The generalised force on every coordinate, in order (N or N m).

        Raises
        ------
        MechanismError
            If a force acts on a coordinate that no joint has.
        """
        projected = project(self.kinematics, self._wrenches())
        for coordinate in self._generalized.keys() - projected.keys():
            raise MechanismError(
                f"a force acts on coordinate {coordinate.name!r} in {coordinate.unit}, which no joint has; "
                f"there are {', '.join(c.name for c in projected)}"
            )
        let = self.kinematics.program.let
        return [let(force + self._generalized.get(c, sympy.S.Zero)) for c, force in projected.items()]

    def _wrenches(self) -> list[Wrench]:
        """The wrench on every link."""
        kinematics, program = self.kinematics, self.kinematics.program
        wrenches = [NO_WRENCH] * len(kinematics.links)
        for (point, frame), force in self._forces.items():
            inside = kinematics.rotated_back(force, frame, point.body)
            action = at(program, kinematics.arm(point), inside)
            reaction = opposite(at(program, kinematics.position(point, frame), force))
            for body, wrench in ((point.body, action), (frame, reaction)):
                index = kinematics.link_of(body)
                if index is not None:
                    wrenches[index] = wrenches[index].plus(program, wrench)
        return wrenches


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

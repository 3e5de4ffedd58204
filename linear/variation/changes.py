"""How everything that a linear model depends on changes with parameters, to first order and exactly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from chassym.linear.linear_model import LinearisationError, LinearModel
from chassym.linear.operating_point import OperatingPoint
from chassym.linear.slope_rule import SlopeRules, distance_to_knots, rule_of

Array = np.ndarray


class Changes:
    """Changes of everything that a linear model depends on, with unit changes of parameters.

    Everything is what `CompiledEquations.change_names` names: arguments, parameters, preloads and slopes.
    """

    def __init__(self, point: OperatingPoint, linear: LinearModel, rules: SlopeRules) -> None:
        self.point, self.rules = point, rules
        self.compiled = point.model.compiled
        self.names = self.compiled.change_names
        slopes = point.model.system.slopes
        self.values = point.model.values | {slopes[name].name: slope for name, slope in linear.slopes.items()}
        self._rows = {name: row for row, name in enumerate(self.names)}

    def row(self, name: str) -> int:
        """Where a name stands."""
        return self._rows[name]

    def total(self, parameters: Sequence[str]) -> Array:
        """Changes of everything, shape (everything, p), by unit changes of parameters."""
        model, n = self.point.model, self.point.model.size
        total = np.zeros((len(self.names), len(parameters)))
        for column, name in enumerate(parameters):
            if name in self._rows:  # a parameter that no equation mentions changes nothing
                total[self._rows[name], column] = 1.0
        preloads = [symbol.name for symbol in model.system.preloads]
        if preloads and model.given_preloads is None:
            total[[self._rows[name] for name in preloads]] = self._preloads(preloads, total)
        statics = self._statics(self.values, self.point.arguments)
        left = (statics @ total)[:n]
        rounding = _ROUNDING * (np.abs(statics[:n]) @ np.abs(total))
        unbalanced = (np.abs(left) > rounding).any(axis=0)
        if unbalanced.any():
            if self.point.condition > _SINGULAR:
                raise LinearisationError(
                    f"the position of {model.system.name!r} at rest is not determined by its forces: its "
                    "stiffness is singular, and how it follows parameters is unknown"
                )
            moved = [self._rows[coordinate.name] for coordinate in model.system.coordinates]
            total[np.ix_(moved, unbalanced)] = -np.linalg.solve(self.point.stiffness, left[:, unbalanced])
        total[[self._rows[s.name] for s in model.system.slopes.values()]] = self._slopes(statics @ total)
        return total

    def _preloads(self, names: Sequence[str], total: Array) -> Array:
        """Changes of preloads A^+ (-r0), r = r0 + A preload at the design position, with those of A^+.

        Golub and Pereyra, SIAM Journal on Numerical Analysis 10 (1973), 413-432, equation 4.12, for b in the
        range of A.
        """
        n, design = self.point.model.size, np.zeros_like(self.point.arguments)
        statics = self._statics(self.values, design)
        forces = (statics @ total)[:n]
        by_preload = statics[:n, [self._rows[name] for name in names]]
        inverse = np.linalg.pinv(by_preload, rcond=1e-12)
        along = -inverse @ forces
        nothing = np.eye(len(names)) - inverse @ by_preload
        if np.abs(nothing).max(initial=0.0) < 1e-9:
            return along
        without = self.values | dict.fromkeys(names, 0.0)
        start = (self._statics(without, design) @ total)[:n]
        columns = [(self._statics(without | {name: -1.0}, design) @ total)[:n] - start for name in names]
        held = inverse.T @ np.array([self.values[name] for name in names])
        across = -np.einsum("jip,i->jp", np.array(columns), held)
        return np.asarray(along + nothing @ across)

    def _slopes(self, changes: Array) -> Array:
        """Changes of the slopes of tables, shape (tables, p)."""
        model = self.point.model
        tables, places = model.tables, self.point.table_places
        moved = changes[model.size : model.size + len(tables)]
        numbers = changes[model.size + len(tables) :]
        found = np.empty((len(tables), changes.shape[1]))
        for index, (element, table) in enumerate(tables.items()):
            knots = len(table.knots)
            by_knot, by_slope, _, numbers = np.split(
                numbers, [knots, 2 * knots + 1, 2 * knots + len(model.system.knotted[element].table.places)]
            )
            rule = rule_of(self.rules, element)
            distance = distance_to_knots(table, places[element])[:, 0]
            steps, away = np.diff(table.slopes[:, 0]), by_knot - moved[index]
            found[index] = by_slope[0] + rule.share_beyond(distance) @ np.diff(by_slope, axis=0)
            found[index] -= (steps * rule.density(distance)) @ away
        return found

    def _statics(self, values: Mapping[str, float], arguments: Array) -> Array:
        """Derivatives of residual, table variables and table numbers by everything, at some arguments."""
        repeated = np.repeat(arguments[:, None], len(self.names), axis=1)
        samples = np.vstack([repeated, np.eye(len(self.names))])
        return self.compiled.statics_change.bind(values)(samples)

    def jacobian(self) -> Array:
        """Derivatives of the linearisation by everything, shape (everything, n + outputs, arguments)."""
        function = self.compiled.linearisation_change.bind(self.values)
        count, arguments = len(self.names), self.point.arguments
        found = []
        for change in np.eye(count):
            samples = np.empty((2 * len(arguments) + count, len(arguments)))
            samples[: len(arguments)] = arguments[:, None]
            samples[len(arguments) : 2 * len(arguments)] = np.eye(len(arguments))
            samples[2 * len(arguments) :] = change[:, None]
            found.append(function(samples))
        return np.array(found)


_ROUNDING = 1e-12
"""Part of the terms of a force below which it is none."""

_SINGULAR = 1e14
"""Condition number of a stiffness from which on it is singular."""

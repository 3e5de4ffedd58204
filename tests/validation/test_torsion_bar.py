"""Chains of discs on a shaft against their closed form, and their limit, the uniform bar in torsion.

n equal discs I with n - 1 equal springs k between them, free at both ends, have the frequencies and shapes

    w_m = 2 sqrt(k / I) sin(m pi / 2n),   theta_i = cos(m pi (i + 1/2) / n),   m and i = 0 .. n - 1:

theta_i solves I w^2 theta_i = k (2 theta_i - theta_(i-1) - theta_(i+1)) for every i, and theta_(-1) = theta_0
and theta_n = theta_(n-1), which is what a free end means. A bar of length L, torsional rigidity G J and
polar inertia rho I_p per length has w_m = m pi / L sqrt(G J / (rho I_p)) (S. S. Rao, Mechanical Vibrations,
section "Torsional Vibration of a Shaft or Rod"). Cut into n cells it is the chain with I = rho I_p L / n and
k = n G J / L, the discs at the middle of the cells; sin x = x - x^3 / 6 makes its frequencies too low by the
part (m pi)^2 / (24 n^2).
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from chassym.derivation import (
    AngularVelocity,
    CompiledEquations,
    JointPort,
    Linear,
    Mechanism,
    Model,
    Parameters,
    build_model,
    revolute,
)
from chassym.derivation.symbols import ParameterSymbols
from chassym.derivation.vehicles.full_car import add_body_sections
from chassym.linear import LinearModel, damped_modes, frequency_response, linearise, undamped_modes

RIGIDITY, INERTIA, LENGTH = 3.1e6, 120.0, 2.7
"""Torsional rigidity G J (N m^2), polar inertia per length rho I_p (kg m), length L (m) of the bar."""

RETARDATION = 2e-4
"""Damping of the bar over its rigidity (s)."""

Array = np.ndarray


@cache
def bar(cells: int) -> LinearModel:
    """Cut the bar into discs, each turning against the one before, with a torque on the first one."""
    chain = Mechanism("bar", gravity=0)
    disc, origin = chain.ground, (0, 0, 0)
    stiffness = RIGIDITY / (LENGTH / cells)
    for i in range(cells):
        inertia = (INERTIA * LENGTH / cells, 0, 0)
        disc = chain.add_body(f"disc_{i}", disc, revolute(f"twist_{i}", "x"), origin, inertia=inertia)
        if i == 0:
            chain.add_applied_torque("torque", disc, "x", chain.ground)
        else:
            law = Linear(stiffness, RETARDATION * stiffness)
            chain.add_force_element(f"shaft_{i}", JointPort(chain.coordinate(f"twist_{i}")), law)
    chain.add_output(AngularVelocity("end_rate", disc, "x", chain.ground))
    return linearise(build_model(chain, {}))


def chain_frequencies(discs: int) -> Array:
    """Circular frequencies of a chain that the bar is cut into."""
    unit = np.sqrt(RIGIDITY / INERTIA) / LENGTH * discs
    return 2 * unit * np.sin(np.arange(discs) * np.pi / (2 * discs))


def convergence(error: Callable[[int], Array]) -> Array:
    """Orders of convergence from 6 to 12 to 24 parts, shape (2, ...)."""
    errors = np.array([error(parts) for parts in (6, 12, 24)])
    return np.log2(errors[:-1] / errors[1:])


# Equal discs


@pytest.mark.parametrize("discs", [2, 3, 7, 24])
def test_frequencies_of_equal_discs(discs: int) -> None:
    found = undamped_modes(bar(discs)).frequencies_hz
    assert found[0] == 0
    np.testing.assert_allclose(2 * np.pi * found, chain_frequencies(discs), rtol=1e-12)


@pytest.mark.parametrize("discs", [2, 3, 7, 24])
def test_shapes_of_equal_discs(discs: int) -> None:
    """Unit modal mass: the sum of I theta_i^2 is 1."""
    i, m = np.arange(discs)[:, None], np.arange(discs)
    expected = np.cos(m * np.pi * (i + 0.5) / discs)
    expected /= np.sqrt(INERTIA * LENGTH / discs * (expected**2).sum(axis=0))
    found = undamped_modes(bar(discs)).shapes.cumsum(axis=0)
    np.testing.assert_allclose(found * np.sign(found[0]), expected, atol=1e-12 * expected.max())


@pytest.mark.parametrize("discs", [3, 7, 24])
def test_poles_of_equal_discs_with_losses_in_the_shaft(discs: int) -> None:
    """Every mode for itself: s^2 + tau w^2 s + w^2 = 0, its damping ratio tau w / 2."""
    squared = chain_frequencies(discs)[1:] ** 2
    roots = np.array([np.roots([1, RETARDATION * each, each]) for each in squared])
    expected = np.sort_complex(roots[roots.imag > 0])
    modes = [mode for mode in damped_modes(bar(discs)) if mode.frequency_hz > 0]
    np.testing.assert_allclose(np.sort_complex([mode.eigenvalue for mode in modes]), expected, rtol=1e-11)
    np.testing.assert_allclose(
        [mode.damping_ratio for mode in modes], RETARDATION * np.sqrt(squared) / 2, rtol=1e-9
    )


FREQUENCIES = np.geomspace(0.5, 120, 120)


def end_rate(cells: int, frequencies: Array) -> Array:
    return frequency_response(bar(cells), frequencies).select("end_rate", "torque")


@pytest.mark.parametrize("discs", [2, 7, 24])
def test_response_of_the_last_disc_to_a_torque_on_the_first(discs: int) -> None:
    """theta_(n-1) / T = -cos(mu / 2) / (2 z sin(n mu) sin(mu / 2)).

    Here z = k (1 + s tau) and cos(mu) = 1 + s^2 I / 2z: theta_i = A cos(mu (n - 1/2 - i)) solves every
    equation but the first disc's, which gives A.
    """
    s = 2j * np.pi * FREQUENCIES
    z = RIGIDITY / (LENGTH / discs) * (1 + s * RETARDATION)
    half = np.arcsin(np.sqrt(-(s**2) * INERTIA * LENGTH / discs / z) / 2)
    expected = -s * np.cos(half) / (2 * z * np.sin(2 * discs * half) * np.sin(half))
    np.testing.assert_allclose(end_rate(discs, FREQUENCIES), expected, rtol=1e-12)


# The uniform bar


def test_frequencies_converge_to_those_of_the_bar() -> None:
    """As 1 / n^2, with the factor that the next term of the sine gives."""
    order = np.arange(1, 4)
    exact = order / (2 * LENGTH) * np.sqrt(RIGIDITY / INERTIA)

    def error(cells: int) -> Array:
        return 1 - undamped_modes(bar(cells)).frequencies_hz[1:4] / exact

    np.testing.assert_allclose(convergence(error), 2, atol=0.05)
    np.testing.assert_allclose(24**2 * error(24), (order * np.pi) ** 2 / 24, rtol=0.01)


def test_response_converges_to_that_of_the_bar() -> None:
    """theta(L) / T = -1 / (G J b sin(b L)), b^2 = -s^2 rho I_p / G J, with G J (1 + s tau) for G J."""
    frequencies = np.array([3.0, 20.0, 45.0])
    s = 2j * np.pi * frequencies
    rigidity = RIGIDITY * (1 + s * RETARDATION)
    b = np.sqrt(-(s**2) * INERTIA / rigidity)
    exact = -s / (rigidity * b * np.sin(b * LENGTH))

    def error(cells: int) -> Array:
        return np.abs(end_rate(cells, frequencies) / exact - 1)

    np.testing.assert_allclose(convergence(error), 2, atol=0.1)


# Three unequal discs


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_three_discs_have_the_roots_of_their_quadratic(torsion_chain: Model, seed: int) -> None:
    """w^4 - (k_F (1 / I_1 + 1 / I_2) + k_R (1 / I_2 + 1 / I_3)) w^2 + k_F k_R sum(I) / (I_1 I_2 I_3) = 0.

    It is the determinant of the equations of the two twists.
    """
    generator = np.random.default_rng(seed)
    i_1, i_2, i_3 = generator.uniform(50, 250, 3)
    front, rear = generator.uniform(1e6, 8e6, 2)
    inertias = {"front": i_1, "middle": i_2, "rear": i_3}
    changes = {f"inertia.{place}": value for place, value in inertias.items()}
    changed = torsion_chain.with_parameters(
        changes | {"stiffness.front": float(front), "stiffness.rear": float(rear)}
    )
    middle = front * (1 / i_1 + 1 / i_2) + rear * (1 / i_2 + 1 / i_3)
    last = front * rear * (i_1 + i_2 + i_3) / (i_1 * i_2 * i_3)
    root = np.sqrt(middle**2 - 4 * last)
    expected = np.sqrt(np.array([0, 2 * last / (middle + root), (middle + root) / 2])) / (2 * np.pi)
    found = undamped_modes(linearise(changed)).frequencies_hz
    np.testing.assert_allclose(found, expected, rtol=1e-12)


# The car's body in sections


def torsions(parameters: Parameters, sections: int) -> Array:
    """Frequencies (Hz) of a body alone, free in space, without those of the rigid body."""
    body = Mechanism("body", gravity=0)
    add_body_sections(body, ParameterSymbols(parameters), sections)
    return undamped_modes(linearise(Model(parameters, CompiledEquations(body)))).frequencies_hz[6:]


@pytest.mark.parametrize("sections", [3, 6, pytest.param(12, marks=pytest.mark.slow)])
def test_a_uniform_body_in_sections_is_a_chain_of_equal_discs(sedan: Model, sections: int) -> None:
    """The first frequency is that of three sections, 3 K / J, and the others follow from the sine."""
    value = sedan.values
    first = np.sqrt(value["body.front.torsional_stiffness"] / value["body.front.inertia.xx"]) / (2 * np.pi)
    sines = np.sin(np.arange(1, sections) * np.pi / (2 * sections))
    np.testing.assert_allclose(torsions(sedan.parameters, sections), first * sines / sines[0], rtol=1e-12)


@pytest.mark.slow
def test_a_body_in_sections_converges_to_a_uniform_bar(sedan: Model) -> None:
    """Its second and third torsion to two and three times the first one, from below, as 1 / n^2.

    With the first frequency kept the error is that of the ratio of sines: (m^2 - 1) pi^2 / (24 n^2).
    """
    order = np.array([2, 3])

    def error(sections: int) -> Array:
        found = torsions(sedan.parameters, sections)
        return 1 - found[1:3] / (order * found[0])

    np.testing.assert_allclose(convergence(error), 2, atol=0.05)
    np.testing.assert_allclose(24**2 * error(24), (order**2 - 1) * np.pi**2 / 24, rtol=0.01)

"""Compiled functions of one sample: their results, their address, called from C's side and from numba."""

import ctypes
import gc
import pickle
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest

from chassym.derivation import CompiledEquations, Model, PointFunction, load_model

C_FUNCTION = ctypes.CFUNCTYPE(None, *[ctypes.POINTER(ctypes.c_double)] * 3)


def states(model: Model, count: int) -> np.ndarray:
    """Coordinates, rates, inputs and input rates, shape (count, arguments)."""
    return np.random.default_rng(3).uniform(-0.1, 0.1, (count, len(model.right_hand_side.arguments)))


def all_arguments(model: Model, sample: np.ndarray) -> np.ndarray:
    """With accelerations, as functions of many samples take them, shape (arguments, 1)."""
    n = model.size
    return np.concatenate([sample[: 2 * n], np.zeros(n), sample[2 * n :]])[:, None]


def address_of(array: np.ndarray) -> "ctypes._Pointer[ctypes.c_double]":
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def test_arguments_are_state_inputs_and_input_rates(sedan: Model) -> None:
    names = sedan.right_hand_side.arguments
    assert names[:3] == ("x", "y", "z") and names[12:14] == ("x_rate", "y_rate")
    assert list(names[24:36]) == [motion.name for motion in sedan.system.inputs]
    assert not any(name.endswith("_acceleration") for name in names)


def test_one_sample_has_the_values_that_it_has_in_a_batch(sedan: Model) -> None:
    n = sedan.size
    for sample in states(sedan, 50):
        found = sedan.right_hand_side(sample)
        assert np.array_equal(found[:n], sample[n : 2 * n])
        batch = sedan.accelerations(all_arguments(sedan, sample))[:, 0]
        np.testing.assert_allclose(found[n:], batch, rtol=0, atol=1e-12 * np.abs(batch).max())
        distances = sedan.state_knot_distances(sample)
        in_batch = sedan.knot_distances(all_arguments(sedan, sample))[:, 0]
        np.testing.assert_allclose(distances, in_batch, rtol=0, atol=1e-14 * np.abs(in_batch).max())


def test_evaluation_between_two_arrays(half_car: Model) -> None:
    function = half_car.right_hand_side
    given, results = np.zeros(len(function.arguments)), np.zeros(function.size)
    evaluate = function.between(given, results)
    for sample in states(half_car, 3):
        given[:] = sample
        evaluate()
        assert np.array_equal(results, function(sample))


def test_evaluation_keeps_alive_what_it_needs() -> None:
    model = load_model("half_car")
    samples = states(model, 1)
    expected = model.right_hand_side(samples[0])
    results = np.zeros(len(expected))
    evaluate = model.right_hand_side.between(samples[0].copy(), results)
    del model
    gc.collect()
    evaluate()
    assert np.array_equal(results, expected)


@pytest.mark.parametrize("position", [0, 1], ids=["arguments", "results"])
@pytest.mark.parametrize(
    "spoilt",
    [
        lambda a: a[:-1].copy(),
        lambda a: a[:, None],
        lambda a: a.astype("float32"),
        lambda a: np.repeat(a, 2)[::2],
    ],
    ids=["short", "matrix", "single precision", "with gaps"],
)
def test_other_arrays_are_refused(
    half_car: Model, position: int, spoilt: Callable[[np.ndarray], np.ndarray]
) -> None:
    function = half_car.right_hand_side
    arrays = [np.zeros(len(function.arguments)), np.zeros(function.size)]
    arrays[position] = spoilt(arrays[position])
    name = ("arguments", "results")[position]
    with pytest.raises(ValueError, match=f"{name}: float.* received; contiguous float64 of shape"):
        function.between(*arrays)


def test_variants_have_constants_of_their_own_and_share_the_code(half_car: Model) -> None:
    sample = states(half_car, 1)[0]
    before = half_car.right_hand_side(sample)
    heavier = half_car.scaled("body.mass", factor=2.0)
    assert heavier.right_hand_side.address == half_car.right_hand_side.address
    assert not np.allclose(heavier.right_hand_side(sample), before)
    assert np.array_equal(half_car.right_hand_side(sample), before)


def test_a_function_of_many_samples_has_no_such_address(half_car: Model) -> None:
    with pytest.raises(AttributeError, match="evaluates 8 samples together"):
        _ = half_car.compiled.accelerations.address


def test_pickled_after_use_and_used_elsewhere(half_car: Model) -> None:
    sample = states(half_car, 1)[0]
    expected = half_car.right_hand_side(sample)
    assert half_car.right_hand_side.pointer
    program = (
        "import pickle, sys; model, sample = pickle.load(sys.stdin.buffer);"
        "sys.stdout.buffer.write(model.right_hand_side(sample).tobytes())"
    )
    data = pickle.dumps((half_car, sample))
    done = subprocess.run([sys.executable, "-c", program], input=data, check=True, capture_output=True)
    assert np.array_equal(np.frombuffer(done.stdout), expected)


def test_damaged_entry_of_a_function_of_one_sample_is_built_again(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, quarter_car: Model
) -> None:
    """The disk's entry says how many samples go together."""
    monkeypatch.setenv("CHASSYM_CACHE_DIR", str(tmp_path_factory.mktemp("kept")))
    sample = states(quarter_car, 1)[0]
    expected = quarter_car.right_hand_side(sample)
    for _ in range(2):
        compiled = CompiledEquations(quarter_car.system)
        assert compiled.right_hand_side.lanes == 1 and compiled.accelerations.lanes == 8
        assert np.array_equal(PointFunction(compiled.right_hand_side, quarter_car.values)(sample), expected)


def test_called_by_its_address(sedan: Model) -> None:
    """As a program in C calls it: three pointers to contiguous doubles."""
    function = sedan.right_hand_side
    by_address = C_FUNCTION(function.address)
    for sample in states(sedan, 5):
        results = np.full(function.size, np.nan)
        by_address(address_of(sample), address_of(function.constants), address_of(results))
        assert np.array_equal(results, function(sample))


def test_jacobian_called_by_its_address_is_row_by_row(sedan: Model) -> None:
    function, n = sedan.right_hand_side_jacobian, sedan.size
    sample, results = states(sedan, 1)[0], np.full(function.size, np.nan)
    C_FUNCTION(function.address)(address_of(sample), address_of(function.constants), address_of(results))
    matrix = results.reshape(2 * n, 2 * n)
    assert np.array_equal(matrix[:n], np.eye(n, 2 * n, n))
    assert np.array_equal(matrix.ravel(), function(sample))

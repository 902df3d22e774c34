"""The predicate language means what numpy says."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tiloilc.label import FUNCTIONS, compile_predicates

Values = NDArray[np.float64]
FIELDS = {"pos": (0, 2), "v": (2, 5), "s": (5, 6), "angle": (6, 7)}


def observations(seed: int = 0, n: int = 64) -> Values:
    return np.random.default_rng(seed).normal(size=(n, 7)) * 2


def truth(predicate: str, o: Values) -> NDArray[np.bool_]:
    return compile_predicates({"p": predicate}, FIELDS).truth(o)[..., 0]


SAYINGS: list[tuple[str, Callable[[Values], object]]] = [
    ("dist(pos, [0.45, -0.75]) < 0.9", lambda o: np.hypot(o[:, 0] - 0.45, o[:, 1] + 0.75) < 0.9),
    ("norm(v) >= 2", lambda o: np.linalg.norm(o[:, 2:5], axis=1) >= 2),
    ("norm(s) < 1", lambda o: np.abs(o[:, 5]) < 1),
    ("dot(pos, pos) < dot(s, s)", lambda o: (o[:, :2] ** 2).sum(1) < o[:, 5] ** 2),
    ("pos[0] < pos[-1] <= 1 != s", lambda o: (o[:, 0] < o[:, 1]) & (o[:, 1] <= 1) & (o[:, 5] != 1)),
    ("v[2] ≥ 0 and s ≤ 1 and s ≠ 0", lambda o: (o[:, 4] >= 0) & (o[:, 5] <= 1) & (o[:, 5] != 0)),
    (
        "not s > 0 or angle > 0 and v[0] > 0",
        lambda o: ~(o[:, 5] > 0) | (o[:, 6] > 0) & (o[:, 2] > 0),
    ),
    ("-s ** 2 < -2", lambda o: -(o[:, 5] ** 2) < -2),
    ("2 ** -1 == 0.5", lambda o: np.ones(len(o), bool)),
    ("2 ** 3 ** 0 == 2", lambda o: np.ones(len(o), bool)),
    ("s % 2 < 1", lambda o: np.mod(o[:, 5], 2) < 1),
    ("s - 1 - 1 > 0", lambda o: o[:, 5] - 2 > 0),
    ("8 / 4 / 2 == 1", lambda o: np.ones(len(o), bool)),
    ("1_000 + 2.5e1 + .5 + 1. == 1026.5", lambda o: np.ones(len(o), bool)),
    ("norm(2 * pos + [1, s]) < 3", lambda o: np.hypot(2 * o[:, 0] + 1, 2 * o[:, 1] + o[:, 5]) < 3),
    ("norm(-pos / s) < 1", lambda o: np.hypot(o[:, 0] / o[:, 5], o[:, 1] / o[:, 5]) < 1),
    ("max(v) > 1", lambda o: o[:, 2:5].max(1) > 1),
    ("min(v[0], s, 1) < 0", lambda o: np.minimum(np.minimum(o[:, 2], o[:, 5]), 1) < 0),
    ("max(abs(pos)) < 1", lambda o: np.abs(o[:, :2]).max(1) < 1),
    ("norm(min(pos, 0)) < 1", lambda o: np.linalg.norm(np.minimum(o[:, :2], 0), axis=1) < 1),
    ("sqrt(abs(s)) < 1", lambda o: np.sqrt(np.abs(o[:, 5])) < 1),
    ("sin(s) < cos(s)", lambda o: np.sin(o[:, 5]) < np.cos(o[:, 5])),
    ("tan(s) > 1", lambda o: np.tan(o[:, 5]) > 1),
    ("atan2(pos[1], pos[0]) > 1", lambda o: np.arctan2(o[:, 1], o[:, 0]) > 1),
    ("hypot(pos[0], s) < 2", lambda o: np.hypot(o[:, 0], o[:, 5]) < 2),
    ("in_box(pos, [-1, -2], [1, 2])", lambda o: (np.abs(o[:, 0]) <= 1) & (np.abs(o[:, 1]) <= 2)),
    ("in_box(pos, -1, 1)", lambda o: (np.abs(o[:, :2]) <= 1).all(1)),
    ("in_box(s, 0, 1)", lambda o: (o[:, 5] >= 0) & (o[:, 5] <= 1)),
    ("in_ball(pos, [1, 1], 1.5)", lambda o: np.hypot(o[:, 0] - 1, o[:, 1] - 1) <= 1.5),
    ("in_ball(s, 1, 0.5)", lambda o: np.abs(o[:, 5] - 1) <= 0.5),
    ("(true or false) and not false", lambda o: np.ones(len(o), bool)),
    ("angle > pi / 2", lambda o: o[:, 6] > math.pi / 2),
    ("[s][0] > s[0] - 1", lambda o: np.ones(len(o), bool)),
]


@pytest.mark.parametrize(("predicate", "meaning"), SAYINGS, ids=[s for s, _ in SAYINGS])
def test_a_predicate_means_what_numpy_says(
    predicate: str, meaning: Callable[[Values], object]
) -> None:
    o = observations()
    np.testing.assert_array_equal(truth(predicate, o), meaning(o))


def test_every_function_is_tried() -> None:
    text = " ".join(predicate for predicate, _ in SAYINGS) + " wrap("
    assert [name for name in FUNCTIONS if f"{name}(" not in text] == []


@given(st.floats(-1e3, 1e3))
def test_wrap_keeps_the_angle_and_lands_in_the_half_open_turn(angle: float) -> None:
    o = np.zeros((1, 7))
    o[0, 6] = angle
    assert truth("-pi < wrap(angle) <= pi", o)[0]
    assert truth("abs(sin(wrap(angle)) - sin(angle)) < 1e-9", o)[0]
    assert truth("abs(cos(wrap(angle)) - cos(angle)) < 1e-9", o)[0]


def test_wrap_sends_minus_pi_to_pi() -> None:
    o = np.zeros((2, 7))
    o[:, 6] = [-math.pi, math.pi]
    assert truth("wrap(angle) == pi", o).tolist() == [True, True]


numbers = st.recursive(
    st.one_of(
        st.floats(-4, 4).map(lambda x: f"{x!r}"),
        st.sampled_from(["s", "angle", "pos[0]", "v[-1]", "norm(v)"]),
    ),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/%"), inner).map(lambda t: f"({' '.join(t)})"),
        inner.map(lambda x: f"abs({x})"),
        inner.map(lambda x: f"-({x})"),
        st.tuples(inner, inner).map(lambda t: f"hypot({t[0]}, {t[1]})"),
    ),
    max_leaves=8,
)
tests = st.recursive(
    st.tuples(numbers, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), numbers).map(" ".join),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["and", "or"]), inner).map(lambda t: f"({' '.join(t)})"),
        inner.map(lambda x: f"not ({x})"),
    ),
    max_leaves=4,
)


@given(tests)
def test_random_predicates_agree_with_numpy(predicate: str) -> None:
    """The same text, read by Python over one observation's numpy numbers."""
    o = observations(1, 5)
    given_truth = truth(predicate, o)
    for row, said in zip(o, given_truth, strict=True):
        names = {
            "s": row[5],
            "angle": row[6],
            "pos": row[0:2],
            "v": row[2:5],
            "abs": np.abs,
            "hypot": np.hypot,
            "norm": lambda v: np.sqrt(np.sum(v * v)),
        }
        with np.errstate(all="ignore"):
            try:
                expected = bool(eval(predicate, {"__builtins__": {}}, names))
            except ZeroDivisionError:  # two plain Python numbers; numpy goes on
                continue
        assert said == expected, predicate


def test_a_batch_is_labelled_as_its_rows_are() -> None:
    labeller = compile_predicates({"a": "norm(pos) < 2", "b": "true", "c": "s > 0"}, FIELDS)
    o = observations(2, 12)
    letters = labeller(o)
    assert letters.dtype == np.int64
    assert letters.tolist() == [int(labeller(row)) for row in o]
    np.testing.assert_array_equal(labeller(o.reshape(3, 4, 7)), letters.reshape(3, 4))
    assert labeller(o[:0]).shape == (0,)


def test_the_order_of_propositions_is_that_of_the_bits() -> None:
    labeller = compile_predicates({"z": "true", "a": "false", "m": "true"}, FIELDS)
    assert labeller.propositions == ("z", "a", "m")
    assert labeller(observations(0, 1)).tolist() == [0b101]


def test_single_precision_and_integers_are_computed_in_double() -> None:
    grid = np.array([[7, 0], [6, 0]], dtype=np.int64)
    labeller = compile_predicates({"a": "x >= 7 and y == 0"}, {"x": (0, 1), "y": (1, 2)})
    assert labeller(grid).tolist() == [1, 0]
    o = observations(3).astype(np.float32)
    np.testing.assert_array_equal(truth("s > 0.3", o), o[:, 5].astype(np.float64) > 0.3)


def test_nan_is_in_nothing_and_unequal_to_everything() -> None:
    o = np.full((1, 7), np.nan)
    for predicate in ("s < 1", "s >= 1", "s == s", "norm(pos) < 9", "in_box(pos, -9, 9)"):
        assert not truth(predicate, o)[0], predicate
    assert truth("s != s", o)[0]


def test_division_by_zero_and_overflow_are_silent() -> None:
    o = np.zeros((1, 7))
    assert truth("1 / s > 1e300", o)[0]
    assert truth("10 ** 10 ** 10 > 1", o)[0]
    assert not truth("s / s == 1", o)[0]


def test_observations_are_never_changed() -> None:
    o = observations()
    before = o.copy()
    truth("norm(-pos + 1) < 1 and max(v) > -s", o)
    np.testing.assert_array_equal(o, before)


def test_sixty_two_propositions_fit_a_letter() -> None:
    labeller = compile_predicates({f"p{i}": "true" for i in range(62)}, {})
    assert labeller(np.zeros((1, 1))).tolist() == [2**62 - 1]

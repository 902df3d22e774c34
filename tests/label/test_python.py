"""Predicates in Python: one function of one file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tiloilc.diag import CompileError
from tiloilc.label import Labeller, compile_predicates

GOOD = """
from dataclasses import dataclass

@dataclass
class Limit:
    value: "float" = 1.0

def fast(observations):
    return observations[:, 0] > Limit().value

def slow(observations):
    return ~fast(observations)

number = 3
"""


def compiled(path: Path, function: str) -> Labeller:
    return compile_predicates({"a": "x > 2"}, {"x": (0, 1)}, {"f": f"{path}:{function}"})


def refused(path: Path, function: str) -> str:
    with pytest.raises(CompileError) as caught:
        compiled(path, function)(np.zeros((3, 1)))
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "SPEC117"
    return f"{diagnostic.message} {diagnostic.help}"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "predicates.py"
    path.write_text(GOOD)
    return path


def test_a_function_labels_a_batch(file: Path) -> None:
    labeller = compiled(file, "fast")
    assert labeller.propositions == ("a", "f")
    o = np.array([[0.0], [1.5], [3.0]])
    assert labeller(o).tolist() == [0, 2, 3]
    assert labeller(o.reshape(3, 1, 1)).tolist() == [[0], [2], [3]]
    assert labeller(o[2]) == 3


def test_a_python_predicate_can_keep_its_place_in_the_order(file: Path) -> None:
    labeller = compile_predicates({"f": "", "a": "x > 2"}, {"x": (0, 1)}, {"f": f"{file}:fast"})
    assert labeller.propositions == ("f", "a")
    assert labeller(np.array([[1.5]])).tolist() == [1]


def test_what_cannot_be_loaded_says_why(file: Path, tmp_path: Path) -> None:
    assert "there is no such file" in refused(tmp_path / "nope.py", "fast")
    assert "did you mean `fast`" in refused(file, "fasst")
    assert "`number` is not a function" in refused(file, "number")
    assert "file.py:function" in refused(tmp_path, "fast")
    broken = tmp_path / "broken.py"
    broken.write_text("def f(:\n")
    assert "SyntaxError" in refused(broken, "f")
    broken.write_text("1 / 0\n")
    assert "ZeroDivisionError" in refused(broken, "f")


@pytest.mark.parametrize(
    ("body", "problem"),
    [
        ("return o[:, 0]", "it returned float64 [3]"),
        ("return True", "it returned bool []"),
        ("return o > 0", "it returned bool [3, 1]"),
        ("return o.nothing", "it raised AttributeError"),
    ],
)
def test_what_returns_no_truth_values_says_so(tmp_path: Path, body: str, problem: str) -> None:
    path = tmp_path / "wrong.py"
    path.write_text(f"def f(o):\n    {body}\n")
    assert problem in refused(path, "f")

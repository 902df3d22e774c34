"""The compiled update is the same update; what cannot be compiled is said once and goes on."""

from pathlib import Path

import pytest
import torch

from tests.learn.examples import COMPILER, settings
from tests.learn.run.test_train import assert_equal_runs, go, point
from tiloilc.learn import load_policy, make_loop
from tiloilc.learn.agent.continuous import SacAgent
from tiloilc.learn.engine.program import Program, pays


@pytest.fixture(autouse=True)
def quick_cloning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)


def doubled(x: torch.Tensor) -> torch.Tensor:
    return x.mul_(2)


def test_compiling_is_for_many_updates_unless_told_otherwise() -> None:
    many, few = {"steps": 35_000, "learning_starts": 10_000}, {"steps": 34_999}
    assert pays(settings(**many))
    assert not pays(settings(**many | few))
    assert not pays(settings(**many, updates_per_step=0.5))
    assert pays(settings(**many | few, updates_per_step=2))
    assert not pays(settings(**many, compile="never"))
    assert pays(settings(compile="always"))


def test_what_cannot_be_compiled_is_called_as_it_is_and_one_line_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def no_compiler(*args: object, **kwargs: object) -> object:
        raise RuntimeError("backend='inductor' raised:\nno compiler\nand much more")

    monkeypatch.setattr(torch, "compile", lambda function, **kwargs: no_compiler)
    said: list[str] = []
    program = Program(doubled, compiled=True, settled=True, say=said.append)
    assert program(torch.ones(1)).tolist() == [2]
    assert not program.compiled
    assert program(torch.ones(1)).tolist() == [2]
    assert said[1:] == ["training goes on slower, the update cannot be compiled here: no compiler"]


def test_a_platform_without_support_is_none_to_fail_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def unsupported(function: object, **kwargs: object) -> object:
        raise RuntimeError("Windows not yet supported")

    monkeypatch.setattr(torch, "compile", unsupported)
    program = Program(doubled, compiled=True, settled=True, say=lambda text: None)
    assert program(torch.ones(1)).tolist() == [2]


def test_nothing_is_compiled_or_said_where_it_does_not_pay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(torch, "compile", None)
    said: list[str] = []
    assert Program(doubled, compiled=False, settled=True, say=said.append)(
        torch.ones(1)
    ).tolist() == [2]
    assert said == []


def test_a_run_goes_on_as_it_began_even_where_it_could_be_compiled_now(tmp_path: Path) -> None:
    """The last digits of a compiled sum are others."""
    made, shown, labels = point(compile="always")
    first, second = (make_loop(made, shown, labels) for _ in range(2))
    for loop in (first, second):
        assert isinstance(loop.agent, SacAgent)
        loop.agent.program.compiled = loop is second
    list(first.run(30))
    second.load(first.state())
    assert isinstance(second.agent, SacAgent)
    assert not second.agent.program.compiled


@pytest.mark.slow
def test_a_compiled_run_resumes_to_the_same_bits_and_learns_what_an_uncompiled_one_learns(
    tmp_path: Path,
) -> None:
    def once(run: str, compile: str, *interrupts: int) -> None:
        go(point(steps=90, every=30, compile=compile), tmp_path / run, *interrupts)
        if interrupts:
            go(point(steps=90, every=30, compile=compile), tmp_path / run, resume=True)

    once("whole", "always")
    once("pieces", "always", 75)
    assert_equal_runs(tmp_path / "whole", tmp_path / "pieces")
    once("eager", "never")
    compiled, eager = (load_policy(tmp_path / run, "last") for run in ("whole", "eager"))
    assert compiled is not None
    assert eager is not None
    for name, tensor in compiled.items():
        assert torch.allclose(tensor, eager[name], atol=1e-3, equal_nan=True), name
    assert any(not torch.equal(tensor, eager[name]) for name, tensor in compiled.items())


class Scaled:
    def __init__(self, factor: float) -> None:
        self.factor = factor

    def update(self, x: torch.Tensor) -> torch.Tensor:
        return x * self.factor


def test_a_second_agent_in_the_process_has_a_program_of_its_own() -> None:
    """What is not looked at when called, as factors of rewards, must not be the first agent's."""
    said: list[str] = []
    programs = [
        Program(Scaled(factor).update, compiled=True, settled=True, say=said.append)
        for factor in (2.0, 3.0)
    ]
    assert [program(torch.ones(1)).item() for program in programs * 2] == [2, 3, 2, 3]
    assert COMPILER is None or all(program.compiled for program in programs)

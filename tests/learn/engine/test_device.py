"""Where a run computes, and what it takes there."""

import copy
import dataclasses
import re
from typing import Any

import pytest
import torch

from tests.learn.examples import beyond, demos, plan, settings
from tests.plan.automata import stabilization
from tiloilc.diag import CompileError
from tiloilc.learn import make_loop
from tiloilc.learn.agent.continuous import SacAgent
from tiloilc.learn.engine import device as devices
from tiloilc.learn.engine.device import available_memory, check_memory, memory_of, pick_device

CPU = torch.device("cpu")


def test_the_device_is_the_gpu_if_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert [pick_device(wanted).type for wanted in ("auto", "cpu", "cuda")] == [
        "cuda",
        "cpu",
        "cuda",
    ]
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert [pick_device(wanted).type for wanted in ("auto", "cpu")] == ["cpu", "cpu"]
    with pytest.raises(CompileError, match="RUN710"):
        pick_device("cuda")


def test_an_update_runs_on_any_device_and_never_waits_for_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On the device `meta` there are shapes only: no number comes back from it to the host, and
    every tensor that stayed behind is refused."""
    made = plan(stabilization(), "TestsDrift-v0", demo_replay=0.25)
    path = [[0.1 * t, 0.0] for t in range(8)]
    loop = make_loop(made, demos(path), beyond(0.4, 1.5))
    list(loop.run(61))
    agent = loop.agent
    assert isinstance(agent, SacAgent)
    moved, chance = _to_meta([agent, agent._draw()], {})
    assert isinstance(moved, SacAgent)
    monkeypatch.setattr(torch, "_fused_adam_", lambda *args, **kwargs: None)  # has no such form
    losses = moved._update(chance)
    assert {loss.device.type for loss in losses.values()} == {"meta"}
    assert losses["critic"].shape == (2,)
    with pytest.raises(RuntimeError):
        losses["critic"].tolist()


def _to_meta(thing: Any, seen: dict[int, Any]) -> Any:
    """A copy of a thing and all that it holds, with tensors without contents."""
    if id(thing) in seen:
        return seen[id(thing)]
    if isinstance(thing, torch.Tensor):
        made: Any = thing.to("meta")
    elif isinstance(thing, list | tuple):
        made = type(thing)(_to_meta(part, seen) for part in thing)
    elif isinstance(thing, dict):
        made = {name: _to_meta(part, seen) for name, part in thing.items()}
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        parts = {f.name: _to_meta(getattr(thing, f.name), seen) for f in dataclasses.fields(thing)}
        return dataclasses.replace(thing, **parts)
    elif type(thing).__module__.startswith("tiloilc.learn"):
        made = copy.copy(thing)
        seen[id(thing)] = made
        for name, part in vars(thing).items():
            setattr(made, name, _to_meta(part, seen))
    else:
        made = thing
    seen[id(thing)] = made
    return made


# memory


def test_memory_is_that_of_the_buffers_and_the_networks() -> None:
    given = settings(
        seeds=10,
        steps=2_000_000,
        buffer_size=1_000_000,
        stage_buffer_size=1000,
        checkpoint_every=100,
    )
    memory = memory_of(
        given, row=69, observation=31, buffers=6, networks=[(10, 35, 8), (20, 39, 1)]
    )
    assert memory.replay == 10 * 1_000_000 * 69 * 4
    assert memory.stages == 10 * 1000 * 6 * 31 * 4
    assert memory.networks == (10 * 36 * 8 + 20 * 40) * 6 * 4
    assert memory.checkpoint == 10 * 100 * (69 + 31) * 4
    parts = memory.replay + memory.stages + memory.networks + memory.checkpoint
    assert memory.total == parts
    short = memory_of(given.override({"steps": 1000}), 69, 31, 6, [])
    assert short.replay == memory.replay / 1000  # no more is kept than there are steps


def test_memory_is_what_the_agent_holds() -> None:
    made = plan(stabilization(), "TestsDrift-v0", steps=5000)
    agent = make_loop(made, demos([[0.0, 0.0]] * 4), beyond(0.4, 1.5)).agent
    assert isinstance(agent, SacAgent)
    assert agent.replay.rows.nbytes == agent.memory.replay
    assert agent.rings()["method.stages"].rows.nbytes == agent.memory.stages
    held = sum(p.nbytes for nets in (agent.sac.actor, agent.sac.critics) for p in nets.parameters)
    assert held * 6 == agent.memory.networks


@pytest.mark.parametrize(
    ("left", "help"),
    [(0.5, "set `buffer_size: 400_000`"), (0.0001, "train fewer seeds at a time")],
)
def test_too_little_memory_is_a_finding_that_says_what_would_fit(
    monkeypatch: pytest.MonkeyPatch, left: float, help: str
) -> None:
    given = settings(seeds=10, steps=2_000_000, buffer_size=1_000_000, stage_buffer_size=10_000)
    memory = memory_of(given, 69, 31, 6, [])
    monkeypatch.setattr(devices, "available_memory", lambda device: int(memory.total * left))
    with pytest.raises(CompileError, match="RUN709") as caught:
        check_memory(memory, CPU, given)
    assert caught.value.diagnostics[0].help == help
    monkeypatch.setattr(devices, "available_memory", lambda device: memory.total)
    check_memory(memory, CPU, given)
    monkeypatch.setattr(devices, "available_memory", lambda device: None)
    check_memory(memory, CPU, given)  # who does not know does not forbid


def test_what_fits_by_the_advice_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    given = settings(seeds=10, steps=2_000_000, buffer_size=1_000_000, stage_buffer_size=10_000)
    monkeypatch.setattr(devices, "available_memory", lambda device: 700_000_000)
    with pytest.raises(CompileError) as caught:
        check_memory(memory_of(given, 69, 31, 6, []), CPU, given)
    size = re.search(r"[\d_]+`", caught.value.diagnostics[0].help or "")
    assert size is not None
    fitting = given.override({"buffer_size": int(size.group().rstrip("`"))})
    check_memory(memory_of(fitting, 69, 31, 6, []), CPU, fitting)


def test_this_machine_says_how_much_it_has_left() -> None:
    available = available_memory(CPU)
    assert available is None or 1_000_000 < available < 10**15

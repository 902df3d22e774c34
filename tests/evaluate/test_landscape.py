"""The reward over the plane is Eq. 8 with the discriminators that training ended with."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from tests.learn.run.test_train import Task, flatworld, go, grid, point
from tiloilc.evaluate.landscape import SIDE, landscape
from tiloilc.learn import trained_agent
from tiloilc.learn.agent.continuous import SacAgent


@pytest.fixture(autouse=True)
def quick_cloning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tiloilc.learn.agent.cloning.INVERSE_STEPS", 20)
    monkeypatch.setattr("tiloilc.learn.agent.cloning.CLONING_STEPS", 20)


def trained(task: Task, run: Path) -> dict[str, np.ndarray[Any, Any]] | None:
    go(task, run)
    return landscape(*task, run)


def test_every_place_has_its_reward_in_every_state(tmp_path: Path) -> None:
    task = flatworld(steps=100, beta=0.3)
    found = trained(task, tmp_path / "run")
    assert found is not None
    seeds, states = 2, len(task[0].ldba.states)
    assert found["rewards"].shape == (seeds, states, SIDE, SIDE)
    assert (found["x"][[0, -1]].tolist(), found["y"][[0, -1]].tolist()) == ([-2, 2], [-2, 2])
    stages = task[0].stages
    live = [b for b in range(states) if b != task[0].ldba.sink and b not in task[0].ldba.accepting]
    for b in live:
        middle, reach = stages.index[b] / stages.length[b], 0.3 / stages.length[b]
        assert (np.abs(found["rewards"][:, b] - middle) <= reach + 1e-6).all()
    assert any(np.ptp(found["rewards"][:, b]) > 1e-4 for b in live)  # something was learned
    assert (found["rewards"][:, task[0].ldba.sink] == task[0].train.sink_reward).all()


def test_rewards_stand_where_their_axes_say(tmp_path: Path) -> None:
    task = flatworld(steps=100, beta=0.3)
    found = trained(task, tmp_path / "run")
    brought = trained_agent(*task, tmp_path / "run")
    assert found is not None
    assert brought is not None
    row, column = 7, 41
    place = np.array([[found["x"][column], found["y"][row]]], np.float32)
    expected = brought[1].rewards(place)[..., 0]
    np.testing.assert_allclose(found["rewards"][:, :, row, column], expected, atol=1e-6)


def test_the_agent_of_the_last_checkpoint_is_the_trained_one(tmp_path: Path) -> None:
    agents: list[SacAgent] = []

    def keep(agent: SacAgent, *arguments: Any) -> torch.Tensor:
        agents[:] = [agent]
        return original(agent, *arguments)

    original = SacAgent.record
    task = point(steps=100, beta=0.3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(SacAgent, "record", keep)
        go(task, tmp_path / "run")
    brought = trained_agent(*task, tmp_path / "run")
    assert brought is not None
    places = np.random.default_rng(0).normal(size=(50, 2)).astype(np.float32)
    assert torch.equal(brought[1].rewards(places), agents[0].rewards(places))


def test_there_is_no_picture_where_there_is_no_plane_or_no_opinion(tmp_path: Path) -> None:
    assert trained(grid(steps=40), tmp_path / "line") is None
    assert trained(flatworld(steps=40, beta=0), tmp_path / "silent") is None
    task = flatworld(steps=40, beta=0.3)
    (tmp_path / "empty").mkdir()
    assert landscape(*task, tmp_path / "empty") is None

"""Minari datasets: ours there and back, and one that somebody else made."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

from tiloilc.demos import Demo, DemoSet, bundled, load, save
from tiloilc.demos.minari import from_minari, to_minari
from tiloilc.diag import CompileError
from tiloilc.driver import compile_spec, lint

TASK = """\
name: round_trip
environment:
  id: tiloilc/FlatWorld-v0
  horizon: 50
propositions:
  r: dist(pos, [0.45, -0.75]) < 0.3
  b: norm(pos) < 0.8
formula: "F r & G !b"
demonstrations:
  minari: {name}
  count: 3
train:
  steps: 2_000
"""


@pytest.fixture(autouse=True)
def datasets(workdir: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that Minari keeps its datasets in."""
    folder = workdir / "datasets"
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(folder))
    return folder


def plain_dataset(name: str, observations: gym.Space, rows: list[object]) -> None:
    """A dataset made with Minari's own means, as anybody would: one episode, random actions."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import minari
        from minari.data_collector import EpisodeBuffer

        actions = gym.spaces.Box(-1.0, 1.0, (2,), np.float32)
        steps = len(rows) - 1
        episodes = [
            EpisodeBuffer(
                observations=rows
                if not isinstance(rows[0], dict)
                else {key: np.array([row[key] for row in rows]) for key in rows[0]},
                actions=[np.full(2, 0.1 * i, np.float32) for i in range(steps)],
                rewards=[0.0] * steps,
                terminations=[False] * steps,
                truncations=[False] * (steps - 1) + [True],
            )
        ]
        minari.create_dataset_from_buffers(
            name, episodes, observation_space=observations, action_space=actions
        )


def code_of(name: str) -> tuple[str, str, str]:
    with pytest.raises(CompileError) as raised:
        from_minari(name)
    (found,) = raised.value.diagnostics
    return found.code, found.message, found.help


@pytest.mark.parametrize("task", ["flatworld_cycle", "grid_circular_easy"])
def test_there_and_back_is_the_same_to_the_byte(task: str) -> None:
    ours = bundled(task)
    assert ours is not None
    save("before.npz", ours)
    to_minari(f"tiloilc/{task}-v0", ours)
    save("after.npz", from_minari(f"tiloilc/{task}-v0"))
    for suffix in ("npz", "json"):
        assert Path(f"after.{suffix}").read_bytes() == Path(f"before.{suffix}").read_bytes()


def test_states_without_actions_and_without_a_sidecar_come_back_so() -> None:
    walk = np.arange(12, dtype=np.float32).reshape(4, 3)
    to_minari("states-v0", DemoSet((Demo(walk), Demo(walk[:2]))))
    back = from_minari("states-v0")
    assert [demo.steps for demo in back.episodes] == [3, 1]
    np.testing.assert_array_equal(back.episodes[0].observations, walk)
    assert not back.has_actions
    assert "environment" not in back.meta


def test_the_dataset_has_the_spaces_of_its_environment() -> None:
    import minari

    ours = bundled("grid_circular_easy")
    assert ours is not None
    to_minari("grid-v0", ours)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        dataset = minari.load_dataset("grid-v0")
        assert dataset.env_spec.id == "tiloilc/GridCircular-v0"
        env = gym.make("tiloilc/GridCircular-v0", **ours.meta["environment"]["kwargs"])
        assert dataset.observation_space == env.observation_space
        assert dataset.action_space == env.action_space


def test_a_dataset_of_somebody_else_is_a_source_of_demonstrations() -> None:
    way = np.linspace([-1.0, -1.0], [0.45, -0.9], 9).astype(np.float32)
    plain_dataset("else/walk-v3", gym.spaces.Box(-2, 2, (2,), np.float32), list(way))
    text = TASK.format(name="else/walk-v3").replace("count: 3", "count: 1")
    Path("task.yaml").write_text(text, encoding="utf-8")
    found = compile_spec("task.yaml")
    assert [d.code for d in found.diagnostics if d.code.startswith("DEMO")] == []
    (demo,) = found.demos.episodes
    np.testing.assert_array_equal(demo.observations, way)
    assert found.plan.demonstrations.minari == "else/walk-v3"


def test_observations_of_a_dictionary_are_flattened_as_gymnasium_does() -> None:
    space = gym.spaces.Dict(
        {"b": gym.spaces.Box(-9, 9, (2,), np.float64), "a": gym.spaces.Box(-9, 9, (1,), np.float64)}
    )
    rows = [{"a": np.array([float(i)]), "b": np.array([i + 0.5, -i])} for i in range(4)]
    plain_dataset("parts-v0", space, list(rows))
    flat = np.array([gym.spaces.flatten(space, row) for row in rows], np.float32)
    np.testing.assert_array_equal(from_minari("parts-v0").episodes[0].observations, flat)


def test_a_dataset_that_is_not_there_is_a_finding_in_its_place() -> None:
    to_minari("walk-v0", DemoSet((Demo(np.zeros((3, 2), np.float32)),)))
    Path("task.yaml").write_text(TASK.format(name="wlak-v0"), encoding="utf-8")
    found = [d for d in lint("task.yaml") if d.code == "DEMO500"]
    assert [d.help for d in found] == ["did you mean `walk-v0`? known: walk-v0"]
    assert found[0].span is not None
    assert (found[0].span.line, found[0].span.column) == (10, 11)


def test_a_malformed_id_is_refused_before_minari_sees_it(datasets: Path) -> None:
    assert code_of("walk")[0] == "DEMO500"
    with pytest.raises(CompileError) as raised:
        to_minari("walk", DemoSet((Demo(np.zeros((3, 2), np.float32)),)))
    assert [d.code for d in raised.value.diagnostics] == ["DEMO510"]
    assert not datasets.exists() or not any(datasets.iterdir())


def test_a_dataset_that_is_there_is_not_overwritten() -> None:
    demos = DemoSet((Demo(np.zeros((3, 2), np.float32)),))
    to_minari("walk-v0", demos)
    with pytest.raises(CompileError) as raised:
        to_minari("walk-v0", demos)
    assert "it is there already" in raised.value.diagnostics[0].message


def test_states_that_are_no_finite_numbers_are_a_finding() -> None:
    rows = [np.array([0.0, np.nan], np.float32)] * 3
    plain_dataset("nan-v0", gym.spaces.Box(-np.inf, np.inf, (2,), np.float32), list(rows))
    assert "not finite" in code_of("nan-v0")[1]


def test_without_the_package_there_is_one_hint(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "minari", None)
    code, message, help = code_of("walk-v0")
    assert code == "DEMO500"
    assert "`minari` is not installed" in message
    assert help == "pip install 'tiloilc[minari]'"


def test_a_task_file_names_one_source_only() -> None:
    text = TASK.format(name="walk-v0").replace("  count: 3\n", "  file: a.npz\n")
    Path("task.yaml").write_text(text, encoding="utf-8")
    (found,) = [d for d in lint("task.yaml") if d.code == "SPEC108"]
    assert found.message == "`file` and `minari` exclude each other"


def test_files_are_read_as_ever() -> None:
    save("a.npz", DemoSet((Demo(np.zeros((3, 2), np.float32)),)))
    assert load("a.npz").dimensions == 2

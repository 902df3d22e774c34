"""The table of goals: who takes turns, what a row says, what the page and `--json` print."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch.utils.flop_counter import FlopCounterMode

import tiloilc.bench.cold
import tiloilc.bench.memory
from tests.cli.running import Run, runner
from tiloilc.bench import Measurement, Spread, envs
from tiloilc.bench.automata import goals
from tiloilc.bench.automata.measure import Measured, Row
from tiloilc.bench.contestants import cleanrl, floor, optimum, ours, sb3
from tiloilc.bench.contestants.work import Run as Worker
from tiloilc.bench.contestants.work import Work
from tiloilc.bench.page import benchmarks_page
from tiloilc.bench.turns import Contestant, Rates, Share, compare, take_turns
from tiloilc.tasks import IDS

SMALL = Work(batch=8, actor=(8, 8), critic=(8, 8), compiled=False)
JUDGED = replace(SMALL, discriminators=True)
GRID = Work("grid_circular_easy", copies=4)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


def flops(run: Worker) -> int:
    run(2)
    with FlopCounterMode(display=False) as counter:
        run(2)
    return counter.get_total_flops() // 2


# what is measured


def test_a_spread_is_the_median_and_its_quartiles() -> None:
    assert Spread.of([4, 1, 3, 2, 5]) == Spread(3, 2, 4)
    assert Spread.of([7]) == Spread(7, 7, 7)


def test_ratios_are_taken_round_by_round() -> None:
    fast, slow = Rates("fast", (10.0, 40.0, 30.0)), Rates("slow", (1.0, 10.0, 6.0))
    row = compare("work", "pieces/s", fast, slow, 4.5)
    assert row.value == Spread.of([10, 40, 30])
    assert row.theirs == Spread.of([1, 10, 6])
    assert row.ratio == Spread.of([10, 4, 5])
    assert not row.missed
    assert compare("work", "pieces/s", fast, slow, 5.5).missed


def test_who_is_not_installed_is_named_and_misses_no_goal() -> None:
    here, away = Rates("here", (2.0,)), Rates("away", (), "sbx-rl")
    row = compare("work", "pieces/s", here, away, 3)
    assert (row.ratio, row.against) == (None, "away (sbx-rl is not installed)")
    assert not row.missed
    both = compare("work", "pieces/s", Rates("here", (), "mujoco"), away, 3)
    assert (both.value, both.against) == (None, "away (mujoco is not installed)")


@pytest.mark.parametrize(("value", "missed"), [(0.39, False), (0.41, True)])
def test_without_anybody_to_compare_with_the_value_has_a_bound(value: float, missed: bool) -> None:
    row = Measurement("start", Spread.of([value]), "s", goal=0.4)
    assert row.missed == missed
    assert not Measurement("start", Spread.of([value]), "s").missed
    assert Measurement("never", None, "s", goal=0.4).missed


def test_json_has_the_medians() -> None:
    rates = Rates("ours", (1.0, 2.0, 6.0)), Rates("theirs", (1.0, 1.0, 2.0))
    assert compare("work", "pieces/s", *rates, 1.5).to_json() == {
        "name": "work",
        "value": 2.0,
        "unit": "pieces/s",
        "against": "theirs",
        "ratio": 2.0,
        "goal": 1.5,
    }


# contestants


def test_contestants_take_turns_in_processes_of_their_own() -> None:
    told: list[str] = []
    everyone = [
        Contestant("copies", "ours", "product", GRID),
        Contestant("one", "single", "steps", GRID, each=2),
        Contestant("nobody", "single", "steps", Work(GRID.task, needs=("no_such_module",))),
    ]
    copies, one, nobody = take_turns(everyone, 2, 0.01, tell=told.append)
    assert nobody == Rates("nobody", (), "no_such_module")
    assert all(len(found.per_second) == 2 for found in (copies, one))
    assert min(copies.per_second) > 0
    assert told[1:] == ["one: ready", "nobody: no_such_module is not installed"]


def test_a_contestant_that_dies_is_an_error_with_its_last_words() -> None:
    with pytest.raises(RuntimeError, match=r"lost has died:\n(.|\n)*no_such_task"):
        take_turns([Contestant("lost", "single", "steps", Work("no_such_task"))], 1, tell=print)


@pytest.mark.parametrize("work", [SMALL, JUDGED], ids=["plain", "judged"])
@pytest.mark.parametrize("learner", [ours.updates, sb3.updates], ids=["ours", "sb3"])
def test_learners_update(learner: object, work: Work) -> None:
    assert callable(learner)
    learner(work)(2)


def test_the_floor_takes_no_more_products_than_any_learner() -> None:
    work = Work()
    floor.updates(work)(1)
    shapes = [(*left.shape, right.shape[1]) for left, right, _ in floor.products(work)]
    least = sum(2 * n * k * m for n, k, m in shapes)
    for learner in (sb3.updates, cleanrl.updates):
        assert least <= flops(learner(work)) < 2 * least


def test_work_survives_the_command_line() -> None:
    work = Work("halfcheetah", actor=(3, 4), discriminators=True, needs=("mujoco",))
    assert Work.from_json(work.to_json()) == work
    assert work.path.is_file()
    assert Work("flatworld_cycle").path.is_file()


@pytest.mark.slow
def test_training_ends_when_the_seeds_are_near_the_optimum(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["optimum", Work("grid_avoid_easy").to_json()])
    optimum.main()
    found = json.loads(capsys.readouterr().out)
    assert (found["seeds"], found["wanted"]) == (10, pytest.approx(0.9 * 11))
    assert 0 < found["seconds"] < 300


@pytest.mark.slow
def test_full_buffers_take_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    work = Work("flatworld_cycle", compiled=False)
    monkeypatch.setattr(tiloilc.bench.memory, "WORK", work)
    (row,) = tiloilc.bench.memory.measure(1, print)
    assert row.value is not None
    transitions = 10 * 1_000_000 * 9 * 4 / 2**20
    assert transitions < row.value.median < 10 * transitions


# automata


def test_automata_are_in_the_table_of_goals() -> None:
    fine, large = Measured(2, 0, 1.0), Measured(4, 0, 9.0)
    rows = [Row("one", "F a", 2, fine, fine), Row("two", "G a", 3, large, large)]
    states, above, times = goals.measurements(rows)
    assert states.value == Spread(6, 6, 6)
    assert above.value == Spread(1, 1, 1)
    assert above.missed
    assert times.value == Spread(5, 3, 7)
    assert goals.measurements([]) == []


# pages


def test_the_page_marks_what_is_missed_and_tells_where_the_time_goes() -> None:
    ours_, theirs = Rates("ours", (200.0, 300.0)), Rates("theirs", (100.0, 100.0))
    rows = [
        compare("fast", "updates/s", ours_, theirs, 2),
        compare("slow", "updates/s", ours_, theirs, 3),
        compare("alone", "updates/s", ours_, Rates("away", (), "sbx-rl"), 3),
        Measurement("start", Spread.of([0.123]), "s", goal=0.4),
        Measurement("memory", Spread.of([1234.5]), "MiB"),
    ]
    profiles = {"One seed": [Share("aten::mm", 1.5, 4)], "Ten": [Share("aten::bmm", 3.0, 2)]}
    page = benchmarks_page({"sac": rows}, profiles, {"torch": "2.13.0"})
    assert (
        "| fast | updates/s | 250 (225–275) | theirs | 100 | 2.5× (2.25–2.75) | ≥ 2× | yes |"
        in page
    )
    assert "| ≥ 3× | **missed** |" in page
    assert "| away (sbx-rl is not installed) | – | – | ≥ 3× | – |" in page
    assert "| start | s | 0.123 | – | – | – | ≤ 0.4 s | yes |" in page
    assert "| memory | MiB | 1,234 | – | – | – | – | – |" in page
    assert "1 of 4 goals are missed." in page
    assert "### One seed: 1.50 ms" in page
    assert "| `aten::mm` | 4 | 1.500 | 100% |" in page
    assert "### Ten: 3.00 ms" in page


def test_cold_commands_are_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tiloilc.bench.cold, "COMMANDS", {"version": (["--version"], 60.0)})
    seconds, imports = tiloilc.bench.cold.measure(1, print)
    assert seconds.value is not None
    assert 0 < seconds.value.median < 60
    assert imports.value == Spread(0, 0, 0)


def test_an_import_of_torch_is_seen() -> None:
    traced = b"import time: 5 | 7 | torch\nimport time: 5 | 7 |   torch._C\n"
    assert len(tiloilc.bench.cold.IMPORTED.findall(traced)) == 1


# the command


def test_the_command_prints_a_list(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tiloilc.bench.cold, "COMMANDS", {"version": (["--version"], 60.0)})
    status, out, err = run("bench", "--only", "cold", "--rounds", "1", "--json")
    assert status == 0
    (first, second) = json.loads(out)
    assert list(first) == ["name", "value", "unit", "against", "ratio", "goal"]
    assert first["name"] == "version, cold"
    assert (second["value"], second["goal"]) == (0, 0)
    assert err.startswith("version: ")


def test_half_a_page_is_not_written(run: Run, tmp_path: Path) -> None:
    status, out, err = run("bench", "--only", "cold", "-o", tmp_path / "docs")
    assert (status, out) == (2, "")
    assert "`-o` writes whole pages" in err
    assert not (tmp_path / "docs").exists()


@pytest.fixture(autouse=True)
def one_thread() -> None:
    torch.set_num_threads(1)


def test_every_environment_is_stepped_and_a_million_steps_are_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def turns(contestants: list[Contestant], rounds: int, *, tell: object) -> list[Rates]:
        many, one = contestants
        assert (many.work.threads, one.work.threads) == (many.work.copies == envs.ROBOTS, False)
        assert many.work.path.is_file()
        return [Rates(many.title, (2e6, 2e6)), Rates(one.title, (1e5, 1e5))]

    monkeypatch.setattr(envs, "take_turns", turns)
    rows = envs.measure(2, lambda line: None)
    worlds = {row.name.split()[-1] for row in rows if row.name.startswith("a million")}
    assert {f"tiloilc/{world}-v0" for world in worlds} >= set(IDS) - {
        f"tiloilc/{grid}-v0" for grid in ("GridAvoid", "GridSequential")
    }
    steps, million = rows[:2]
    assert steps.ratio is not None
    assert (steps.ratio.median, steps.goal) == (20, 10)
    assert million.value is not None
    assert million.value.median == 0.5

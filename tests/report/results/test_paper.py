"""The paper's numbers, as typed once."""

import math
from pathlib import Path

from tiloilc.report.results import paper
from tiloilc.report.results.tasks import TITLES

ROOT = Path(__file__).parents[3]


def test_every_number_is_of_a_task_that_is_here() -> None:
    tasks = {task for _, task, _ in paper.numbers()}
    assert tasks <= set(TITLES)
    assert all((ROOT / "specs" / f"{task}.yaml").is_file() for task in TITLES)


def test_the_tables_are_whole() -> None:
    count: dict[str, int] = {}
    for source, _, _ in paper.numbers():
        count[source] = count.get(source, 0) + 1
    assert count == {"table 1": 63, "table 2": 14, "table 3": 2, "table 4": 6, "figure 6": 6}


def test_tables_agree_where_they_repeat_each_other() -> None:
    found = paper.numbers()
    for source, task, column in found:
        if source == "table 2" and column == "separate":
            same = found["table 1", task, "beta=1/3"]
            assert (same.mean, same.sd) == (found[source, task, column].mean, same.sd)


def test_the_best_is_of_any_of_the_papers_own_settings() -> None:
    best = paper.best("doggo_avoid")
    assert best is not None
    assert (best.text, best.source) == ("360 ± 20", "table 2")
    assert paper.best("sixteen_rooms") is None


def test_the_method_goes_by_its_usual_beta() -> None:
    printed = paper.of_algorithm("fetch_align", "tiloil")
    assert printed is not None
    assert printed.text == "21 ± 15.9"
    assert paper.of_algorithm("fetch_align", "pwil") is None


def test_a_number_without_a_spread_is_written_alone() -> None:
    full = paper.numbers()["figure 6", "carlo", "full"]
    assert math.isnan(full.sd)
    assert full.text == "111"

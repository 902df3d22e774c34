from __future__ import annotations

from pathlib import Path

from tiloilc.evaluate import read, split_seeds
from tiloilc.report.results import results_page

ROOT = Path(__file__).parents[2]


def evaluation(visits: list[float], **changes: object) -> dict[str, object]:
    judged = {
        "accepting_visits": visits,
        "violation_rate": [0.0] * len(visits),
        "success": [1.0] * len(visits),
        "eventual_return": visits,
        "first_visit": [3.0] * len(visits),
    }
    return {
        "name": "demo",
        "algorithm": "tiloil",
        "preset": "default",
        "overrides": {"beta": 0.0, "seeds": len(visits)},
        "steps": 1000,
        "seeds": list(range(len(visits))),
        "greedy": judged,
        "last": judged,
        "stochastic": judged,
        "cloning": None,
        "optimum": {"accepting_visits": 4.0, "exact": False, "how": "lattice"},
        "curve": [],
        "interrupted": False,
        **changes,
    }


def test_the_page_of_results_is_that_of_the_records() -> None:
    records = read(*sorted((ROOT / "results").glob("*.jsonl.gz")))
    assert (ROOT / "docs/results.md").read_text(encoding="utf-8") == results_page(records)


def test_a_row_has_the_spread_over_seeds_and_the_bound() -> None:
    page = results_page(split_seeds(evaluation([2.0, 4.0]), "spec"))
    row = page.splitlines()[-1]
    assert "| tiloil default beta=0.0 | 2 | 1,000 | 3.00 ± 1.41 |" in row
    assert row.endswith("| – | ≥ 4 |")


def test_other_settings_are_another_row() -> None:
    records = split_seeds(evaluation([2.0]), "spec")
    records += split_seeds(evaluation([3.0], overrides={"gamma": 0.9}), "spec")
    assert len(results_page(records).splitlines()) == len(results_page([]).splitlines()) + 2


def test_rows_that_differ_in_one_setting_are_compared() -> None:
    records = split_seeds(evaluation([3.0] * 5, overrides={"gamma": 0.9}), "spec")
    records += split_seeds(evaluation([1.0] * 5, overrides={"gamma": 0.9, "beta": 0.0}), "spec")
    records += split_seeds(evaluation([2.0] * 5, overrides={"beta": 0.0, "tau": 0.1}), "spec")
    records += split_seeds(evaluation([2.0], overrides={}, steps=2000), "spec")
    _, found, compared = results_page(records).partition("One thing changed")
    assert found
    (row,) = (line for line in compared.splitlines() if line.startswith("| `demo`"))
    assert "| tiloil default gamma=0.9 | beta=0.0 | 3.00 ± 0.00 | 1.00 ± 0.00 |" in row
    assert row.endswith("| -2.00 [-2.00, -2.00] |")

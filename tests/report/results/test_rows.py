"""Which records make a row, and which row a page means."""

from pathlib import Path

import pytest

from tests.report.results.records import records
from tiloilc.report.results.book import Book
from tiloilc.report.results.methods import METHODS
from tiloilc.report.results.rows import Row, rows_of
from tiloilc.report.results.tasks import TaskFile, read_tasks

ROOT = Path(__file__).parents[3]
OWN = {"beta": 0.0, "gamma": 0.8}


@pytest.fixture(scope="module")
def files() -> dict[str, TaskFile]:
    return read_tasks(ROOT / "specs")


def visits(row: Row | None) -> list[float]:
    assert row is not None
    return row.values("greedy").tolist()


def test_runs_that_differ_in_their_seeds_or_machine_are_one_row(files: dict[str, TaskFile]) -> None:
    found = records([1.0, 2.0])
    found += records([3.0], first_seed=202, overrides={**OWN, "device": "cpu", "seeds": 1})
    (row,) = rows_of(found, files)
    assert row.seeds == (200, 201, 202)
    assert row.named == "beta=0 gamma=0.8"


def test_other_settings_steps_methods_and_demonstrations_are_other_rows(
    files: dict[str, TaskFile],
) -> None:
    given = files["flatworld_cycle"].demonstrations
    found = records([1.0], demonstrations=given)
    found += records([2.0], overrides={**OWN, "segment": False})
    found += records([3.0], steps=40_000)
    found += records([4.0], algorithm="lcer", overrides={**OWN, "algorithm": "lcer"})
    found += records([5.0], demonstrations={**given, "count": 10})
    rows = rows_of(found, files)
    assert len(rows) == len({row.anchor for row in rows}) == 5
    assert sorted(row.named for row in rows if row.demonstrations) == [
        "beta=0 gamma=0.8 demonstrations.count=10"
    ]


def test_where_a_row_has_fresh_seeds_only_they_count(files: dict[str, TaskFile]) -> None:
    (row,) = rows_of([*records([1.0] * 3, first_seed=0), *records([2.0], first_seed=200)], files)
    assert row.seeds == (200,)
    (row,) = rows_of(records([1.0] * 3, first_seed=0), files)
    assert row.seeds == (0, 1, 2)


def test_of_one_seed_at_several_commits_the_latest_counts(files: dict[str, TaskFile]) -> None:
    old = records([1.0, 1.0, 1.0], git_commit="fffffff")
    new = records([2.0], git_commit="1111111", git_time=1_700_000_000)
    for order in ([*old, *new], [*new, *old]):
        (row,) = rows_of(order, files)
        assert visits(row) == [2.0, 1.0, 1.0]
    assert row.commits == ("1111111", "fffffff")


def test_a_run_that_was_cut_short_does_not_count(files: dict[str, TaskFile]) -> None:
    assert rows_of(records([1.0], interrupted=True), files) == []


def test_the_usual_row_has_the_task_files_settings_and_is_the_longest(
    files: dict[str, TaskFile],
) -> None:
    found = records([1.0], steps=9_000)
    found += records([2.0], steps=54_000)
    found += records([3.0], overrides={"gamma": 0.8}, steps=90_000)
    found += records([4.0], demonstrations={"source": "expert", "count": 10}, steps=90_000)
    found += records([5.0], preset="paper", overrides={})
    book = Book.of(found, files)
    assert visits(book.usual("flatworld_cycle", "tiloil")) == [2.0]
    assert visits(book.usual("flatworld_cycle", "tiloil", "paper")) == [5.0]
    assert book.usual("flatworld_cycle", "lcer") is None


def test_the_paper_presets_row_keeps_as_little_of_the_task_file_as_there_is(
    files: dict[str, TaskFile],
) -> None:
    task = "flatworld_disjunction"
    own = files[task].defaults("paper", "tiloil")
    assert {"gamma", "beta"} <= own.keys()
    found = records([1.0], name=task, preset="paper", overrides=own, steps=90_000)
    assert visits(Book.of(found, files).usual(task, "tiloil", "paper")) == [1.0]
    some = {name: value for name, value in own.items() if name != "gamma"}
    found += records([2.0], name=task, preset="paper", overrides=some, steps=10)
    assert visits(Book.of(found, files).usual(task, "tiloil", "paper")) == [2.0]
    found += records([3.0], name=task, preset="paper", overrides={"gamma": 0.7}, steps=90_000)
    assert visits(Book.of(found, files).usual(task, "tiloil", "paper")) == [2.0]


def test_what_a_run_of_a_task_file_with_another_method_records_is_that_methods_usual_row(
    files: dict[str, TaskFile],
) -> None:
    for name, file in files.items():
        for algorithm in METHODS:
            train = file.train.override({"algorithm": algorithm, "first_seed": 200, "seeds": 1})
            changes = {"name": name, "algorithm": algorithm, "overrides": train.overrides()}
            book = Book.of(records([1.0], steps=train.steps, **changes), files)
            assert book.usual(name, algorithm) is not None, (name, algorithm)


def test_families_differ_in_their_settings_only(files: dict[str, TaskFile]) -> None:
    found = records([1.0], overrides={"gamma": 0.8})
    found += records([2.0], overrides={"gamma": 0.8, "segment": False})
    found += records([3.0], overrides={"gamma": 0.8, "segment": False, "beta": 0.25})
    (family,) = Book.of(found, files).families("flatworld_cycle", "segment")
    assert visits(family.get()) == [1.0]
    assert visits(family.get(segment="false")) == [2.0]
    assert family.named("segment") == "default gamma=0.8"


def test_without_a_family_the_usual_row_stands_alone(files: dict[str, TaskFile]) -> None:
    (family,) = Book.of(records([1.0]), files).families("flatworld_cycle", "beta")
    assert visits(family.get(beta="0")) == [1.0]
    (family,) = Book.of([], files).families("flatworld_cycle", "beta")
    assert not family.members


def test_a_row_says_what_it_lacks(files: dict[str, TaskFile]) -> None:
    assert rows_of(records([1.0] * 10), files)[0].lacks == ""
    (row,) = rows_of(records([1.0], steps=9_000), files)
    assert row.lacks == "1 seed, 9,000 of 54,000 steps"


def test_a_curve_has_the_steps_that_all_seeds_share(files: dict[str, TaskFile]) -> None:
    found = records([1.0], curve=[[1.0], [2.0], [3.0]])
    found += records([1.0], first_seed=201, curve=[[4.0], [5.0]])
    steps, values = rows_of(found, files)[0].curve("accepting_visits")
    assert steps == [1000, 2000]
    assert values.tolist() == [[1.0, 4.0], [2.0, 5.0]]

"""The benchmark of automata: what is measured, read and told."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import pytest

import tiloilc.bench
from tests.cli.running import Run, runner
from tiloilc.bench import (
    BOMBS,
    PAPER,
    Alone,
    BadReferences,
    Figures,
    Measured,
    Reference,
    Row,
    automata_page,
    measure,
    measure_alone,
    measure_known,
    measure_set,
    read_references,
)

TABLE = """\
set,formula,asymmetric,asymmetric_portfolio,symmetric,symmetric_portfolio,best
one,Fa,2,2,2,2,2
one,FGa,3,4,5,6,3
two,Ga | Fb,1,1,1,1,1
"""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    (tmp_path / "reference_sizes.csv").write_text(TABLE, encoding="utf-8")
    return tmp_path


@pytest.fixture
def one_bomb(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tiloilc.bench, "BOMBS", {"small": "F G a"})


def test_states_are_counted_without_the_sink() -> None:
    found = measure("F G a & G !b", "edge")
    assert (found.states, found.jumps, found.code) == (2, 1, None)
    assert found.ms > 0


def test_a_formula_beyond_the_limits_is_measured_as_the_code_it_ends_in() -> None:
    assert measure(BOMBS["16 steps back"], "state").code == "AUT305"


def test_a_table_of_published_sizes_is_read_row_by_row(data: Path) -> None:
    first, second, third = read_references(data)
    assert first == Reference("one", "Fa", (2, 2, 2, 2), 2)
    assert second.sizes == (3, 4, 5, 6)
    assert third.origin == "two"


@pytest.mark.parametrize("text", ["set,formula\none,Fa\n", TABLE + "one,Gb,x,1,1,1,1\n"])
def test_another_table_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "reference_sizes.csv").write_text(text, encoding="utf-8")
    with pytest.raises(BadReferences, match="not a table with the columns set, formula, asym"):
        read_references(tmp_path)


def test_sizes_are_compared_with_the_best_known_one(data: Path) -> None:
    same, smaller, larger = measure_set(read_references(data), 1)
    assert [row.edge.states for row in (same, smaller, larger)] == [2, 2, 3]
    assert [row.is_above for row in (same, smaller, larger)] == [False, False, True]
    assert [row.is_below for row in (same, smaller, larger)] == [False, True, False]


def test_a_formula_that_fails_is_above_every_size() -> None:
    failed, fine = Measured(0, 0, 1.0, "AUT305"), Measured(4, 0, 1.0)
    row = Row("one", "F a", 3, failed, fine)
    assert row.is_above
    assert not row.is_below


def test_one_formula_in_a_hundred_may_be_later_than_the_99th_percentile() -> None:
    assert Figures.of(range(1, 101)) == Figures(50.5, 99, 100)
    assert Figures.of([7]) == Figures(7, 7, 7)


def test_the_page_sums_each_set_and_names_what_is_larger(data: Path) -> None:
    rows = list(measure_set(read_references(data), 1))
    page = automata_page(rows, [rows[0]], [], 1)
    assert "| one | 2 | 5 | 6 | 7 | 8 | 5 | **4** | 0 | 1 | 1 | 4 |" in page
    assert "| all | 3 | 6 | 7 | 8 | 9 | 6 | **7** | 1 | 1 | 1 | 7 |" in page
    assert "| `Ga \\| Fb` | 1 | 3 |" in page
    assert "No formula is larger" in automata_page(rows[:2], [rows[0]], [], 1)


def test_what_failed_is_not_hidden_in_a_sum() -> None:
    reference = Reference("one", "F a", (3, 3, 3, 3), 3)
    failed, fine = Measured(0, 0, 1.0, "AUT305"), Measured(4, 0, 1.0)
    rows = [Row("one", "F a", 3, failed, fine, reference)]
    page = automata_page(rows, rows, [Alone("big", "F a | b", failed, 50.4)], 3)
    assert "**0 and 1 failed**" in page
    assert "| `F a` | 3 | AUT305 |" in page
    assert "| big | `F a \\| b` | AUT305 | 0.0 | 50 |" in page


def test_the_committed_page_has_todays_sizes_of_the_papers_formulas(root: Path) -> None:
    page = automata_page([], list(measure_known(PAPER, 1)), [], 1)
    section = "## Formulas of the paper"
    committed = (root / "docs" / "automaton_sizes.md").read_text(encoding="utf-8")
    today = section + page.partition(section)[2].partition("## ")[0]
    assert today in committed, "run `make bench`"
    assert committed.startswith(page.partition("## ")[0])


def test_no_formula_of_the_paper_is_larger_than_the_best_known_automaton() -> None:
    assert [row.name for row in measure_known(PAPER, 1) if row.is_above] == []


@pytest.mark.parametrize("name", BOMBS)
def test_a_formula_bomb_ends_within_a_gigabyte(name: str) -> None:
    (found,) = measure_alone({name: BOMBS[name]})
    assert found.measured.code in (None, "AUT305")
    assert 10 < found.peak < 1024


def test_the_command_prints_a_page(run: Run, data: Path, one_bomb: None) -> None:
    status, out, err = run("bench", "--only", "automata", "--data", data, "--runs", "1")
    assert status == 0
    assert out.startswith("# Sizes of automata\n")
    assert "| small | `F G a` | 2 |" in out
    assert "3 of 3 formulas" in err


def test_the_command_writes_a_page(run: Run, data: Path, one_bomb: None) -> None:
    docs = data / "docs"
    options = ("--only", "automata", "--data", data, "--runs", "1", "-o", docs, "--quiet")
    assert run("bench", *options) == (0, "", "")
    assert [path.name for path in docs.iterdir()] == ["automaton_sizes.md"]
    page = (docs / "automaton_sizes.md").read_text(encoding="utf-8")
    assert page.startswith("# Sizes of automata\n")


def test_the_command_lists_each_formula(
    run: Run, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TILOILC_LTL_DATA", str(data))
    status, out, _ = run("bench", "--csv", "--runs", "1")
    rows = list(csv.DictReader(io.StringIO(out)))
    assert status == 0
    assert [row["edge"] for row in rows] == ["2", "2", "3"]
    assert [row["best"] for row in rows] == ["2", "3", "1"]
    assert all(float(row["ms"]) > 0 for row in rows)


def test_without_published_sizes_the_papers_formulas_are_left(
    run: Run, workdir: Path, one_bomb: None
) -> None:
    status, out, err = run("bench", "--only", "automata", "--runs", "1")
    assert status == 0
    assert "no published sizes in `../shared/data/ltl`; give --data DIR" in err
    assert "literature" not in out
    assert "| circular_2 |" in out


@pytest.mark.parametrize("option", [("--csv",), ("-o", "docs")])
def test_what_needs_published_sizes_says_so(
    run: Run, workdir: Path, option: tuple[str, ...]
) -> None:
    status, out, err = run("bench", "--only", "automata", *option)
    assert (status, out) == (2, "")
    assert err.startswith("error: no published sizes in")
    assert not Path("docs").exists()


def test_a_folder_without_the_table_is_a_usage_error(run: Run, workdir: Path) -> None:
    status, out, err = run("bench", "--only", "automata", "--data", ".")
    assert (status, out) == (2, "")
    assert err == "error: cannot read `reference_sizes.csv`: No such file or directory\n"

"""The pages of results: they are those of the records, and say what was and was not run."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.report.results.records import records
from tiloilc.evaluate import Record, append
from tiloilc.report.results.__main__ import main
from tiloilc.report.results.book import Book, open_book
from tiloilc.report.results.measures import mean_of_tasks
from tiloilc.report.results.pages import (
    ablations,
    comparison,
    demonstrations,
    efficiency,
    every,
    index,
    learning,
    readme,
    verified,
)
from tiloilc.report.results.tasks import TaskFile, read_tasks
from tiloilc.report.results.write import files as all_files
from tiloilc.report.results.write import write

ROOT = Path(__file__).parents[3]
PAGES = ROOT / "docs" / "results"
RISE = [[1.0, 1.0], [2.0, 3.0], [4.0, 4.0]]


@pytest.fixture(scope="module")
def files() -> dict[str, TaskFile]:
    return read_tasks(ROOT / "specs")


@pytest.fixture(scope="module")
def book_of_records() -> Book:
    return open_book(ROOT / "results", ROOT / "specs")


@pytest.fixture(scope="module")
def recorded(book_of_records: Book) -> dict[str, str]:
    return all_files(book_of_records)


def lcer(visits: list[float], **changes: object) -> list[Record]:
    overrides = {"beta": 0.0, "gamma": 0.8, "algorithm": "lcer"}
    return records(visits, algorithm="lcer", overrides=overrides, **changes)


def line_of(page: str, begin: str) -> str:
    """The one line that begins so, with ordinary spaces."""
    (found,) = (line for line in page.splitlines() if line.startswith(begin))
    return found.replace("\u00a0", " ")


def test_the_pages_are_those_of_the_records(recorded: dict[str, str]) -> None:
    there = [*PAGES.rglob("*.md"), *PAGES.rglob("*.svg")]
    found = {p.relative_to(PAGES).as_posix(): p.read_text(encoding="utf-8") for p in there}
    assert sorted(found) == sorted(recorded), "run `make results`"
    for name, text in recorded.items():
        assert found[name] == text, f"{name} is of other records: run `make results`"


def test_the_readme_shows_what_the_records_say(book_of_records: Book) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text == readme.fill(text, book_of_records)


def test_every_link_leads_somewhere(recorded: dict[str, str]) -> None:
    anchors = set(re.findall(r'<a id="([^"]+)">', recorded["all.md"]))
    links = 0
    for name, text in recorded.items():
        if not name.endswith(".md"):
            continue
        shown = re.findall(r"\]\(([^)]+)\)", text) + re.findall(r'src="([^"]+)"', text)
        for link in shown:
            path, _, anchor = link.partition("#")
            assert (PAGES / path).resolve().exists(), f"{name}: {link}"
            assert not anchor or anchor in anchors, f"{name}: {link}"
            links += 1
    assert links > 100


def test_every_figure_stands_on_a_page(recorded: dict[str, str]) -> None:
    pages = "".join(text for name, text in recorded.items() if name.endswith(".md"))
    figures = {name for name in recorded if name.endswith(".svg")}
    assert len(figures) > 20
    assert {name for name in figures if name not in pages} == {"overview.svg"}  # README's


def test_figures_are_small(recorded: dict[str, str]) -> None:
    sizes = {n: len(t.encode()) for n, t in recorded.items() if n.endswith(".svg")}
    assert sizes
    assert max(sizes.values()) < 60_000


def test_the_same_records_give_the_same_pages_in_any_order(files: dict[str, TaskFile]) -> None:
    found = [*records([2.0, 4.0], curve=RISE), *lcer([1.0, 2.0], curve=RISE)]
    assert all_files(Book.of(found, files)) == all_files(Book.of(found[::-1], files))


def test_writing_removes_what_is_no_longer_made(tmp_path: Path) -> None:
    (tmp_path / "curves").mkdir()
    (tmp_path / "curves/old.svg").write_text("")
    write({"README.md": "a", "curves/new.svg": "b"}, tmp_path)
    assert sorted(p.name for p in tmp_path.rglob("*.*")) == ["README.md", "new.svg"]


def test_a_row_of_all_names_its_spread_its_bound_and_its_records(
    files: dict[str, TaskFile],
) -> None:
    old = records([9.0], steps=9, optimum={"accepting_visits": 9.0, "exact": False})
    text = every.page(Book.of([*records([2.0, 4.0]), *old], files))
    row = next(line for line in text.splitlines() if "| 54,000 |" in line)
    assert "`flatworld_cycle` | tiloil default beta=0 gamma=0.8 | 2 | 54,000 | 3.00 ± 1.41 |" in row
    end = "| – | ≥ 9 | seeds [200–201](../../results/flatworld_cycle.jsonl.gz) at abcdef0 |"
    assert row.endswith(end)


def test_rows_that_differ_in_one_setting_are_compared(files: dict[str, TaskFile]) -> None:
    found = records([3.0] * 5, overrides={"gamma": 0.9})
    found += records([1.0] * 5, overrides={"gamma": 0.9, "beta": 0.0})
    found += records([2.0] * 5, overrides={"beta": 0.0, "tau": 0.1})
    found += records([2.0], overrides={}, steps=2000)
    _, _, compared = every.page(Book.of(found, files)).partition("One thing changed")
    row = line_of(compared, "| `flatworld_cycle`")
    assert "| tiloil default gamma=0.9 | 54,000 | beta=0 | 3.00 ± 0.00 | 1.00 ± 0.00 |" in row
    assert row.endswith("| -2.00 [-2.00, -2.00] |")


def test_the_overview_marks_the_best_and_says_what_was_not_run(files: dict[str, TaskFile]) -> None:
    book = Book.of([*records([4.0] * 10), *lcer([1.0] * 10)], files)
    page = index.index(book)
    row = line_of(page, "| FlatWorld Cycle |")
    cells = [cell.strip() for cell in row.split("|")][1:-1]
    assert cells[1:4] == ["≥ 4", "2.8 ± 0.1<br><sub>table 2</sub>", "–"]
    assert cells[4].startswith("[**4.00 ± 0.00**](all.md#r-")
    assert "paper 2.3 ± 0.8" in cells[4]
    assert cells[5].startswith("[1.00 ± 0.00](all.md#r-")
    assert "paper 1.6 ± 0.6" in cells[5]
    assert cells[6].startswith("not run<br>")
    assert "- **TiLoIL**: in full on FlatWorld Cycle; not run on " in page
    assert "- **GAIL**: not run on any task." in page


def test_equal_methods_are_both_marked_and_one_alone_is_not(files: dict[str, TaskFile]) -> None:
    alone = Book.of(records([4.0] * 10), files)
    assert "**4.00" not in index.index(alone)
    both = Book.of([*records([3.0, 4.0] * 5), *lcer([4.0, 3.0] * 5)], files)
    row = line_of(index.index(both), "| FlatWorld Cycle |")
    assert row.count("**3.50 ± 0.53**") == 2


def test_a_method_with_other_settings_only_is_not_said_to_be_not_run(
    files: dict[str, TaskFile],
) -> None:
    page = index.index(Book.of(records([1.0], overrides={"gamma": 0.5}), files))
    assert "with other settings than the task file's only on [FlatWorld Cycle](all.md)" in page


def test_a_section_has_returns_efficiency_and_the_command_for_what_is_missing(
    files: dict[str, TaskFile],
) -> None:
    page = learning.figure_3(Book.of(records([2.0, 4.0], curve=RISE), files))
    row = line_of(page, "| TiLoIL | [3.00")
    assert "2.3 ± 0.8 | 1.50 ± 0.71 | 0.0% | 3k | 3k | 2.50 ± 0.35 |" in row
    command = "tiloilc run specs/flatworld_cycle.yaml --set algorithm=lcer --set first_seed=200"
    assert f"`{command} --record results/flatworld_cycle.jsonl.gz`" in page
    assert "fewer than ten seeds: TiLoIL (2 seeds)." in page
    assert 'src="curves/flatworld_cycle.svg"' in page
    assert 'src="curves/carlo.svg"' not in page


def test_shorter_rows_say_so_in_their_cell(files: dict[str, TaskFile]) -> None:
    page = learning.figure_3(Book.of(records([2.0], steps=9_000), files))
    assert "<sub>1\u00a0×\u00a09k\u00a0of\u00a054k</sub>" in page


def test_parts_left_out_stand_beside_the_whole(files: dict[str, TaskFile]) -> None:
    found = records([4.0] * 5, overrides={"gamma": 0.8}, curve=[[4.0] * 5] * 2)
    cut = {"gamma": 0.8, "segment": False}
    found += records([1.0] * 5, overrides=cut, curve=[[1.0] * 5] * 2)
    made = ablations.files(Book.of(found, files))
    assert "ablations/flatworld_cycle.svg" in made
    row = line_of(made["figure-4.md"], "| FlatWorld Cycle |")
    assert "| default gamma=0.8 | [4.00 ± 0.00]" in row
    assert "[1.00 ± 0.00]" in row
    assert "-3.00 [-3.00, -3.00]" in row
    assert row.endswith("| not run | ≥ 4 |")


def test_ablations_that_were_run_again_for_longer_stand_once(files: dict[str, TaskFile]) -> None:
    whole = {"gamma": 0.8}
    short = records([1.0] * 5, overrides=whole, steps=36_000)
    short += records([2.0] * 5, overrides={**whole, "stages": False}, steps=36_000)
    long = records([3.0] * 5, overrides=whole)
    half = Book.of([*short, *long], files)
    assert "[2.00 ± 0.00]" in line_of(ablations.files(half)["figure-4.md"], "| FlatWorld Cycle |")
    long += records([4.0] * 5, overrides={**whole, "stages": False})
    made = ablations.files(Book.of([*short, *long], files))
    assert made["figure-4.md"].count("| FlatWorld Cycle |") == 1
    assert "[4.00 ± 0.00]" in line_of(made["figure-4.md"], "| FlatWorld Cycle |")


def test_betas_stand_in_the_papers_columns(files: dict[str, TaskFile]) -> None:
    found = records([1.0] * 5, overrides={"gamma": 0.8})
    for i, beta in enumerate((0.49, 0.25, 0.0)):
        found += records([2.0 + i] * 5, overrides={"gamma": 0.8, "beta": beta})
    row = line_of(ablations.table_1(Book.of(found, files)), "| FlatWorld Cycle |")
    cells = [cell.strip() for cell in row.split("|")][3:7]
    assert [cell[1:5] for cell in cells] == ["2.00", "1.00", "3.00", "4.00"]
    assert ["paper" in cell for cell in cells] == [True, True, True, False]


def test_one_discriminator_stands_beside_many(files: dict[str, TaskFile]) -> None:
    found = records([1.0] * 5) + records(
        [2.0] * 5, overrides={"beta": 0.0, "gamma": 0.8, "discriminator": "shared"}
    )
    row = line_of(ablations.table_2(Book.of(found, files)), "| FlatWorld Cycle |")
    assert "[1.00 ± 0.00]" in row
    assert "| +1.00 [+1.00, +1.00] |" in row
    assert "paper 2.8 ± 0.1" in row


def test_demonstrations_that_differ_have_their_pages(files: dict[str, TaskFile]) -> None:
    given, asked = files["carlo"].demonstrations, files["carlo"].train
    carlo = {"name": "carlo", "overrides": asked.overrides(), "steps": asked.steps}
    unsafe = {"file": "../x/carlo_unsafe.npz", "count": 5, "max_visits": 2, "actions": "inferred"}
    found = records([1.0], **carlo, demonstrations=given, curve=[[1.0], [2.0]])
    found += records([2.0], **carlo, demonstrations={**given, "count": 111}, curve=[[1.0], [2.0]])
    found += records([3.0], **carlo, demonstrations=unsafe)
    found += records([4.0], **carlo, demonstrations={**given, "max_steps": 200})
    book = Book.of(found, files)
    made = demonstrations.files(book)
    assert [name for name in made if name.endswith(".svg")] == [
        "demonstrations/figure-6/carlo.svg", "demonstrations/figure-7/carlo.svg"
    ]  # fmt: skip
    sizes = line_of(made["figure-6.md"], "| Carlo |")
    assert re.findall(r"\[(\d\.00) ± 0.00\]", sizes) == ["1.00", "2.00"]
    assert "(111)" in sizes
    assert "[3.00 ± 0.00]" in line_of(demonstrations.table_3(book), "| Carlo |")
    lengths = line_of(demonstrations.table_4(book), "| Carlo |")
    assert re.findall(r"\[(\d\.00) ± 0.00\]", lengths) == ["1.00", "4.00"]
    assert lengths.count("not run") == 2


def test_how_likely_the_method_is_better_is_told_by_baseline(files: dict[str, TaskFile]) -> None:
    book = Book.of([*records([4.0, 2.0], curve=RISE), *lcer([2.0, 2.0], curve=RISE)], files)
    page = comparison.files(book)["comparison.md"]
    row = line_of(page, "| LCER |")
    assert row.startswith("| LCER | 1 task | 0.75 [0.50, 1.00] | 0.75 [0.50, 1.00] |")
    assert "| GAIL | 0 | not run | – | – | – | – |" in page
    assert "| FlatWorld Cycle | [LCER](all.md#r-" in page


def test_the_readme_needs_its_markers() -> None:
    book = Book.of([], {})
    with pytest.raises(ValueError, match="once each"):
        readme.fill("no markers", book)
    filled = readme.fill(f"a {readme.BEGIN} old {readme.END} b", book)
    assert filled.startswith(f"a {readme.BEGIN}\n\n![")
    assert filled.endswith(f"{readme.END} b")
    assert readme.fill(filled, book) == filled


def test_the_readme_names_the_best_baseline(files: dict[str, TaskFile]) -> None:
    book = Book.of([*records([4.0] * 10), *lcer([1.0] * 10)], files)
    row = line_of(readme.block(book), "| FlatWorld Cycle |")
    assert "[1.00 ± 0.00](docs/results/all.md#r-" in row
    assert "LCER" in row


def test_sample_efficiency_is_over_the_tasks_that_all_methods_share(
    files: dict[str, TaskFile],
) -> None:
    steps = {"steps": 3000}
    found = [*records([4.0] * 3, curve=[[0.0] * 3, [2.0] * 3, [4.0] * 3], **steps)]
    found += lcer([1.0] * 3, curve=[[0.0] * 3, [1.0] * 3, [1.0] * 3], **steps)
    found += records([4.0], name="carlo", overrides={}, curve=[[4.0], [4.0]], **steps)
    book = Book.of(found, files)
    assert efficiency.shared_tasks(book) == ["flatworld_cycle"]
    drawn = efficiency.files(book)[efficiency.PATH]
    assert "Visits over training, 1 task" in drawn
    whole, other = re.findall(r'class="line c\d" d="M([^"]*L[^"]*)"', drawn)
    heights = [float(point.split(",")[1]) for point in whole.split("L")]
    assert heights[0] == 256  # nothing at first: the evaluation after a third of the steps
    assert heights[-1] == 52  # all of the optimum, which is 1
    assert float(other.split(",")[-1]) == 205  # a quarter of it
    assert len(heights) == 14  # at 35, 40, … 100 hundredths of the steps
    assert efficiency.files(Book.of([], files)) == {}


def test_the_command_writes_what_there_is_and_prints_the_records_of_a_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "results").mkdir()
    append(tmp_path / "results" / "flatworld_cycle.jsonl.gz", records([2.0, 4.0]))
    shutil.copytree(ROOT / "specs", tmp_path / "specs")
    (tmp_path / "README.md").write_text(f"{readme.BEGIN}{readme.END}")
    monkeypatch.chdir(tmp_path)
    main([])
    assert "[3.00\u00a0±\u00a01.41](docs/results/all.md#" in Path("README.md").read_text()
    page = Path("docs/results/all.md").read_text()
    (anchor,) = re.findall(r'<a id="([^"]+)">', page)
    main(["row", anchor])
    assert [json.loads(line)["seed"] for line in capsys.readouterr().out.splitlines()] == [200, 201]
    for wrong in (["row", "r-0"], ["write"]):
        with pytest.raises(SystemExit, match=r"no row|usage"):
            main(wrong)


def test_tasks_weigh_the_same_in_their_mean() -> None:
    middle, interval = mean_of_tasks([np.zeros(1), np.ones(9)])
    assert (middle, interval.low, interval.high) == pytest.approx((0.5, 0.5, 0.5))


def verifications(found: list[Record], *chances: float, **changes: object) -> list[Record]:
    """What `verify` could have recorded of the runs: who is certain, and who is not at all."""
    made = []
    for record, chance in zip(found, chances, strict=True):
        agent = {"probability": chance, "fraction": f"{chance:g}", "agrees": chance != 0.5}
        about = {
            "method": "exact", "policy": "best", "verified": agent,
            "maximum": {"probability": 1.0, "fraction": "1", "exact": True, "how": "Storm"},
            "walked": {"confidence": 0.95, "episodes": 20, "steps": 400},
            "reason": None if chance == 1 else f"step {chance:g}: lost", **changes,
        }  # fmt: skip
        made.append(Record.of({**record.fields, **about}))
    return made


def test_what_was_verified_stands_beside_its_row(files: dict[str, TaskFile]) -> None:
    mine, other = records([4.0, 4.0, 4.0]), lcer([1.0, 2.0])
    checked = [*verifications(mine, 1.0, 1.0, 1.0), *verifications(other, 0.5, 0.0)]
    book = Book.of([*mine, *other], files, checked)
    page = verified.page(book)
    line = line_of(page, "| FlatWorld Cycle | 1 |")
    assert "[3 of 3](all.md#" in line
    assert "[0 of 2](all.md#" in line
    assert line.endswith(
        "<br><sub>mean 0.250</sub> | not run | not run | not run | not run | not run |"
    )
    assert "20 walks of 400 steps" in page
    assert "hold the exact probability for 4 of 5 agents." in page
    assert "They do not for FlatWorld Cycle LCER seed 200." in page
    assert "| FlatWorld Cycle | LCER | 200–201 | seed 201: step 0: lost |" in page


def test_what_was_verified_of_other_settings_is_not_shown(files: dict[str, TaskFile]) -> None:
    mine = records([4.0, 4.0])
    tried = records([4.0, 4.0], overrides={"beta": 0.2, "gamma": 0.8})
    book = Book.of([*mine, *tried], files, verifications(tried, 1.0, 1.0))
    assert "Nothing was verified yet." in verified.page(book)


def test_trials_are_pooled_and_named(files: dict[str, TaskFile]) -> None:
    mine = records([4.0, 4.0])
    trials = {"confidence": 0.95, "horizon": 50, "visits": 1}
    agents = [
        {"probability": p, "fine": round(p * 100), "episodes": 100, "low": p - 0.1, "high": p}
        for p in (1.0, 0.9)
    ]
    checked = [
        Record.of({**record.fields, "verified": agent})
        for record, agent in zip(
            verifications(mine, 1.0, 0.9, method="simulated", walked=None, trials=trials),
            agents,
            strict=True,
        )
    ]
    page = verified.page(Book.of(mine, files, checked)).replace("\u00a0", " ")
    assert "[0.9500](all.md#" in page
    assert "<sub>agents 0.800 to 1.000<br>≥ 1 in 50 steps</sub>" in page
    assert "| FlatWorld Cycle | TiLoIL | 201 | seed 201: step 0.9: lost |" in page

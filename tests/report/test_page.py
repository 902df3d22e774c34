"""The page says what the run folder says, needs nothing else, and trusts no text."""

import hashlib
import os
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.report.runs import plan, write_run
from tiloilc.plan import Predicate
from tiloilc.report import read_run, render, write_report
from tiloilc.report.page.facts import labels, verdict
from tiloilc.spec import Demonstrations, read_spec

VOID = {"br", "img", "link", "meta"}


class Outline(HTMLParser):
    """Checks that elements nest; gathers texts by element, and what is asked of the network."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: dict[str, list[str]] = {}
        self.asked: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("src", "href", "data", "action") and not (value or "").startswith("data:"):
                self.asked.append(f"{tag} {name}={value}")
            assert not name.startswith("on"), f"{tag} has {name}"
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data)


def outline(page: str) -> Outline:
    parsed = Outline()
    parsed.feed(page)
    parsed.close()
    assert parsed.open == []
    return parsed


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("runs") / "a1")


@pytest.fixture(scope="module")
def page(folder: Path) -> str:
    return render([read_run(folder)])


def test_the_page_has_every_section_in_order(page: str) -> None:
    heads = outline(page).texts["h2"]
    assert heads == [
        "Results", "Learning curves", "Automaton", "Stage occupancy", "Trajectories", "Settings",
        "Provenance", "How to read this page",
    ]  # fmt: skip


def test_the_page_asks_nothing_of_the_network(page: str) -> None:
    assert outline(page).asked == []
    assert not re.search(r"url\(|@import|//[a-z]+\.[a-z]+/(?!.*xmlns)", page.split("<main>")[0])
    assert "default-src &#x27;none&#x27;" in page


def test_the_only_script_is_ours_and_its_hash_is_allowed(page: str) -> None:
    import base64

    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    assert len(scripts) == 1
    digest = base64.b64encode(hashlib.sha256(scripts[0].encode()).digest()).decode()
    assert f"&#x27;sha256-{digest}&#x27;" in page


def test_the_same_folder_gives_the_same_bytes_under_another_hash_seed(
    folder: Path, page: str
) -> None:
    code = (
        "import sys, pathlib; from tiloilc.report import read_run, render;"
        "sys.stdout.buffer.write(render([read_run(pathlib.Path(sys.argv[1]))]).encode())"
    )
    for seed in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", code, str(folder)],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            timeout=120,
            check=True,
        )
        assert done.stdout == page.encode()


def test_a_run_folder_that_was_moved_gives_the_same_page(
    folder: Path, page: str, tmp_path: Path
) -> None:
    import shutil

    shutil.copytree(folder, tmp_path / "elsewhere" / folder.name)
    assert render([read_run(tmp_path / "elsewhere" / folder.name)]) == page
    assert str(folder.parent) not in page


def test_the_verdict_has_result_interval_optimum_and_cloning(folder: Path, page: str) -> None:
    said = verdict(read_run(folder))
    number = r"\d\.\d\d"
    assert re.fullmatch(
        rf"makes {number} accepting visits per episode \(95\u00a0% interval {number}–{number}, "
        rf"10 seeds\): \d+\u00a0% of the best known \(4\); cloning alone makes {number}\. "
        r"It violates the formula in [\d.]+\u00a0% of episodes\.",
        said,
    )
    assert f"TiLoIL {said}" in page


def test_a_lower_bound_of_the_optimum_is_not_called_the_optimum(tmp_path: Path) -> None:
    for exact, name, other in ((True, "optimum", "best known"), (False, "best known", "optimum")):
        best = {"accepting_visits": 4.0, "exact": exact, "how": "so it is"}
        page = render([read_run(write_run(tmp_path / name, optimum=best))])
        before, _, _ = page.partition("How to read this page")
        assert before.count(f"% of the {name}") == 3, "verdict, table and speed"
        assert f">{name} 4</text>" in before
        assert f"{name.capitalize()} 4: so it is." in before
        assert f"of the {other}" not in before


def test_seeds_without_any_spread_are_said_to_be_the_same(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a1", seeds=3, greedy={"accepting_visits": [3.0] * 3})
    said = verdict(read_run(run))
    assert said.startswith("makes 3.00 accepting visits per episode (the same on all 3 seeds)")


def test_numbers_in_the_table_are_those_of_the_evaluation(tmp_path: Path) -> None:
    values = {"accepting_visits": [2.0, 3.0, 3.0, 4.0], "violation_rate": [0.0, 0.1, 0.0, 0.1]}
    run = write_run(
        tmp_path / "a1", seeds=4, greedy=values, stochastic=None, last=None, cloning=None
    )
    cells = outline(render([read_run(run)])).texts["td"]
    assert "3.00 ± 0.82" in cells
    assert "5 ± 5.8 %" in cells
    assert any(cell.startswith("3.00 [") for cell in cells)


def test_a_run_that_was_not_cloned_has_no_cloning_to_be_compared_with(tmp_path: Path) -> None:
    train = plan().train.override({"learning_starts": 5_000})
    compiled = plan(train=train)
    assert compiled.train.warm_start != "none"
    for i, how in enumerate(({"cloning": None}, {"reached": 30_000})):
        found = read_run(write_run(tmp_path / f"a{i}", compiled=compiled, **how))
        assert 5_000 in found.curve.steps
        assert ("cloning alone" in render([found])) == ("reached" in how)
    bare = replace(compiled, demonstrations=Demonstrations())
    found = read_run(write_run(tmp_path / "b", compiled=bare, reached=30_000))
    assert "cloning alone" not in render([found])


def test_text_from_a_task_file_is_never_markup(tmp_path: Path) -> None:
    evil = '<script>alert(1)</script><img src=x onerror="alert(2)">'
    compiled = plan(
        name=evil, description=evil, formula=evil, predicates=(Predicate("p", evil),),
        version=evil, digests={"spec:<b>.yaml": evil},
    )  # fmt: skip
    run = write_run(
        tmp_path / "a1", compiled=compiled, name=evil, algorithm=evil, preset=evil,
        overrides={evil: evil}, versions={evil: evil}, machine={evil: evil}, git_commit=evil,
        optimum={"accepting_visits": 4, "exact": True, "how": evil},
    )  # fmt: skip
    page = render([read_run(run)])
    assert outline(page).asked == []
    assert page.count("<script") == 1
    assert "<img" not in page
    assert "&lt;script&gt;" in page


def test_commands_of_a_run_say_the_demonstrations_that_its_task_file_does_not(
    tmp_path: Path,
) -> None:
    text = (ROOT / "specs" / "flatworld_cycle.yaml").read_text(encoding="utf-8")
    (tmp_path / "flatworld_cycle.yaml").write_text(text, encoding="utf-8")
    own = read_spec(tmp_path / "flatworld_cycle.yaml").spec.demonstrations
    assert own is not None
    given = [own, Demonstrations(file="my demos.npz", count=own.count, actions=own.actions)]
    commands = []
    for name, shown in zip("ab", given, strict=True):
        compiled = replace(plan(), demonstrations=shown, root="..")
        page = outline(render([read_run(write_run(tmp_path / name, compiled=compiled))]))
        commands.append("".join(page.texts["code"]))
    assert "tiloilc compile flatworld_cycle.yaml" in commands[0]
    assert "demonstrations." not in commands[0].partition("git checkout")[2]
    assert "tiloilc compile" not in commands[1]
    assert (
        "tiloilc run flatworld_cycle.yaml --steps 60000 --set 'demonstrations.file=my demos.npz'"
        " --set demonstrations.max_visits=null" in commands[1]
    )


def test_commands_of_a_run_quote_what_a_shell_would_read(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a1", overrides={"beta": "$(touch x)"})
    page = outline(render([read_run(run)]))
    commands = "".join(page.texts["code"])
    assert "--steps 60000 --set 'beta=$(touch x)'" in commands
    assert "tiloilc compile flatworld_cycle.yaml" in commands
    assert "git checkout 1c580e2" in commands


def test_a_checkout_names_the_commit_and_what_it_lacked(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a1", git_commit="1c580e2-dirty")
    commands = "".join(outline(render([read_run(run)])).texts["code"])
    assert "git checkout 1c580e2  # and what was not committed then" in commands


def test_a_run_cut_short_says_so_first(tmp_path: Path) -> None:
    page = render([read_run(write_run(tmp_path / "a1", reached=31_000))])
    warning = page.index("This run was cut short at step 30,000 of 60,000")
    assert warning < page.index("<h2>")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("plan.json", "The automaton is not known: plan.json is missing."),
        ("events.jsonl", "The event log has no stage histogram"),
        ("eval.json", "From the last evaluation during training; eval.json is missing."),
        ("trajectories.npz", "There is no trajectories.npz"),
    ],
)
def test_a_section_without_its_file_says_what_is_missing(
    tmp_path: Path, name: str, said: str
) -> None:
    run = write_run(tmp_path / "a1")
    (run / name).unlink()
    page = render([read_run(run)])
    outline(page)
    assert said in page


def test_a_run_that_has_only_begun_is_still_a_page(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a1", reached=0)
    log = run / "events.jsonl"
    log.write_text(log.read_text().partition("\n")[0] + "\n")
    page = render([read_run(run)])
    assert "has not been evaluated yet" in page
    assert "There was no evaluation during training." in page


def test_trajectories_lie_over_the_map_of_the_task(page: str) -> None:
    scenes = re.findall(r'<svg class="scene".*?</svg>', page, re.DOTALL)
    assert len(scenes) == 10
    for scene in scenes:
        assert scene.count('class="zone"') == 4
        assert "<polyline" in scene


def test_each_visit_is_marked_once_on_the_map(folder: Path, page: str) -> None:
    run = read_run(folder)
    assert run.trajectories is not None
    arrivals = (run.trajectories.states[:, 1:] == 3) & (run.trajectories.states[:, :-1] != 3)
    assert arrivals.sum() > 10
    assert page.count('class="goal"') == arrivals.sum()


def test_episodes_that_ended_early_are_drawn_up_to_their_end(tmp_path: Path) -> None:
    import numpy as np

    run = write_run(tmp_path / "a1", seeds=1)
    observations = np.full((1, 51, 2), np.nan, np.float32)
    observations[0, :4] = [[-1, -1], [-0.6, -1], [-0.2, -1], [0.2, -1]]
    states = np.full((1, 51), -1)
    states[0, :4] = 0
    np.savez(run / "trajectories.npz", observations=observations, states=states)
    page = render([read_run(run)])
    assert "nan" not in page[page.index("<h2>Trajectories") : page.index("<h2>Settings")]


def test_an_environment_that_is_not_installed_leaves_the_map_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tiloilc.spec.model import Environment

    compiled = plan(environment=Environment(id="nowhere:Nothing-v0", horizon=50))
    run = read_run(write_run(tmp_path / "a1", compiled=compiled))
    assert ">pos[1]</text>" in render([run]), "two numbers are a plane without it"
    monkeypatch.setattr("tiloilc.report.page.figures.plane_of", lambda *about: None)
    page = render([run])
    assert "publishes no two-dimensional map" in page
    assert 'class="chart timeline"' in page


def test_runs_side_by_side_share_one_table_and_one_chart(tmp_path: Path) -> None:
    folders = [
        write_run(tmp_path / "a"),
        write_run(tmp_path / "b", random=7, overrides={"beta": "0"}),
        write_run(tmp_path / "c", random=8, algorithm="cloning"),
    ]
    runs = [read_run(folder) for folder in folders]
    assert labels(runs) == ["TiLoIL", "TiLoIL · beta=0", "Behaviour cloning"]
    page = render(runs)
    parsed = outline(page)
    assert page.count('class="results comparison"') == 1
    assert parsed.texts["h2"].count("Automaton") == 1
    chart = page[page.index("Accepting visits over training") :]
    chart = chart[: chart.index("</svg>")]
    assert [f'class="series run-{i} crowded"' in chart for i in range(3)] == [True] * 3
    assert "<code>beta</code>" in page


def test_equal_runs_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    runs = [read_run(write_run(tmp_path / name)) for name in ("a", "b")]
    assert labels(runs) == ["TiLoIL (a)", "TiLoIL (b)"]


def test_runs_of_two_tasks_get_a_chart_each(tmp_path: Path) -> None:
    other = write_run(tmp_path / "b", name="grid_circular_hard")
    page = render([read_run(write_run(tmp_path / "a")), read_run(other)])
    heads = outline(page).texts["h3"]
    assert heads[:2] == ["flatworld_cycle", "grid_circular_hard"]


def test_one_seed_is_drawn_without_an_interval(tmp_path: Path) -> None:
    page = render([read_run(write_run(tmp_path / "a", seeds=1))])
    assert 'class="band"' not in page
    assert "1 seed)" in page


def test_the_page_is_written_in_one_step(folder: Path, page: str, tmp_path: Path) -> None:
    out = write_report([folder], tmp_path / "new" / "report.html")
    assert out.read_text(encoding="utf-8") == page
    assert [file.name for file in out.parent.iterdir()] == ["report.html"]

"""Several runs on one page: their names, how they differ, and what each was found to be worth."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.report.runs import plan, write_run
from tests.report.test_page import outline
from tiloilc.diag import CompileError
from tiloilc.report import read_run, render
from tiloilc.report.page.automata import passes
from tiloilc.report.page.facts import labels
from tiloilc.report.page.verified import shown
from tiloilc.report.runs.reading import MOST_FILM

VERIFIED: dict[str, Any] = {
    "method": "simulated", "policy": "best", "why_not_exact": "it has <infinitely> many states",
    "agents": [{"seed": 0, "probability": 0.96, "low": 0.9, "high": 0.99, "episodes": 1000}],
    "simulated": {
        "confidence": 0.95, "horizon": 50, "visits": 2,
        "pooled": {"probability": 0.97, "low": 0.95, "high": 0.98, "episodes": 3000},
    },
    "maximum": {"probability": 1.0, "exact": False, "how": "a lattice"},
    "counterexamples": [
        {"seed": 0, "reason": "It touches `b & c`.", "way": ["r at step 3"], "probability": None}
    ],
}  # fmt: skip


def section(page: str, head: str) -> str:
    """The section that begins with a head."""
    begin = page.index(f"<section><h2>{head}")
    return page[begin : page.index("</section>", begin) + len("</section>")]


def write_states(run: Path, episodes: list[list[int]]) -> None:
    """Trajectories of these automaton states, an episode a seed."""
    states = np.array(episodes)
    observations = np.zeros((*states.shape, 2), np.float32)
    np.savez(run / "trajectories.npz", observations=observations, states=states)


def test_what_all_runs_override_alike_is_in_no_name(tmp_path: Path) -> None:
    shared = {"gamma": "0.8", "first_seed": "200"}
    runs = [
        read_run(write_run(tmp_path / "a", overrides=shared)),
        read_run(write_run(tmp_path / "b", overrides={**shared, "segment": "false"})),
        read_run(
            write_run(tmp_path / "c", algorithm="lcer", overrides={**shared, "algorithm": "lcer"})
        ),
    ]
    assert labels(runs) == ["TiLoIL", "TiLoIL · segment=false", "LCER"]


def test_other_demonstrations_of_a_task_are_in_the_name_and_among_the_differences(
    tmp_path: Path,
) -> None:
    usual = plan()
    few = replace(usual, demonstrations=usual.demonstrations.model_copy(update={"count": 2}))
    folders = [write_run(tmp_path / "a"), write_run(tmp_path / "b", compiled=few)]
    other = replace(few, name="another")
    folders.append(write_run(tmp_path / "c", compiled=other, name="another"))
    runs = [read_run(folder) for folder in folders]
    count = [f"flatworld_cycle · demonstrations.count={n}" for n in (5, 2)]
    assert labels(runs) == [*count, "another"]  # which has no other of its task
    page = render(runs[:2])
    row = re.search(r"<tr><th[^>]*><code>demonstrations.count</code></th>(.*?)</tr>", page)
    assert row is not None
    assert re.findall(r"<code>(\w+)</code>", row[1]) == ["5", "2"]
    assert "All runs have the same settings." not in page


def test_each_run_stands_beside_the_first_of_its_task(tmp_path: Path) -> None:
    def run(name: str, visits: list[float], **changes: Any) -> Path:
        greedy = {"accepting_visits": visits}
        return write_run(tmp_path / name, seeds=4, greedy=greedy, **changes)

    folders = [run("a", [1.0] * 4), run("b", [3.0] * 4, overrides={"beta": 0})]
    page = render([read_run(folder) for folder in folders])
    cells = outline(section(page, "Comparison")).texts["td"]
    assert "the first of its task" in cells
    assert "+2.00 [+2.00, +2.00]" in cells
    assert "1.00 [1.00, 1.00]" in cells


def test_a_run_that_was_not_evaluated_is_beside_nothing(tmp_path: Path) -> None:
    begun = write_run(tmp_path / "b", reached=0)
    log = begun / "events.jsonl"
    log.write_text(log.read_text().partition("\n")[0] + "\n")
    page = render([read_run(write_run(tmp_path / "a")), read_run(begun)])
    assert section(page, "Comparison").count("not evaluated") == 2


def test_settings_that_differ_are_written_in_one_way(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / "a"), write_run(tmp_path / "b", overrides={"stages": False})]
    page = render([read_run(run) for run in runs])
    row = re.search(r"<tr><th[^>]*><code>stages</code></th>(.*?)</tr>", page)
    assert row is not None
    assert re.findall(r"<code>(\w+)</code>", row[1]) == ["yes", "no"]


def test_occupancy_of_runs_of_one_automaton_is_side_by_side(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / "a"), write_run(tmp_path / "b", overrides={"beta": 0})]
    page = render([read_run(run) for run in runs])
    heads = outline(page).texts["h2"]
    assert [head for head in heads if "occupancy" in head.lower()] == ["Stage occupancy"]
    occupancy = section(page, "Stage occupancy")
    assert occupancy.count('<svg class="chart"') == 2
    assert occupancy.count('class="legend"') == 1


def test_runs_of_two_automata_are_two_groups(tmp_path: Path) -> None:
    from dataclasses import replace

    made = plan()
    other = plan(ldba=replace(made.ldba, names=("x", *made.ldba.names[1:])))
    runs = [write_run(tmp_path / "a"), write_run(tmp_path / "b", compiled=other, algorithm="lcer")]
    heads = outline(render([read_run(run) for run in runs])).texts["h2"]
    assert [h for h in heads if h.startswith("Automaton")] == [
        "Automaton · TiLoIL", "Automaton · LCER"
    ]  # fmt: skip


def test_each_run_alone_is_folded_up_with_its_own_parts(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / "a"), write_run(tmp_path / "b", overrides={"beta": 0})]
    page = render([read_run(run) for run in runs])
    alone = section(page, "Run by run")
    assert alone.count('<details class="run">') == 2
    assert outline(alone).texts["h3"] == [
        "Automaton", "Stage occupancy", "Trajectories"
    ] * 2  # fmt: skip


def test_passes_are_counted_along_episodes_and_end_with_them(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a", seeds=2)
    write_states(run, [[0, 0, 1, 2], [0, 1, -1, -1]])
    found = passes(read_run(run))
    assert found is not None
    assert {(b, c): v for (b, c), v in np.ndenumerate(found) if v} == {
        (0, 0): 0.5, (0, 1): 1.0, (1, 2): 0.5
    }  # fmt: skip


def test_the_automaton_is_drawn_with_its_counts(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a", seeds=2)
    write_states(run, [[0, 0, 1, 2, 3, 4], [0, 1, 1, 1, 1, 1]])
    drawn = section(render([read_run(run)]), "Automaton")
    state = re.search(r'<g data-state="1">.*?</g>', drawn, re.DOTALL)
    loop = re.search(r'<g data-loop="1">.*?</g>', drawn, re.DOTALL)
    lost = re.search(r'<g data-lost="3">.*?</g>', drawn, re.DOTALL)
    assert state is not None
    assert ">×3<" in state[0]  # two arrivals, and four steps in it, of two episodes
    assert loop is not None
    assert ">×2<" in loop[0]
    assert lost is not None
    assert ">×0.5<" in lost[0]
    (edge,) = re.findall(
        r"<title>from 0 to 1 on\n[^<]*</title>\n<rect[^>]*>\n(.*?)</g>", drawn, re.S
    )
    assert ">×1<" in edge


def test_trajectories_of_another_automaton_are_not_counted(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a", seeds=1)
    write_states(run, [[0, 7]])
    assert passes(read_run(run)) is None
    page = render([read_run(run)])
    assert "no trajectories.npz of this automaton" in page
    assert 'class="areas"' in page, "the log is of this one"


def test_what_verification_found_is_told(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a")
    assert "Verification" not in render([read_run(run)])
    (run / "verify.json").write_text(json.dumps(VERIFIED))
    page = render([read_run(run)])
    told = section(page, "Verification")
    assert "2 accepting visits or more in 50 steps, and no violation" in told
    assert "of the policy <code>best</code>" in told
    assert '<th scope="row">any of them</th><td class="num strong">0.97</td>' in told
    assert "0.9 and 0.99" in told
    assert "between [95 %]" in told
    assert "It is not exact: it has &lt;infinitely&gt; many states." in told
    assert "The most that a policy can reach is at least 1: a lattice." in told
    assert "It touches <code>b &amp; c</code>." in told
    assert "<li>r at step 3</li>" in told


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"), (1.0, "1"), (0.25, "0.25"), (0.99994, "0.9999"),
        (2e-6, "2e-06"), (1 - 2e-6, "1 - 2e-06"), (None, "–"),
    ],
)  # fmt: skip
def test_what_is_nearly_certain_or_impossible_is_not_shown_as_that(
    value: float | None, text: str
) -> None:
    assert shown(value) == text


def test_an_exact_verification_has_no_bounds(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a")
    agents = [{"seed": 0, "probability": 1 / 3}, {"seed": 1, "probability": 0.5, "at_least": True}]
    exact = {"method": "exact", "agents": agents}
    (run / "verify.json").write_text(json.dumps(exact))
    told = section(render([read_run(run)]), "Verification")
    assert "computed exactly" in told
    assert ">0.3333<" in told
    assert ">≥ 0.5<" in told
    assert "between" not in told


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{", "is no JSON"),
        ('{"agents": 3}', "`agents` of verify.json is no list"),
        ('{"agents": [{"seed": 0}]}', "an agent has no probability"),
        ('{"simulated": 3}', "`simulated` of verify.json is no object"),
        ('{"agents": [{"seed": 0.5, "probability": 1}]}', "no whole number"),
    ],
)
def test_a_damaged_verification_is_a_finding(tmp_path: Path, text: str, problem: str) -> None:
    run = write_run(tmp_path / "a")
    (run / "verify.json").write_text(text)
    with pytest.raises(CompileError, match=f"RUN701.*{problem}"):
        read_run(run)


def test_a_small_film_is_in_the_page_and_a_large_one_is_not(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a")
    (run / "video.gif").write_bytes(b"GIF89a")
    assert 'src="data:image/gif;base64,R0lGODlh"' in render([read_run(run)])
    (run / "video.gif").write_bytes(bytes(MOST_FILM + 1))
    assert "data:image/gif" not in render([read_run(run)])

"""Sweep files and options: what is asked for, and what is wrong with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sweep.made import TASK, asked, task
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.spec.settings import Settings
from tiloilc.sweep import Changes, check
from tiloilc.sweep.request import is_sweep


def wrong(folder: Path, text: str) -> list[Diagnostic]:
    """What is wrong with a sweep file, checked with its specs."""
    path = folder / "sweep.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CompileError) as caught:
        check(asked(path))
    return list(caught.value.diagnostics)


def sweep(folder: Path, text: str, **options: object) -> list[dict[str, object]]:
    """The settings of each variant of a sweep file."""
    path = folder / "sweep.yaml"
    path.write_text(text, encoding="utf-8")
    return [dict(variant.settings) for variant in asked(path, **options)[0].variants]


def marked(text: str, finding: Diagnostic) -> str:
    span = finding.span
    assert span is not None
    return text.splitlines()[span.line - 1][span.column - 1 : span.end_column - 1]


def test_specs_are_globs_relative_to_the_sweep_file(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    paths = [task(tmp_path / "in", name) for name in ("corridor_b", "corridor_a")]
    path = tmp_path / "sweep.yaml"
    path.write_text("specs: ['in/corridor_*.yaml', in/corridor_b.yaml]\n", encoding="utf-8")
    (request,) = asked(path)
    assert request.specs == tuple(sorted(paths))


def test_a_folders_name_is_no_pattern(tmp_path: Path) -> None:
    folder = tmp_path / "a[b]"
    folder.mkdir()
    spec, path = task(folder), folder / "sweep.yaml"
    path.write_text("specs: ['c*.yaml']\n", encoding="utf-8")
    assert asked(path)[0].specs == (spec,)


def test_algorithms_times_sets_times_grid(tmp_path: Path) -> None:
    task(tmp_path)
    found = sweep(
        tmp_path,
        "specs: [corridor.yaml]\nalgorithms: [tiloil, cloning]\nsteps: 1e3\n"
        "overrides: [{}, {gamma: 0.9, steps: 50}]\ngrid: {beta: [0, 1/3]}\n",
    )
    assert len(found) == 2 * 2 * 2
    assert found[0] == {"algorithm": "tiloil", "steps": 1000, "beta": 0.0}
    assert {"algorithm": "cloning", "steps": 50, "gamma": 0.9, "beta": 1 / 3} in found


def test_a_set_that_names_its_algorithm_is_run_with_that_alone(tmp_path: Path) -> None:
    task(tmp_path)
    text = "specs: [corridor.yaml]\nalgorithms: [tiloil]\noverrides: [{}, {algorithm: cloning}]\n"
    assert sweep(tmp_path, text) == [{"algorithm": "tiloil"}, {"algorithm": "cloning"}]


def test_options_take_the_place_of_what_the_file_says(tmp_path: Path) -> None:
    task(tmp_path)
    path = tmp_path / "sweep.yaml"
    text = "specs: [corridor.yaml]\nalgorithms: [tiloil]\nseeds: 5\nfirst_seed: 7\nrecords: kept\n"
    path.write_text(text, encoding="utf-8")
    (plain,) = asked(path)
    assert (plain.seeds, plain.first_seed) == (5, 7)
    assert plain.records == (tmp_path / "kept").as_posix()
    (other,) = asked(path, algorithms=("cloning",), settings={"beta": 0.0}, seeds=1, records="r")
    assert [dict(v.settings) for v in other.variants] == [{"algorithm": "cloning", "beta": 0.0}]
    assert (other.seeds, other.first_seed, other.records) == (1, 7, "r")


@pytest.mark.parametrize(
    ("text", "code", "piece", "words"),
    [
        ("specs: [corridor.yaml]\nalgorithm: [tiloil]\n", "SPEC101", "algorithm", "`algorithms`"),
        ("specs: [none_*.yaml]\n", "SPEC103", "none_*.yaml", "matches no file"),
        ("specs: [none.yaml]\n", "SPEC103", "none.yaml", "names no file"),
        ("specs: [corridor.yaml]\nseeds: 0\n", "SPEC103", "0", "greater than 0"),
        ("specs: [corridor.yaml]\noverrides: [{bta: 1}]\n", "SPEC101", "bta", "`beta`"),
        ("specs: [corridor.yaml]\noverrides: [{seeds: 1}]\n", "SPEC101", "seeds",
         "`seeds` is a key of the sweep file itself"),
        ("specs: [corridor.yaml]\noverrides: [{gamma: 2}]\n", "SPEC103", "2", "gamma"),
        ("specs: [corridor.yaml]\ngrid: {beta: [0, -1]}\n", "SPEC103", "-1", "grid.beta[1]"),
        ("specs: [corridor.yaml]\ngrid: {beta: 1}\n", "SPEC103", "1", "a list"),
        ("specs: [corridor.yaml]\ngrid: {bta: [1]}\n", "SPEC101", "bta", "`beta`"),
        ("specs: [corridor.yaml]\ngrid: {beta: [0.6]}\n", "PLAN404", "0.6", "1/2"),
        ("specs: [corridor.yaml]\nalgorithms: [tiloi]\n", "JOB610", "tiloi", "`tiloil`"),
        ("specs: [corridor.yaml]\noverrides: [{backbone: sac}]\n", "JOB608", "sac", "cannot learn"),
        ("specs: [corridor.yaml]\nspecs: [x.yaml]\n", "SPEC107", "specs", "duplicate"),
        ("seeds_per_job: 3\n", "SPEC102", "s", "specs"),
        ("specs: [corridor.yaml]\nrecords: 'x/{nam}.jsonl'\n", "SPEC103", "'x/{nam}.jsonl'",
         "`records` may have {name} and {algorithm}, and nothing else in braces"),
        ("specs: [corridor.yaml]\nrecords: 'y/{name}.txt'\n", "SPEC103", "'y/{name}.txt'",
         "`records` must end in .jsonl or .jsonl.gz where it has {name} or {algorithm}"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_with_its_place_and_what_was_meant(
    tmp_path: Path, text: str, code: str, piece: str, words: str
) -> None:
    task(tmp_path)
    finding = next(f for f in wrong(tmp_path, text) if f.code == code)
    assert marked(text, finding) == piece
    assert words in f"{finding.message} {finding.label} {finding.help}"


def test_a_pattern_that_yaml_swallows_is_to_be_quoted(tmp_path: Path) -> None:
    (finding,) = wrong(tmp_path, "specs: *.yaml\n")
    assert finding.code == "SPEC104"
    assert '"*.yaml"' in finding.help


def test_a_setting_in_a_set_and_in_the_grid_is_a_clash(tmp_path: Path) -> None:
    task(tmp_path)
    text = "specs: [corridor.yaml]\noverrides: [{beta: 0}]\ngrid: {beta: [0.1]}\n"
    (finding,) = wrong(tmp_path, text)
    assert finding.code == "SPEC108"
    assert "line 3" in finding.label


def test_a_sweep_file_without_specs_and_one_that_is_no_yaml_are_refused(tmp_path: Path) -> None:
    (finding,) = wrong(tmp_path, "specs:\n")
    assert finding.code == "SPEC103"
    (finding,) = wrong(tmp_path, "- a\n# as in\nspecs: x\n")
    assert finding.code == "SPEC100"


def test_what_is_strange_in_a_task_file_is_told_once_and_there(tmp_path: Path) -> None:
    train = "train: {steps: 400, beta: 0.3, sink_reward: 0}"
    path = task(tmp_path, train=train)
    _, found = check(asked(path, settings={"gamma": 0.9}))
    (finding,) = [finding for finding in found if finding.code == "JOB605"]
    assert marked(path.read_text(), finding) == "0"
    _, found = check(asked(path, settings={"sink_reward": -0.1}))
    assert [f.span is None for f in found if f.code == "JOB605"] == [False, True]


def test_faults_of_all_specs_and_settings_are_told_at_once(tmp_path: Path) -> None:
    task(tmp_path, "one", formula='formula: "F a & G !zz"')
    task(tmp_path, "two")
    text = "specs: ['*e.yaml', two.yaml]\ngrid: {beta: [0, 0.7]}\n"
    path = tmp_path / "sweep.yml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CompileError) as caught:
        check(asked(path))
    assert {"LTL203", "PLAN404"} <= {d.code for d in caught.value.diagnostics}


def test_a_task_file_is_not_taken_for_a_sweep() -> None:
    assert not is_sweep(TASK)
    assert is_sweep("specs: [a.yaml]\n")
    assert is_sweep("# my sweep\nalgorithms: [tiloil]\nspec: [a.yaml]\n")


def test_a_set_may_hold_every_setting_but_the_seeds() -> None:
    names = {name for name in Changes.model_fields if not name.startswith("demonstrations.")}
    assert names == set(Settings.model_fields) - {"seeds", "first_seed"}


def test_a_sweep_whose_seeds_count_up_too_far_is_told_where_it_says_so(tmp_path: Path) -> None:
    task(tmp_path, train="train: {steps: 400, seeds: 3, learning_starts: 20}")
    text = "specs: [corridor.yaml]\nfirst_seed: 2147483646\n"
    (finding,) = [d for d in wrong(tmp_path, text) if d.code == "JOB604"]
    assert marked(text, finding) == "2147483646"

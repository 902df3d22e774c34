"""Demonstrations as settings of a sweep: where they are given, what they make apart, and once."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.sweep.made import Feigned, asked, experiments, records_of, task
from tests.sweep.test_requests import marked, sweep, wrong
from tiloilc.demos import load
from tiloilc.diag import CompileError, Severity
from tiloilc.driver import compile_spec, load_plan
from tiloilc.evaluate import append, read
from tiloilc.plan import digest
from tiloilc.spec import Demonstrations
from tiloilc.spec.laid import DEMO_FIELDS
from tiloilc.sweep import (
    Changes,
    Experiment,
    Outcome,
    Same,
    Sweep,
    carry_out,
    check,
    jobs_of,
    recorded,
    table,
)
from tiloilc.sweep.request import of_file


def written(folder: Path, text: str) -> Path:
    path = folder / "sweep.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def shown(one: Experiment) -> Demonstrations:
    return one.plan.demonstrations


def some_file(folder: Path, name: str = "mine.npz", episodes: int = 2) -> Path:
    """Demonstrations of the corridor in a file."""
    from tiloilc.demos import DemoSet, save

    demos = compile_spec(task(folder)).demos
    save(folder / name, DemoSet(demos.episodes[:episodes], demos.meta))
    return folder / name


def test_counts_make_experiments_with_their_demonstrations(tmp_path: Path) -> None:
    task(tmp_path)
    path = written(tmp_path, "specs: [corridor.yaml]\ngrid: {demonstrations.count: [1, 3]}\n")
    found = experiments(path)
    assert [shown(one).count for one in found] == [1, 3]
    assert [len(one.task.demos) for one in found] == [1, 3]
    assert [one.words for one in found] == [
        "tiloil demonstrations.count=1",
        "tiloil demonstrations.count=3",
    ]
    assert all(shown(one).actions == "inferred" for one in found)  # as the task file says


def test_a_task_is_compiled_once_for_the_same_demonstrations(tmp_path: Path) -> None:
    task(tmp_path)
    found = experiments(
        written(
            tmp_path,
            "specs: [corridor.yaml]\nalgorithms: [tiloil, gail]\n"
            "grid: {demonstrations.count: [1, 3]}\n",
        )
    )
    assert len(found) == 4
    assert len({id(one.task) for one in found}) == 2


def test_a_count_that_the_task_file_says_itself_is_no_other_experiment(tmp_path: Path) -> None:
    task(tmp_path)
    text = "specs: [corridor.yaml]\noverrides: [{}, {demonstrations.count: 2}]\n"
    assert len(experiments(written(tmp_path, text))) == 1


def test_a_file_is_seen_from_the_sweep_file_and_told_from_the_task_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "specs").mkdir()
    (tmp_path / "sweeps").mkdir()
    spec = task(tmp_path / "specs")
    some_file(tmp_path)
    path = written(
        tmp_path / "sweeps",
        "specs: [../specs/corridor.yaml]\noverrides: [{demonstrations.file: ../mine.npz}]\n",
    )
    (one,) = experiments(path)
    assert (shown(one).file, shown(one).source) == ("../mine.npz", None)
    monkeypatch.chdir(tmp_path)
    (same,) = experiments(spec, settings={"demonstrations.file": "mine.npz"})
    assert digest(same.plan) == digest(one.plan)
    (again,) = experiments(Path("sweeps/sweep.yaml"))
    assert again.shown == {"demonstrations.file": "mine.npz"}  # as a command here takes it


def test_where_they_come_from_replaces_what_it_excludes(tmp_path: Path) -> None:
    file = some_file(tmp_path)
    text = "specs: [corridor.yaml]\noverrides: [{beta: 0, demonstrations.file: mine.npz}]\n"
    (taken,) = sweep(tmp_path, text, settings={"demonstrations.source": "expert"})
    assert taken == {"beta": 0.0, "demonstrations.source": "expert"}
    own = task(tmp_path, demonstrations=f"demonstrations: {{file: {file.name}, count: 2}}")
    (one,) = experiments(own, settings={"demonstrations.source": "expert"})
    assert (shown(one).file, shown(one).source, shown(one).count) == (None, "expert", 2)


def test_a_file_of_fewer_is_laid_over_a_task_that_says_no_number(tmp_path: Path) -> None:
    file = some_file(tmp_path)
    text = "specs: [corridor.yaml]\noverrides: [{demonstrations.file: mine.npz}]\n"
    task(tmp_path, demonstrations="demonstrations: {source: expert}")
    (one,) = experiments(written(tmp_path, text))
    assert (shown(one).file, len(one.task.demos)) == (file.name, 2)


def test_what_cuts_demonstrations_can_be_set_to_nothing(tmp_path: Path) -> None:
    path = task(tmp_path, demonstrations="demonstrations: {source: expert, max_steps: 2}")
    (one,) = experiments(path, settings={"demonstrations.max_steps": None})
    assert shown(one).max_steps is None
    assert max(len(demo.observations) for demo in one.task.demos.episodes) > 3
    (cut,) = experiments(path)
    assert max(len(demo.observations) for demo in cut.task.demos.episodes) == 3


@pytest.mark.parametrize(
    ("settings", "code", "piece", "words"),
    [
        ("overrides: [{demonstrations.cuont: 1}]", "SPEC101", "demonstrations.cuont",
         "`demonstrations.count`"),
        ("grid: {demonstration.count: [1]}", "SPEC101", "demonstration.count",
         "`demonstrations.count`"),
        ("overrides: [{demonstrations: {count: 1}}]", "SPEC101", "demonstrations", "not a key"),
        ("overrides: [{demonstrations.count: many}]", "SPEC103", "many", "a whole number"),
        ("grid: {demonstrations.max_steps: [1, 0]}", "SPEC103", "0",
         "grid.demonstrations.max_steps[1]"),
        ("overrides: [{demonstrations.file: }]", "SPEC103", "demonstrations.file", "is empty"),
        ("overrides: [{demonstrations.file: none.npz}]", "DEMO500", "none.npz", "none.npz"),
        ("overrides: [{demonstrations.count: 2}]\ngrid: {demonstrations.file: [none.npz]}",
         "DEMO500", "none.npz", "none.npz"),
        ("grid: {demonstrations.minari: [no/such-v0]}", "DEMO500", "no/such-v0", "no/such-v0"),
        ("overrides: [{demonstrations.actions: recorded, demonstrations.file: bare.npz}]",
         "DEMO505", "bare.npz", "actions"),
        ("overrides: [{demonstrations.count: 9, demonstrations.file: bare.npz}]",
         "DEMO511", "bare.npz", "not 9"),
        ("overrides: [{algorithm: gail, demonstrations.count: 0}]", "JOB604", "gail",
         "needs demonstrations"),
        ("overrides: [{demonstrations.file: a, demonstrations.minari: b}]", "SPEC108",
         "demonstrations.file", "`overrides[0].demonstrations.minari` exclude each other"),
        ("overrides: [{demonstrations.file: a}]\ngrid: {demonstrations.source: [expert]}",
         "SPEC108", "demonstrations.file", "line 3"),
        ("overrides: [{}, {}]\ngrid: {demonstrations.file: [a], demonstrations.source: [expert]}",
         "SPEC108", "demonstrations.source", "`grid.demonstrations.file`"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_with_its_place_in_the_sweep_file(
    tmp_path: Path, settings: str, code: str, piece: str, words: str
) -> None:
    from tiloilc.demos import save

    task(tmp_path)
    save(tmp_path / "bare.npz", compile_spec(tmp_path / "corridor.yaml").demos.without_actions())
    text = f"specs: [corridor.yaml]\n{settings}\n"
    (finding,) = (d for d in wrong(tmp_path, text) if d.severity is Severity.ERROR)
    assert finding.code == code
    assert finding.span is not None
    assert finding.span.file == (tmp_path / "sweep.yaml").as_posix()
    assert marked(text, finding) == piece
    assert words in f"{finding.message} {finding.label} {finding.help}"


def test_what_is_strange_about_demonstrations_is_told_at_the_setting_that_makes_it_so(
    tmp_path: Path,
) -> None:
    spec = task(tmp_path)
    text = "specs: [corridor.yaml]\ngrid: {demonstrations.max_steps: [null, 1]}\n"
    _, found = check([of_file(written(tmp_path, text), text)])
    (finding,) = [finding for finding in found if finding.code == "DEMO502"]
    assert marked(text, finding) == "1"
    _, found = check(asked(spec, settings={"demonstrations.max_steps": 1}))
    assert [f.span for f in found if f.code == "DEMO502"] == [None]


def test_a_task_without_demonstrations_must_be_told_where_they_come_from(tmp_path: Path) -> None:
    task(tmp_path, demonstrations="description: without")
    text = "specs: [corridor.yaml]\noverrides: [{demonstrations.count: 3}]\n"
    (finding,) = (d for d in wrong(tmp_path, text) if d.severity is Severity.ERROR)
    assert (finding.code, marked(text, finding)) == ("SPEC108", "3")
    assert "`demonstrations.source: expert`" in finding.help
    (one,) = experiments(tmp_path / "corridor.yaml", settings={"demonstrations.source": "expert"})
    assert len(one.task.demos) == 5


def test_a_missing_file_of_the_task_does_not_matter_where_another_takes_its_place(
    tmp_path: Path,
) -> None:
    path = task(tmp_path, demonstrations="demonstrations: {file: none.npz}")
    assert experiments(path, settings={"demonstrations.source": "expert"})
    with pytest.raises(CompileError):
        experiments(path)


@pytest.fixture
def counts(tmp_path: Path) -> Sweep:
    """A sweep of two seeds with one and with three demonstrations."""
    task(tmp_path)
    text = "specs: [corridor.yaml]\ngrid: {demonstrations.count: [1, 3]}\nrecords: results\n"
    found = experiments(written(tmp_path, text))
    return Sweep(found, jobs_of(found, [(), ()]), tmp_path / "runs")


def of_job(plan: Path) -> dict[str, object]:
    about = json.loads(plan.read_text(encoding="utf-8"))["demonstrations"]
    assert isinstance(about, dict)
    return about


def done(sweep: Sweep) -> Feigned:
    """Have all jobs done by a feigned engine."""
    outcomes = {}
    for job in sweep.jobs:
        one = sweep.experiments[job.number]
        named = shown(one).model_dump(mode="json", exclude_none=True)
        records = tuple(records_of(one, job.seeds, demonstrations=named))
        outcomes[job.id] = Outcome(job.id, records, "", (), 1.0)
    engine = Feigned(outcomes)
    assert carry_out(sweep, engine, lambda _: None) == {}
    return engine


def test_each_has_its_own_jobs_builds_records_and_rows(counts: Sweep) -> None:
    assert len({job.id for job in counts.jobs}) == 2
    done(counts)
    plans = list((counts.folder / "builds").glob("*/plan.json"))
    assert sorted(str(of_job(plan)["count"]) for plan in plans) == ["1", "3"]
    assert sorted(len(load(plan.parent / "demos.npz")) for plan in plans) == [1, 3]
    first, second = counts.experiments
    assert first.records == second.records
    assert len(read(first.records)) == 4
    have = recorded(counts.experiments, Same.PLAN, None)
    assert [sorted(found) for found in have] == [[0, 1], [0, 1]]
    assert not {*have[0].values()} & {*have[1].values()}
    assert jobs_of(counts.experiments, have) == []
    rows = table(counts.experiments, have).splitlines()[1:]
    assert ["demonstrations.count=1" in row for row in rows] == [True, False]
    for plan in plans:  # a job finds its build as it was compiled
        assert load_plan(plan.parent).demonstrations.count == of_job(plan)["count"]


def test_the_command_of_a_job_says_its_demonstrations(counts: Sweep) -> None:
    commands = [" ".join(counts.command(job)) for job in counts.jobs]
    assert sorted("--set demonstrations.count=3" in command for command in commands) == [
        False,
        True,
    ]
    assert all("demonstrations" not in job.changes for job in counts.jobs)
    (one,) = experiments(
        counts.experiments[0].spec, settings={"demonstrations.max_visits": None, "beta": 0.1}
    )
    (job,) = jobs_of([one], [()])
    command = Sweep([one], [job], counts.folder).command(job)
    assert "demonstrations.max_visits=null" in command


@pytest.mark.parametrize("same", list(Same))
def test_what_was_made_with_others_is_not_done(counts: Sweep, same: Same) -> None:
    first, second = counts.experiments
    named = shown(first).model_dump(mode="json", exclude_none=True)
    append(first.records, records_of(first, first.seeds, demonstrations=named))
    assert [len(found) for found in recorded([first, second], same, "abc")] == [2, 0]


def test_records_of_old_that_name_none_are_of_those_of_the_task_file(counts: Sweep) -> None:
    (own,) = experiments(counts.experiments[0].spec, records=str(counts.folder))
    append(own.records, records_of(own, own.seeds, plan_digest="of another version"))
    (given,) = experiments(
        own.spec, settings={"demonstrations.count": 3}, records=str(counts.folder)
    )
    assert [len(found) for found in recorded([own, given], Same.SPEC, None)] == [2, 0]


@pytest.mark.parametrize("named", [{"count": "x"}, {"count": 1, "unheard": 1}, [], "expert"])
def test_records_whose_demonstrations_are_not_understood_are_of_others(
    counts: Sweep, named: object
) -> None:
    first, _ = counts.experiments
    append(first.records, records_of(first, first.seeds, demonstrations=named))
    assert recorded([first], Same.SPEC, None) == [{}]


def test_a_set_may_hold_every_setting_of_demonstrations() -> None:
    names = {name for name in Changes.model_fields if name.startswith("demonstrations.")}
    assert names == set(DEMO_FIELDS)
    assert {name.partition(".")[2] for name in names} == set(Demonstrations.model_fields)

"""What comes in from an engine: recorded once, refused if it is not what was asked for."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sweep.made import Feigned, experiments, records_of, task
from tiloilc.diag import CompileError
from tiloilc.evaluate import append, read
from tiloilc.sweep import Event, Experiment, Job, Outcome, Sweep, carry_out, collect, jobs_of, table
from tiloilc.sweep.work import RECORDS


@pytest.fixture
def sweep(tmp_path: Path) -> Sweep:
    """Two jobs of two seeds."""
    found = experiments(task(tmp_path), seeds=4, seeds_per_job=2, records=str(tmp_path / "results"))
    return Sweep(found, jobs_of(found, [()]), tmp_path / "runs")


def unwatched(event: Event) -> None:
    """Whatever is told is of no interest."""


def outcome(one: Experiment, job: Job, **other: object) -> Outcome:
    return Outcome(job.id, tuple(records_of(one, job.seeds, **other)), "", (), 1.0)


def test_records_are_merged_as_they_come_in(sweep: Sweep) -> None:
    (one,) = sweep.experiments
    engine = Feigned({job.id: outcome(one, job) for job in sweep.jobs})
    counts = []
    assert carry_out(sweep, engine, lambda _: counts.append(one.records.exists())) == {}
    assert counts[0] is False
    assert [record.fields["seed"] for record in read(one.records)] == [0, 1, 2, 3]
    assert engine.asked == [job.id for job in sweep.jobs]


def test_a_job_that_fails_does_not_stop_the_others(sweep: Sweep) -> None:
    (one,) = sweep.experiments
    first, second = sweep.jobs
    bad = Outcome(first.id, (), "exit status 1", ("error: no",), 1.0)
    failed = carry_out(sweep, Feigned({first.id: bad, second.id: outcome(one, second)}), unwatched)
    assert failed == {first.id: bad}
    assert [record.fields["seed"] for record in read(one.records)] == list(second.seeds)


@pytest.mark.parametrize("other", [{"plan_digest": "0"}, {"seeds": [7, 8]}])
def test_records_of_something_else_are_a_failure(sweep: Sweep, other: dict[str, object]) -> None:
    (one,) = sweep.experiments
    engine = Feigned({job.id: outcome(one, job, **other) for job in sweep.jobs})
    failed = carry_out(sweep, engine, unwatched)
    assert set(failed) == {job.id for job in sweep.jobs}
    assert all("records are" in bad.problem for bad in failed.values())
    assert not one.records.exists()


def test_what_a_killed_sweep_left_behind_is_recorded(sweep: Sweep) -> None:
    (one,) = sweep.experiments
    job = sweep.jobs[1]
    sweep.job_folder(job).mkdir(parents=True)
    append(sweep.job_folder(job) / RECORDS, records_of(one, job.seeds))
    assert collect(sweep) == [sweep.jobs[0]]
    assert [record.fields["seed"] for record in read(one.records)] == list(job.seeds)
    assert collect(sweep) == [sweep.jobs[0]]  # once more changes nothing
    assert len(read(one.records)) == 2


def test_all_jobs_of_a_task_share_its_build(sweep: Sweep, tmp_path: Path) -> None:
    (other,) = experiments(task(tmp_path), settings={"beta": 0.2}, records=str(tmp_path / "other"))
    found = [*sweep.experiments, other]
    sweep = Sweep(found, jobs_of(found, [(), ()]), sweep.folder)
    engine = Feigned({job.id: outcome(found[job.number], job) for job in sweep.jobs})
    assert carry_out(sweep, engine, unwatched) == {}
    (build,) = (sweep.folder / "builds").iterdir()
    plan = (build / "plan.json").stat().st_mtime_ns
    carry_out(sweep, engine, unwatched)
    assert (build / "plan.json").stat().st_mtime_ns == plan


def test_a_damaged_record_file_stops_the_sweep(sweep: Sweep) -> None:
    (one,) = sweep.experiments
    one.records.parent.mkdir()
    one.records.write_bytes(b"no gzip")
    with pytest.raises(CompileError, match="RUN701"):
        carry_out(sweep, Feigned({job.id: outcome(one, job) for job in sweep.jobs}), unwatched)


def test_the_table_has_a_row_for_each_experiment(sweep: Sweep) -> None:
    (one,) = sweep.experiments
    records = {int(str(r.fields["seed"])): r for r in records_of(one, range(1, 4))}
    head, row = table([one], [records]).splitlines()
    assert head.split() == [
        "task", "settings", "steps", "seeds", "accepting", "visits", "violations", "optimum",
    ]  # fmt: skip
    assert " ".join(row.split()) == "corridor tiloil 400 3 of 4 2.00 ± 1.00 0.0% 5"
    assert table([one], [{}]).splitlines()[1].split()[-3:] == ["–", "–", "–"]

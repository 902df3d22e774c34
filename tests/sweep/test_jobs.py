"""Experiments to jobs: every seed that is not recorded is in one job, and in one only."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sweep.made import experiments, records_of, task
from tiloilc.evaluate import Record, append, read
from tiloilc.plan import digest
from tiloilc.sweep import Experiment, Same, jobs_of, merge, recorded
from tiloilc.sweep.experiments import record_file
from tiloilc.sweep.work import arguments


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    """An experiment of seeds 3 to 12, three in a job."""
    folder = tmp_path_factory.mktemp("jobs")
    (found,) = experiments(
        task(folder), seeds=10, first_seed=3, seeds_per_job=3, settings={"beta": 0.2},
        records=str(folder / "results"),
    )  # fmt: skip
    return found


@given(have=st.sets(st.integers(0, 15)))
def test_every_seed_that_is_missing_is_in_one_job(one: Experiment, have: set[int]) -> None:
    jobs = jobs_of([one], [have])
    seeds = [seed for job in jobs for seed in job.seeds]
    assert sorted(seeds) == [seed for seed in one.seeds if seed not in have]
    assert len({job.id for job in jobs}) == len(jobs)
    for job in jobs:  # parts begin where they began when nothing was recorded
        assert (job.seeds.start - 3) // 3 == (job.seeds.stop - 1 - 3) // 3


@given(done=st.sets(st.sampled_from([3, 6, 9, 12])))
def test_a_job_that_is_left_is_the_job_it_was(one: Experiment, done: set[int]) -> None:
    before = {job.id for job in jobs_of([one], [()])}
    have = {seed for start in done for seed in range(start, start + 3)}
    after = {job.id for job in jobs_of([one], [have])}
    assert after <= before
    assert len(before - after) == len(done)


def test_the_longest_job_comes_first(one: Experiment) -> None:
    sizes = [len(job.seeds) for job in jobs_of([one], [{3, 4, 7}])]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] == 3


def test_a_jobs_options_say_what_differs_from_the_task_file(one: Experiment) -> None:
    (job,) = jobs_of([one], [set(range(6, 13))])
    expected = ("--set", "beta=0.2", "--seeds", "3", "--set", "first_seed=3")
    assert arguments(job.changes) == expected


def test_the_same_experiment_asked_for_twice_is_one(tmp_path: Path) -> None:
    path = task(tmp_path)
    (tmp_path / "sweep.yaml").write_text(
        "specs: [corridor.yaml]\noverrides: [{}, {algorithm: tiloil}, {beta: 1/3}]\n"
    )
    assert len(experiments(tmp_path / "sweep.yaml")) == len(experiments(path)) == 1


def test_seeds_that_two_ask_for_are_trained_once(tmp_path: Path) -> None:
    path = task(tmp_path)
    first, second = (
        experiments(path, seeds=4, first_seed=first, records=str(tmp_path / "results"))[0]
        for first in (3, 5)
    )
    jobs = jobs_of([first, second], [{3}, ()])
    assert sorted((job.number, job.seeds) for job in jobs) == [(0, range(4, 7)), (1, range(7, 9))]
    (other,) = experiments(path, seeds=4, first_seed=5, records=str(tmp_path / "elsewhere"))
    jobs = jobs_of([first, other], [(), ()])
    assert sorted(len(job.seeds) for job in jobs) == [4, 4]


@given(
    parts=st.lists(st.tuples(st.integers(0, 14), st.integers(1, 6)), max_size=6),
    foreign=st.booleans(),
)
def test_a_seed_is_done_whichever_seeds_it_was_trained_with(
    one: Experiment, tmp_path_factory: pytest.TempPathFactory, parts: list[tuple[int, int]],
    foreign: bool,
) -> None:  # fmt: skip
    ranges = [range(start, start + size) for start, size in parts]
    records = [record for part in ranges for record in records_of(one, part)]
    if foreign:
        records += records_of(one, range(3, 13), plan_digest="0" * 64)
        records += records_of(one, range(3, 13), interrupted=True)
    one.records.unlink(missing_ok=True)
    append(one.records, records)
    (done,) = recorded([one], Same.PLAN, None)
    assert set(done) == {seed for part in ranges for seed in part} & set(one.seeds)
    for seed, record in done.items():
        assert record.fields["seed"] == seed


def test_what_counts_as_done_can_be_the_plan_the_spec_or_the_commit(one: Experiment) -> None:
    one.records.unlink(missing_ok=True)
    append(
        one.records,
        [
            *records_of(one, range(3, 5), commit="old"),
            *records_of(one, range(4, 6), commit="new"),
            *records_of(one, range(6, 8), commit="new", plan_digest="of another version"),
            *records_of(one, range(8, 9), overrides={"beta": 0.3}, plan_digest="changed"),
        ],
    )
    assert sorted(recorded([one], Same.PLAN, "new")[0]) == [3, 4, 5]
    assert sorted(recorded([one], Same.SPEC, "new")[0]) == [3, 4, 5, 6, 7]
    assert sorted(recorded([one], Same.COMMIT, "new")[0]) == [4, 5]
    for commit in ("new", "old"):
        assert recorded([one], Same.PLAN, commit)[0][4].fields["git_commit"] == commit


def test_of_two_commits_of_others_the_later_counts(one: Experiment) -> None:
    one.records.unlink(missing_ok=True)
    late = records_of(one, range(3, 4), commit="a", git_time=2)
    append(one.records, [*late, *records_of(one, range(3, 4), commit="b", git_time=1)])
    assert recorded([one], Same.PLAN, "c")[0] == {3: late[0]}


def test_where_a_seed_was_trained_is_not_part_of_its_spec(one: Experiment) -> None:
    one.records.unlink(missing_ok=True)
    elsewhere = {**one.settings.overrides(), "device": "cuda", "seeds": 1}
    append(one.records, records_of(one, range(3, 4), overrides=elsewhere, plan_digest="other"))
    assert sorted(recorded([one], Same.SPEC, None)[0]) == [3]
    assert not recorded([one], Same.PLAN, None)[0]


def test_cloning_is_done_however_many_steps_would_have_followed(tmp_path: Path) -> None:
    options = {"algorithms": ("cloning",), "records": str(tmp_path)}
    continuous = {
        "environment": "environment: {id: tiloilc/FlatWorld-v0, horizon: 8}",
        "  a": "  a: pos[0] > 0",
        "  z": "  z: pos[0] < -1",
    }
    (cloned,) = experiments(task(tmp_path, **continuous), **options)
    append(cloned.records, records_of(cloned, range(2), plan_digest="of another version"))
    assert sorted(recorded([cloned], Same.SPEC, None)[0]) == [0, 1]


def test_another_task_file_or_setting_is_not_done(tmp_path: Path, one: Experiment) -> None:
    one.records.unlink(missing_ok=True)
    append(one.records, records_of(one, one.seeds))
    same = {"seeds": 10, "first_seed": 3, "records": str(one.records.parent)}
    (known,) = experiments(task(tmp_path), settings={"beta": 0.2}, **same)
    (other,) = experiments(task(tmp_path), settings={"beta": 0.1}, **same)
    changed = task(tmp_path, evaluate="evaluate: {episodes: 3}")
    (later,) = experiments(changed, settings={"beta": 0.2}, **same)
    done = recorded([known, other, later], Same.PLAN, None)
    assert [len(records) for records in done] == [10, 0, 0]


@settings(max_examples=20)
@given(st.data())
def test_records_from_several_places_merge_to_the_same_file(
    one: Experiment, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Whatever lies where, however often, and in whatever order it is merged."""
    folder = tmp_path_factory.mktemp("merged")
    records = records_of(one, range(3, 9))
    places = [folder / "a.jsonl.gz", folder / "b" / "x.jsonl.gz", folder / "c.jsonl"]
    for record in records:
        for place in data.draw(st.lists(st.sampled_from(places), min_size=1, max_size=3)):
            append(place, [record])
    present = [p if p.parent == folder else p.parent for p in places if p.exists()]
    for name in ("one", "two"):
        for path in data.draw(st.permutations(present)):
            merge([path], str(folder / name))
    merge(present, str(folder / "one"))
    file = folder / "one" / "corridor.jsonl.gz"
    assert read(file) == sorted(records, key=lambda r: int(str(r.fields["seed"])))
    assert file.read_bytes() == (folder / "two" / "corridor.jsonl.gz").read_bytes()


def test_records_can_lie_in_a_file_each_task_or_each_algorithm() -> None:
    assert record_file("results", "t", "tiloil") == Path("results/t.jsonl.gz")
    assert record_file("r/{algorithm}/{name}.jsonl.gz", "t", "x") == Path("r/x/t.jsonl.gz")
    assert record_file("all.jsonl.gz", "t", "x") == Path("all.jsonl.gz")


def test_a_made_up_record_has_the_digest_of_its_plan(one: Experiment) -> None:
    record: Record = records_of(one, range(4, 6))[0]
    fields = json.loads(record.text)
    assert fields["plan_digest"] == digest(one.plan_of(range(4, 6)))
    assert fields["overrides"]["seeds"] == 2

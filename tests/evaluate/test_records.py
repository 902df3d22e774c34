"""Records survive merging, and say the same in the same bytes."""

import gzip
import json
import threading
from pathlib import Path
from typing import Any

import pytest

from tiloilc.diag import CompileError
from tiloilc.evaluate.records import (
    Record,
    append,
    dedupe,
    read,
    records_of_run,
    split_seeds,
    write,
)

EVALUATION: dict[str, Any] = {
    "schema_version": 1,
    "name": "flatworld_cycle",
    "plan_digest": "abc",
    "algorithm": "tiloil",
    "preset": "default",
    "overrides": {},
    "steps": 2000,
    "seeds": [4, 5],
    "episodes": 20,
    "gamma": 0.99,
    "greedy": {"accepting_visits": [3.0, 2.5], "first_visit": [11.0, None]},
    "stochastic": {"accepting_visits": [2.0, 1.5]},
    "last": {"accepting_visits": [2.5, 0.5]},
    "cloning": None,
    "optimum": {"accepting_visits": 4.0, "exact": True, "how": "by hand"},
    "curve": [{"step": 1000, "accepting_visits": [0.0, 1.0]}],
    "wall_seconds": 12.5,
    "machine": {"cpus": 2},
    "versions": {"torch": "2.13.0"},
    "git_commit": "1234567",
    "interrupted": False,
}


def records(**changes: Any) -> list[Record]:
    return split_seeds({**EVALUATION, **changes}, "spec")


def test_each_seed_gets_its_own_values_and_what_is_shared() -> None:
    first, second = (record.fields for record in records())
    assert (first["seed"], second["seed"]) == (4, 5)
    assert second["greedy"] == {"accepting_visits": 2.5, "first_visit": None}
    assert second["curve"] == [{"step": 1000, "accepting_visits": 1.0}]
    assert second["optimum"] == EVALUATION["optimum"]
    assert second["last"] == {"accepting_visits": 0.5}
    assert second["cloning"] is None
    assert second["spec_digest"] == "spec"
    assert "seeds" not in second


def test_a_list_of_another_length_is_no_list_over_seeds() -> None:
    with pytest.raises(ValueError, match=r"greedy\.accepting_visits. has 1 values for 2 seeds"):
        records(greedy={"accepting_visits": [1.0]})


def test_appending_twice_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "results" / "a.jsonl.gz"
    assert append(path, records()) == 2
    before = path.read_bytes()
    assert append(path, records()) == 2
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_the_bytes_do_not_depend_on_the_order_of_merging(tmp_path: Path) -> None:
    one, two = records(), records(seeds=[1, 2])
    append(tmp_path / "a.jsonl.gz", one)
    append(tmp_path / "a.jsonl.gz", two)
    append(tmp_path / "b.jsonl.gz", [*reversed(two), *one])
    assert (tmp_path / "a.jsonl.gz").read_bytes() == (tmp_path / "b.jsonl.gz").read_bytes()
    assert (tmp_path / "a.jsonl.gz").read_bytes()[4:8] == b"\0\0\0\0"  # no time in the header


def test_what_is_written_reads_back(tmp_path: Path) -> None:
    write(tmp_path / "a.jsonl.gz", records())
    write(tmp_path / "b.jsonl", records(seeds=[8, 9]))
    assert read(tmp_path / "a.jsonl.gz") == records()
    merged = read(tmp_path / "b.jsonl", tmp_path / "a.jsonl.gz")
    assert [record.fields["seed"] for record in merged] == [4, 5, 8, 9]


def test_a_finished_run_replaces_one_cut_short_in_either_order() -> None:
    cut, whole = records(interrupted=True, steps=5000), records()
    assert dedupe([*cut, *whole]) == dedupe([*whole, *cut]) == whole


def test_other_overrides_or_another_commit_are_other_experiments() -> None:
    several = [*records(), *records(overrides={"beta": 0}), *records(git_commit="7654321")]
    assert len(dedupe(several)) == 6


def test_appending_from_several_threads_loses_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl.gz"
    jobs = [
        threading.Thread(target=append, args=(path, records(seeds=[2 * i, 2 * i + 1])))
        for i in range(8)
    ]
    for job in jobs:
        job.start()
    for job in jobs:
        job.join()
    assert len(read(path)) == 16


def test_a_damaged_file_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl.gz"
    path.write_bytes(gzip.compress(records()[0].text.encode() + b"\n{oh\n"))
    with pytest.raises(CompileError, match=r"RUN701.*a\.jsonl\.gz.*line 2 is no record"):
        read(path)
    path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(CompileError, match=r"RUN701.*damaged"):
        append(path, records())
    path.write_bytes(gzip.compress(b"x" * 99, mtime=0)[:10] + b"rubbish")
    with pytest.raises(CompileError, match=r"RUN701.*damaged"):
        read(path)
    with pytest.raises(CompileError, match=r"RUN701.*no such file"):
        read(tmp_path / "none.jsonl")


def test_a_run_folder_gives_its_records_with_the_digest_of_its_spec(tmp_path: Path) -> None:
    (tmp_path / "eval.json").write_text(json.dumps(EVALUATION))
    with pytest.raises(CompileError, match=r"RUN701.*plan\.json"):
        records_of_run(tmp_path)
    (tmp_path / "plan.json").write_text(
        json.dumps({"digests": {"demos.npz": "a", "spec:t.yaml": "fed"}})
    )
    assert [record.fields["spec_digest"] for record in records_of_run(tmp_path)] == ["fed"] * 2


def test_not_a_number_is_never_recorded() -> None:
    with pytest.raises(ValueError, match="JSON compliant"):
        Record.of({"seed": 1, "value": float("nan")})

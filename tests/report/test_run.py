"""Run folders are read whole, in part with what is missing said, or not at all."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tests.report.runs import write_run
from tiloilc.diag import CompileError, Span
from tiloilc.report import read_run


def test_a_whole_run_is_read_with_nothing_to_note(tmp_path: Path) -> None:
    run = read_run(write_run(tmp_path / "a1"))
    assert (run.name, run.algorithm, run.seeds) == ("flatworld_cycle", "tiloil", tuple(range(10)))
    assert (run.end, run.total, run.interrupted, run.notes) == (60_000, 60_000, False, ())
    assert run.curve.steps == tuple(range(0, 60_001, 5_000))
    assert run.curve.values["accepting_visits"].shape == (13, 10)
    assert run.final is not None
    assert set(run.final.policies) == {"greedy", "stochastic", "last", "cloning"}
    assert run.trajectories is not None
    assert run.trajectories.states.shape == (10, 51)


def test_null_in_a_list_over_seeds_is_not_a_number(tmp_path: Path) -> None:
    run = read_run(write_run(tmp_path / "a1"))
    assert np.isnan(run.curve.values["first_visit"][0]).any()


def test_occupancy_is_the_share_of_all_seeds_steps(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "a1", seeds=2)
    start = {"type": "start", "step": 0, "name": "x", "seeds": [0, 1]}
    train = {"type": "train", "step": 10, "stage_histogram": [[3, 1], [5, 1]], "losses": {}}
    (folder / "events.jsonl").write_text(json.dumps(start) + "\n" + json.dumps(train) + "\n")
    (folder / "eval.json").unlink()
    occupancy = read_run(folder).occupancy
    assert occupancy is not None
    assert occupancy.steps == (10,)
    assert occupancy.shares.tolist() == [[0.8, 0.2]]


def test_a_run_without_its_end_was_cut_short(tmp_path: Path) -> None:
    run = read_run(write_run(tmp_path / "a1", reached=31_000))
    assert run.interrupted
    assert (run.end, run.total) == (30_000, 60_000)
    assert any("eval.json is missing" in note for note in run.notes)


def test_a_line_cut_off_by_a_kill_is_noted_and_the_rest_is_kept(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "a1", reached=31_000)
    with (folder / "events.jsonl").open("a") as log:
        log.write('{"type": "train", "st')
    run = read_run(folder)
    assert run.curve.steps[-1] == 30_000
    assert any("cut off" in note for note in run.notes)


def test_of_steps_logged_twice_the_last_counts(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "a1", reached=31_000)
    again = {"type": "eval", "step": 30_000, "greedy": {"accepting_visits": [1.0] * 10}}
    with (folder / "events.jsonl").open("a") as log:
        log.write(json.dumps(again) + "\n")
    curve = read_run(folder).curve
    assert curve.steps.count(30_000) == 1
    assert curve.values["accepting_visits"][-1].tolist() == [1.0] * 10


@pytest.mark.parametrize("name", ["plan.json", "events.jsonl", "eval.json", "trajectories.npz"])
def test_one_missing_file_is_noted_by_name(tmp_path: Path, name: str) -> None:
    folder = write_run(tmp_path / "a1")
    (folder / name).unlink()
    assert [note for note in read_run(folder).notes if name in note]


def test_without_a_log_the_curve_is_that_of_the_evaluation(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "a1")
    logged = read_run(folder).curve
    (folder / "events.jsonl").unlink()
    kept = read_run(folder).curve
    assert kept.steps == logged.steps
    assert np.array_equal(kept.values["success"], logged.values["success"])


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("eval.json", "{", r"eval\.json is no JSON: line 1, column 2"),
        ("eval.json", "[]", r"eval\.json is no object"),
        ("eval.json", '{"seeds": []}', r"names its seeds"),
        (
            "eval.json",
            '{"seeds": [0], "greedy": {"success": [1, 2]}}',
            r"greedy\.success.*1 number",
        ),
        ("eval.json", '{"seeds": [0], "greedy": {"success": ["x"]}}', r"greedy\.success"),
        ("events.jsonl", '{"type": "start"\n{"type": "end"}\n', r"events\.jsonl, line 1"),
        ("events.jsonl", '{"type": "end", "step": "x"}\n', r"`step`"),
        ("trajectories.npz", "PK", r"trajectories\.npz is damaged"),
        ("plan.json", "{}", r"plan"),
    ],
)
def test_a_damaged_file_is_an_error_that_names_it(
    tmp_path: Path, name: str, text: str, problem: str
) -> None:
    folder = write_run(tmp_path / "a1", seeds=1)
    (folder / name).write_text(text)
    with pytest.raises(CompileError, match=problem) as caught:
        read_run(folder)
    assert caught.value.diagnostics[0].code in ("RUN701", "PLAN407")


def test_a_damaged_plan_is_found_in_the_run_that_it_is_of(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "a1", seeds=1)
    plan = folder / "plan.json"
    plan.write_text('{"name": "x",\n "formula" "F a"}\n')
    with pytest.raises(CompileError, match="PLAN407") as caught:
        read_run(folder)
    assert caught.value.diagnostics[0].span == Span.at(plan.as_posix(), 2, 12)


def test_trajectories_of_other_shapes_or_with_pickles_are_refused(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "a1", seeds=2)
    file = folder / "trajectories.npz"
    np.savez(file, observations=np.zeros((2, 5, 2), np.float32), states=np.zeros((2, 4), int))
    with pytest.raises(CompileError, match=r"RUN701.*one episode for each of 2 seeds"):
        read_run(folder)
    np.savez(file, observations=np.zeros((2, 5, 2), np.float32))
    with pytest.raises(CompileError, match=r"RUN701.*states"):
        read_run(folder)
    np.savez(file, observations=np.array([{}], dtype=object), states=np.zeros((2, 4), int))
    with pytest.raises(CompileError, match=r"RUN701.*damaged"):
        read_run(folder)
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("observations.npy", b"\x93NUMPY")
    with pytest.raises(CompileError, match=r"RUN701.*damaged"):
        read_run(folder)


def test_what_is_no_run_folder_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(CompileError, match=r"RUN701.*no such folder"):
        read_run(tmp_path / "none")
    with pytest.raises(CompileError, match=r"RUN701.*neither events\.jsonl nor eval\.json"):
        read_run(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(CompileError, match=r"RUN701.*no folder"):
        read_run(tmp_path / "file")

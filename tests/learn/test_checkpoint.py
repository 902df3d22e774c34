"""Checkpoints: whole or not there, and never silently another one."""

import errno
import json
import os
from pathlib import Path

import pytest
import torch

from tiloilc.diag import CompileError
from tiloilc.learn.best import Best
from tiloilc.learn.checkpoint import load_checkpoint, replace_file, save_checkpoint
from tiloilc.learn.events import Events, last_events


def write(folder: Path, step: int, value: float = 0.0) -> None:
    state = {"x": torch.full((3,), float(step) + value), "view": torch.eye(4)[:, 1:3]}
    save_checkpoint(folder, state, step, 10 * step, "plan")


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    write(tmp_path, 7)
    state, pointer, problem = load_checkpoint(tmp_path, "plan")
    assert state["x"].tolist() == [7, 7, 7]
    assert torch.equal(state["view"], torch.eye(4)[:, 1:3])
    assert (pointer.step, pointer.events_bytes, problem) == (7, 70, None)


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (lambda f: (f / "0000000002.safetensors").write_bytes(b"x"), "is damaged"),
        (lambda f: (f / "0000000002.safetensors").unlink(), "0000000002.safetensors is missing"),
        (lambda f: (f / "last.json").unlink(), "last.json is missing"),
        (lambda f: (f / "last.json").write_text("{"), "line 1"),
        (lambda f: (f / "last.json").write_text("[1]"), "Pointer"),
        (lambda f: (f / "last.json").write_text('{"file": 3}'), "missing"),
    ],
)
def test_a_damaged_checkpoint_falls_back_to_the_one_before_and_says_so(
    tmp_path: Path, damage, problem: str
) -> None:
    write(tmp_path, 1)
    write(tmp_path, 2)
    damage(tmp_path)
    state, pointer, said = load_checkpoint(tmp_path, "plan")
    assert pointer.step == 1
    assert state["x"].tolist() == [1, 1, 1]
    assert problem in said


def test_without_a_whole_checkpoint_there_is_a_finding(tmp_path: Path) -> None:
    with pytest.raises(CompileError, match=r"RUN701"):
        load_checkpoint(tmp_path / "none", "plan")
    write(tmp_path, 1)
    (tmp_path / "0000000001.safetensors").write_bytes(b"")
    with pytest.raises(CompileError, match=r"RUN701.*damaged"):
        load_checkpoint(tmp_path, "plan")


def test_a_checkpoint_of_another_plan_is_refused(tmp_path: Path) -> None:
    write(tmp_path, 1)
    with pytest.raises(CompileError, match="RUN704"):
        load_checkpoint(tmp_path, "another plan")


def test_a_folder_that_cannot_be_made_is_a_finding(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(CompileError, match=r"RUN703"):
        write(tmp_path / "file" / "checkpoints", 1)


@pytest.mark.parametrize("place", ["fsync", "replace"])
def test_a_full_disk_is_a_finding_and_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    write(tmp_path, 1)
    write(tmp_path, 2)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def full(*arguments: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(*((os, "fsync") if place == "fsync" else (Path, "replace")), full)
        with pytest.raises(CompileError, match=r"RUN703.*no space left"):
            write(tmp_path, 3)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before  # no litter either
    assert load_checkpoint(tmp_path, "plan")[1].step == 2


@pytest.mark.parametrize("writes", range(4))
def test_a_crash_between_any_two_writes_leaves_a_whole_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writes: int
) -> None:
    write(tmp_path, 1)
    write(tmp_path, 2)
    done = []

    class Crash(BaseException):
        pass

    def counting(path: Path, data: bytes) -> None:
        if len(done) == writes:
            raise Crash
        done.append(path)
        replace_file(path, data)

    with monkeypatch.context() as patch:
        patch.setattr("tiloilc.learn.checkpoint.replace_file", counting)
        if writes < 3:
            with pytest.raises(Crash):
                write(tmp_path, 3)
        else:
            write(tmp_path, 3)
    assert len(done) == writes
    assert load_checkpoint(tmp_path, "plan")[1].step == (3 if writes == 3 else 2)
    write(tmp_path, 4)
    assert load_checkpoint(tmp_path, "plan")[1].step == 4


def test_saving_a_step_again_is_harmless(tmp_path: Path) -> None:
    write(tmp_path, 1)
    write(tmp_path, 2)
    write(tmp_path, 2, value=0.5)
    assert load_checkpoint(tmp_path, "plan")[0]["x"].tolist() == [2.5] * 3


def test_a_replaced_file_is_whole_or_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "file"
    replace_file(path, b"one")
    replace_file(path, b"two")
    assert path.read_bytes() == b"two"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


# events


def test_events_are_lines_of_json_and_can_be_cut(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    with Events(path) as events:
        events.write("start", 0, name="x")
        events.write("train", 5, visits=[1.0, None])
        size = events.size()
        events.write("train", 9)
    assert path.read_text().splitlines()[1] == '{"type":"train","step":5,"visits":[1.0,null]}'
    with Events(path, size) as events:
        assert events.size() == size
        events.write("end", 6)
    kinds = [json.loads(line)["type"] for line in path.read_text().splitlines()]
    assert kinds == ["start", "train", "end"]
    assert [e["step"] for e in last_events(path, "train")] == [5]


def test_a_new_log_replaces_an_old_one(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    path.write_text("old\n" * 100)
    with Events(path) as events:
        events.write("start", 0)
    assert path.read_text() == '{"type":"start","step":0}\n'


# best


def policy(*values: float) -> dict[str, torch.Tensor]:
    """Two seeds; one tensor with a row a seed, one with two rows a seed."""
    first = torch.tensor(values)[:, None]
    return {"actor": first, "critics": first.repeat_interleave(2, 0)}


def test_each_seed_keeps_its_own_best_policy() -> None:
    best = Best(2)
    best.offer(policy(1, 1), [3, 1], [0, 0])
    best.offer(policy(2, 2), [2, 2], [0, 0])
    assert best.policy["actor"][:, 0].tolist() == [1, 2]
    assert best.policy["critics"][:, 0].tolist() == [1, 1, 2, 2]


def test_fewer_violations_win_among_equal_visits_and_later_ones_among_equals() -> None:
    best = Best(2)
    best.offer(policy(1, 1), [3, 3], [0.5, 0.5])
    best.offer(policy(2, 2), [3, 3], [0.2, 0.8])
    best.offer(policy(3, 3), [3, 2], [0.2, 0.0])
    assert best.policy["actor"][:, 0].tolist() == [3, 1]


def test_the_best_policy_is_a_copy() -> None:
    best, live = Best(2), policy(1, 1)
    best.offer(live, [1, 1], [0, 0])
    live["actor"] += 5
    assert best.policy["actor"][:, 0].tolist() == [1, 1]


def test_the_best_go_on_from_their_state() -> None:
    first, second = Best(2), Best(2)
    first.offer(policy(1, 1), [3, 1], [0, 0])
    second.load(first.state())
    second.offer(policy(2, 2), [2, 2], [0, 0])
    assert second.policy["actor"][:, 0].tolist() == [1, 2]

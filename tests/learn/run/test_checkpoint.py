"""Checkpoints: whole or not there, and never silently another one."""

import errno
import json
import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import torch

from tiloilc.diag import CompileError
from tiloilc.learn.engine.ring import Ring
from tiloilc.learn.run.best import Best
from tiloilc.learn.run.checkpoint import Checkpoint, Checkpoints, load_checkpoint, replace_file
from tiloilc.learn.run.events import Events, last_events


class Run:
    """Two rings of different speeds, and a number; each `go` is some steps and a checkpoint."""

    def __init__(self, folder: Path, resumed: Checkpoint | None = None) -> None:
        self.folder = folder
        self.rows, self.written = torch.zeros(2, 8, 1), torch.zeros(2, dtype=torch.long)
        self.step = 0
        if resumed is not None:
            state = resumed.state()
            self.step, self.written = int(state["step"]), state["written"]
            resumed.restore(self.rings())
        self.checkpoints = Checkpoints(folder, "plan", resumed)

    def rings(self) -> dict[str, Ring]:
        return {"rows": Ring(self.rows, self.written)}

    def go(self, steps: int = 1) -> None:
        for _ in range(steps):
            self.step += 1
            for ring, speed in enumerate((1, 3)):
                for k in range(speed):
                    self.rows[ring, int(self.written[ring]) % 8] = 100 * self.step + k
                    self.written[ring] += 1
        view = torch.full((3, 4), float(self.step)).T[1:]
        state = {"step": torch.tensor(self.step), "written": self.written, "view": view}
        self.checkpoints.save(state, self.rings(), self.step, 0.5, 10 * self.step)
        self.checkpoints.wait()


def loaded(folder: Path) -> Checkpoint:
    found = load_checkpoint(folder, "plan")
    assert found is not None
    return found


def rows_of(checkpoint: Checkpoint) -> torch.Tensor:
    rings = {"rows": Ring(torch.zeros(2, 8, 1), torch.zeros(2, dtype=torch.long))}
    checkpoint.restore(rings)
    return rings["rows"].rows


def written(folder: Path, *steps: int) -> Run:
    run = Run(folder)
    for count in steps:
        run.go(count)
    return run


def pointer(folder: Path, name: str = "last") -> dict[str, object]:
    read = json.loads((folder / f"{name}.json").read_text())
    assert isinstance(read, dict)
    return read


def files(folder: Path, name: str = "last") -> list[str]:
    read = pointer(folder, name)
    return [file["name"] for file in [read["state"], *read["rows"]]]  # type: ignore[index, misc]


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    run = written(tmp_path, 7)
    found = loaded(tmp_path)
    assert torch.equal(found.state()["view"], torch.full((3, 3), 7.0))
    assert torch.equal(rows_of(found), run.rows)
    about = found.pointer
    assert (about.step, about.seconds, about.events_bytes, found.problem) == (7, 0.5, 70, None)


def test_where_nothing_was_written_there_is_no_checkpoint(tmp_path: Path) -> None:
    assert load_checkpoint(tmp_path, "plan") is None
    assert load_checkpoint(tmp_path / "none", "plan") is None


def test_training_may_go_on_while_a_checkpoint_is_written(tmp_path: Path) -> None:
    run, begin = written(tmp_path, 1), threading.Event()
    before = run.rows.clone()
    state = {"step": torch.tensor(1)}
    run.checkpoints.save(state, run.rings(), 2, 0.0, 0, sync=lambda: begin.wait() and None)
    run.checkpoints.check()  # nothing has gone wrong
    assert loaded(tmp_path).pointer.step == 1
    state["step"] += 1
    run.rows += 1
    run.written += 1
    begin.set()
    run.checkpoints.wait()
    assert loaded(tmp_path).pointer.step == 2
    assert int(loaded(tmp_path).state()["step"]) == 1
    assert torch.equal(rows_of(loaded(tmp_path)), before)


def test_what_goes_wrong_in_the_thread_is_raised_by_the_next_call(tmp_path: Path) -> None:
    run = written(tmp_path, 1)

    def full() -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    run.checkpoints.save({}, run.rings(), 2, 0.0, 0, sync=full)
    with pytest.raises(CompileError, match=r"RUN703.*no space left"):
        run.checkpoints.wait()
    run.checkpoints.check()  # it was said
    with pytest.raises(CompileError, match="RUN703"), run.checkpoints:
        run.checkpoints.save({}, run.rings(), 2, 0.0, 0, sync=full)


# rows


def test_only_new_rows_are_written(tmp_path: Path) -> None:
    run = written(tmp_path, 1)
    sizes = []
    for _ in range(4):
        run.go()
        newest = tmp_path / files(tmp_path)[-1]
        sizes.append(newest.stat().st_size)
    assert len(files(tmp_path)) == 4
    assert sizes[1:] == [sizes[1]] * 3  # two steps' rows each: there are two chains


def test_the_last_two_checkpoints_share_no_file(tmp_path: Path) -> None:
    run = Run(tmp_path)
    for _ in range(9):
        run.go()
        if run.step > 1:
            assert not set(files(tmp_path)) & set(files(tmp_path, "previous"))
            previous = {p.name for p in tmp_path.glob("*.safetensors")}
            assert previous == {*files(tmp_path), *files(tmp_path, "previous")}  # no other is kept


@pytest.mark.parametrize("resume", [False, True])
def test_rows_are_the_same_however_often_their_ring_went_round(
    tmp_path: Path, resume: bool
) -> None:
    run = Run(tmp_path)
    for steps in (1, 1, 2, 1, 9, 1, 3, 3, 1, 1, 1, 1, 1):
        run.go(steps)
        assert torch.equal(rows_of(loaded(tmp_path)), run.rows)
        if resume:
            expected, run = run, Run(tmp_path, loaded(tmp_path))
            assert torch.equal(run.rows, expected.rows)


def test_rows_that_were_overwritten_do_not_stay_for_ever(tmp_path: Path) -> None:
    run, most = Run(tmp_path), 0
    for _ in range(60):
        run.go()
        most = max(most, len(files(tmp_path)))
    assert 3 <= most <= 8  # two turns of the slow ring at most, two steps a file


def test_a_chain_is_not_continued_unless_it_was_read(tmp_path: Path) -> None:
    """After resuming nobody knows whether the checkpoint before the last is whole."""
    written(tmp_path, 1, 1, 1, 1)
    for name in files(tmp_path, "previous"):
        (tmp_path / name).write_bytes(b"damaged")
    run = Run(tmp_path, loaded(tmp_path))
    for _ in range(3):
        run.go()
        assert torch.equal(rows_of(loaded(tmp_path)), run.rows)


# damage


def damages() -> Iterator[Callable[[Path], None]]:
    def state(folder: Path) -> Path:
        return folder / files(folder)[0]

    def rows(folder: Path) -> Path:
        return folder / files(folder)[1]

    yield lambda f: state(f).write_bytes(b"x") and None
    yield lambda f: os.truncate(state(f), 40)
    yield lambda f: state(f).unlink()
    yield lambda f: rows(f).write_bytes(rows(f).read_bytes()[:-1] + b"x") and None
    yield lambda f: rows(f).unlink()
    yield lambda f: (f / "last.json").unlink()
    for text in ("", "{", "[1]", '{"step": 3}'):
        yield lambda f, text=text: (f / "last.json").write_text(text) and None  # type: ignore[misc]


@pytest.mark.parametrize("damage", list(damages()))
def test_a_damaged_checkpoint_falls_back_to_the_one_before_and_says_so(
    tmp_path: Path, damage: Callable[[Path], None]
) -> None:
    run = Run(tmp_path)
    for _ in range(4):
        run.go()
    expected = run.rows.clone()
    run.go()
    damage(tmp_path)
    found = loaded(tmp_path)
    assert found.pointer.step == int(found.state()["step"]) == 4
    assert torch.equal(rows_of(found), expected)
    assert found.problem is not None
    assert found.problem.endswith(("is damaged", "is missing"))
    again = Run(tmp_path, found)  # and goes on as if there had been no other
    again.go()
    assert loaded(tmp_path).problem is None
    assert torch.equal(rows_of(loaded(tmp_path)), run.rows)


def test_without_a_whole_checkpoint_there_is_a_finding(tmp_path: Path) -> None:
    written(tmp_path, 1, 1)
    for path in tmp_path.glob("*.safetensors"):
        path.write_bytes(b"")
    with pytest.raises(CompileError, match=r"RUN701.*damaged"):
        load_checkpoint(tmp_path, "plan")


def test_a_checkpoint_of_another_plan_is_refused(tmp_path: Path) -> None:
    written(tmp_path, 1)
    with pytest.raises(CompileError, match="RUN704"):
        load_checkpoint(tmp_path, "another plan")


def test_a_checkpoint_of_another_version_is_refused(tmp_path: Path) -> None:
    written(tmp_path, 1)
    pointer = json.loads((tmp_path / "last.json").read_text())
    for change in ({"schema_version": 1}, {"schema_version": 99, "more": 1}):
        (tmp_path / "last.json").write_text(json.dumps({**pointer, **change}))
        with pytest.raises(CompileError, match="RUN712"):
            load_checkpoint(tmp_path, "plan")
    del pointer["schema_version"]  # as the first version wrote it
    (tmp_path / "last.json").write_text(json.dumps(pointer))
    with pytest.raises(CompileError, match="RUN712"):
        load_checkpoint(tmp_path, "plan")


def test_a_folder_that_cannot_be_made_is_a_finding(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(CompileError, match=r"RUN703"):
        written(tmp_path / "file" / "checkpoints", 1)


@pytest.mark.parametrize("place", ["fsync", "replace"])
def test_a_full_disk_is_a_finding_and_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    run = written(tmp_path, 1, 1)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def full(*arguments: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(*((os, "fsync") if place == "fsync" else (Path, "replace")), full)
        with pytest.raises(CompileError, match=r"RUN703.*no space left"):
            run.go()
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before  # no litter either
    assert loaded(tmp_path).pointer.step == 2


@pytest.mark.parametrize("writes", range(5))
def test_a_crash_between_any_two_writes_leaves_a_whole_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writes: int
) -> None:
    run = written(tmp_path, 1, 1)
    done = []

    class Crash(BaseException):
        pass

    def counting(path: Path, data: bytes) -> None:
        if len(done) == writes:
            (path.parent / f".{path.name}.tmp").write_bytes(data[:9])  # what a killed writer leaves
            raise Crash
        done.append(path)
        replace_file(path, data)

    with monkeypatch.context() as patch:
        patch.setattr("tiloilc.learn.run.checkpoint.replace_file", counting)
        if writes < 4:
            with pytest.raises(Crash):
                run.go()
        else:
            run.go()
    assert len(done) == writes
    found = loaded(tmp_path)
    assert (found.pointer.step, found.problem) == (3 if writes == 4 else 2, None)
    again = Run(tmp_path, found)
    again.go(3)
    assert torch.equal(rows_of(loaded(tmp_path)), again.rows)
    assert not list(tmp_path.glob(".*"))


def test_saving_a_step_again_is_harmless(tmp_path: Path) -> None:
    run = written(tmp_path, 1, 1)
    run.go(0)
    assert loaded(tmp_path).pointer.step == 2
    assert torch.equal(rows_of(loaded(tmp_path)), run.rows)


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

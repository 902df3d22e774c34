"""Files are written in one step, and what fails is said of them, not of their temporary names."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tiloilc import report
from tiloilc.demos import Demo, DemoSet, save
from tiloilc.evaluate import records
from tiloilc.writing import write_file

WRITERS: dict[str, Callable[[Path], object]] = {
    "file": lambda path: write_file(path, "text"),
    "records": lambda path: records.write(path, []),
    "report": lambda path: report.write_report([], path),
    "demonstrations": lambda path: save(path, DemoSet((Demo(np.zeros((2, 1), np.float32)),))),
}


@pytest.fixture(params=WRITERS)
def write(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Callable[..., object]:
    monkeypatch.setattr(report, "render", lambda _: "page")
    return WRITERS[request.param]


def test_a_file_that_cannot_be_written_is_named_itself(
    write: Callable[[Path], object], tmp_path: Path
) -> None:
    path = tmp_path / f"{'long' * 70}.npz"
    with pytest.raises(OSError) as raised:
        write(path)
    assert raised.value.errno == errno.ENAMETOOLONG
    assert (raised.value.filename, raised.value.filename2) == (str(path), None)
    assert not list(tmp_path.iterdir())


def test_a_name_that_is_taken_by_a_folder_is_said_of_it(
    write: Callable[[Path], object], tmp_path: Path
) -> None:
    path = tmp_path / "taken.npz"
    path.mkdir()
    with pytest.raises(IsADirectoryError) as raised:
        write(path)
    assert (raised.value.filename, raised.value.filename2) == (str(path), None)
    assert [p.name for p in tmp_path.iterdir()] == ["taken.npz"]


@pytest.mark.parametrize("sync", [False, True])
def test_a_file_is_replaced_and_nothing_else_is_left(tmp_path: Path, sync: bool) -> None:
    path = tmp_path / "file"
    write_file(path, b"one", sync=sync)
    write_file(path, "zwei ½", sync=sync)
    assert path.read_bytes() == "zwei ½".encode()
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_file_may_be_read_by_whom_the_system_allows(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_file(tmp_path / "file", "text")
    finally:
        os.umask(before)
    assert (tmp_path / "file").stat().st_mode & 0o777 == 0o640

"""The engine of one machine, where it need not train."""

from __future__ import annotations

from pathlib import Path

from tiloilc.sweep import Local, Outcome
from tiloilc.sweep.work import Work


def test_a_job_that_cannot_begin_does_not_stop_the_others(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    works = [Work(id, str(tmp_path / "file" / id), str(tmp_path), (), 1) for id in ("a", "b")]
    ended = [event for event in Local(1).results(works) if isinstance(event, Outcome)]
    assert [outcome.id for outcome in ended] == ["a", "b"]
    assert all("Not a directory" in outcome.problem for outcome in ended)

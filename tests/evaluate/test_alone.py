"""One process at a time."""

from __future__ import annotations

from pathlib import Path

import pytest

from tiloilc.evaluate.alone import alone


@pytest.mark.parametrize("name", ["", "lock"])
def test_who_comes_second_is_refused_until_the_first_has_gone(tmp_path: Path, name: str) -> None:
    pytest.importorskip("fcntl")
    place = tmp_path / name  # a folder, or a file that is not there yet
    with alone(place), pytest.raises(BlockingIOError), alone(place, wait=False):
        raise AssertionError("two at a time")
    with alone(place, wait=False):
        assert place.exists()

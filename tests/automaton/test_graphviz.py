"""Graphviz is called in one place, which holds back what its fonts library says."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from tiloilc.automaton import rendered
from tiloilc.automaton.drawing import graphviz

FONTS = """\
<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "urn:fontconfig:fonts.dtd">
<fontconfig><no-such-element/></fontconfig>
"""


def test_it_draws() -> None:
    assert rendered("digraph { a -> b }", "png").startswith(b"\x89PNG")
    assert b"<svg" in rendered("digraph { a -> b }", "svg")


def test_only_lines_about_fonts_are_held_back(capfd: pytest.CaptureFixture[str]) -> None:
    with graphviz._without_chatter():
        os.write(2, b"before\nFontconfig warning: odd\n")
        os.write(2, b"Fontconfig error: grave\nlast, without an end")
    os.write(2, b"; after\n")
    kept = ["before", "Fontconfig error: grave", "last, without an end; after"]
    assert capfd.readouterr().err.splitlines() == kept


def test_standard_error_is_back_after_a_failure(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match="broken"), graphviz._without_chatter():
        raise ValueError("broken")
    os.write(2, b"back\n")
    assert capfd.readouterr().err == "back\n"


def test_threads_draw_one_after_the_other(capfd: pytest.CaptureFixture[str]) -> None:
    drawn: list[bytes] = []
    draw = [
        threading.Thread(target=lambda: drawn.append(rendered("digraph { a -> b }", "svg")))
        for _ in range(8)
    ]
    for thread in draw:
        thread.start()
    for thread in draw:
        thread.join()
    os.write(2, b"back\n")
    assert len(set(drawn)) == 1
    assert len(drawn) == 8
    assert capfd.readouterr().err == "back\n"


@pytest.mark.parametrize("closed", [False, True])
def test_a_machine_with_odd_fonts_says_nothing(tmp_path: Path, closed: bool) -> None:
    fonts = tmp_path / "fonts.conf"
    fonts.write_text(FONTS)
    close = "import os; os.close(2); " if closed else ""
    draw = "from tiloilc.automaton import rendered; print(len(rendered('digraph { a }', 'svg')))"
    result = subprocess.run(
        [sys.executable, "-c", close + draw],
        env={**os.environ, "FONTCONFIG_FILE": str(fonts)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert result.returncode == 0
    assert int(result.stdout) > 100
    assert "warning" not in result.stderr

"""`tiloilc step`: letters from the command line, a pipe, a demonstration, a terminal."""

from __future__ import annotations

import io
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.cli.running import Run, runner

CYCLE = "G F (r & X F (g & X F y)) & G !b"
HEAD = "time  letter        state  stage\n"


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


def piped(
    run: Run, monkeypatch: pytest.MonkeyPatch, text: str, *arguments: object
) -> tuple[int, str, str]:
    """`step` with `text` on standard input."""
    monkeypatch.setattr(sys, "stdin", io.StringIO(text))
    return run("step", *arguments)


def test_letters_of_a_pipe_are_walked_one_a_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    status, out, err = piped(run, monkeypatch, "r\n\n{g}\ny & !b\nr b\n", CYCLE)
    assert status == 0
    assert out == (
        "time  letter        state  stage\n"
        "   0  {r}               1  1 of 3\n"
        "   1  {}                1  1 of 3\n"
        "   2  {g}               2  2 of 3\n"
        "   3  {y}               3  3 of 3  accepting, visit 1\n"
        "   4  {r, b}            4  -       lost for ever\n"
    )
    assert err == (
        "G F (r & X F (g & X F y)) & G !b\n"
        "state 0, stage 0 of 3: the agent must reach r; touching b loses for ever\n"
        "  b       is lost for ever\n"
        "  else r  leads on to state 1 (stage 1)\n"
        "  else    stays\n"
    )


def test_what_is_wrong_is_said_and_nothing_is_lost(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "r\nx\n{g\ny > 2\n:back many\ncycle{r}\ng\n"
    status, out, err = piped(run, monkeypatch, text, CYCLE, "--quiet")
    assert status == 1, "a program that pipes letters hears of it"
    assert [line.split()[1] for line in out.splitlines()[1:]] == ["{r}", "{g}"]
    assert "error[LTL203]: unknown proposition `x`\n --> <stdin>:2:1\n" in err
    assert "error[LTL206]: cannot read the word: `{` is never closed" in err
    assert "error: {y} cannot lead to state 2; it can to 1" in err
    assert "error: `back many`: how many letters?" in err
    assert "error: what is repeated for ever is walked with --word" in err


def test_one_goes_back_begins_anew_and_asks_where_one_is(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "r; g\n:back\n:word\n:back 9\nr\n:reset\n:where\n:help\n:word\n:quit\nr\n"
    status, out, err = piped(run, monkeypatch, text, CYCLE)
    assert status == 0
    assert [line.split()[:2] for line in out.splitlines()[1:]] == [
        ["0", "{r}"],
        ["1", "{g}"],
        ["0", "{r}"],
    ]
    told = [line for line in err.splitlines() if not line.startswith(" ")]
    states = [line.split(",")[0] for line in told if line.startswith("state")]
    assert states == ["state 0", "state 1", "state 0", "state 0", "state 0"]
    assert "{r}" in told
    assert "no letter" in told
    assert any(line.startswith("A line is a letter") for line in told)


def test_a_proposition_may_have_the_name_of_a_command(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, _ = piped(run, monkeypatch, "back\n:back\nback\n:quit\nback\n", "F back", "-q")
    assert status == 0
    assert [line.split()[:2] for line in out.splitlines()[1:]] == [["0", "{back}"]] * 2


@pytest.mark.parametrize("name", ["q", "exit", "undo"])
def test_a_proposition_may_have_the_short_name_of_a_command(
    name: str, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, _ = piped(run, monkeypatch, f"{name}\n{name}\n", f"F {name}", "-q")
    assert status == 0
    assert [line.split()[1] for line in out.splitlines()[1:]] == [f"{{{name}}}"] * 2


@pytest.mark.parametrize("line", ["q", "quit", ":q"])
def test_a_program_gives_no_command_by_mistake(
    line: str, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, err = piped(run, monkeypatch, f"{line}\np\n", "F p", "-q")
    assert status == 1, "the line is no letter"
    assert [row.split()[1] for row in out.splitlines()[1:]] == ["{p}"]
    assert "<stdin>:1:1" in err


def test_a_jump_is_taken_only_when_it_is_chosen(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    status, out, err = piped(run, monkeypatch, "y\ny > 1\ny\n", "F G y & G !b")
    assert status == 0
    assert out == HEAD + (
        "   0  {y}               0  0 of 1\n"
        "   1  {y}               1  1 of 1  accepting, visit 1; by an ε-jump\n"
        "   2  {y}               1  1 of 1  accepting, visit 2\n"
    )
    assert "{y} leads to 0; by a jump too: `> 1`\n" in err
    assert "or decide for state 1, that from here on G y & G !b (ε-jump)" in err


def test_a_word_is_walked_by_its_best_run(run: Run) -> None:
    status, out, err = run("step", "F G y & G !b", "--word", "{y} {} {y} {y}")
    assert (status, err) == (0, "2 accepting visits\n")
    assert [line.split()[2] for line in out.splitlines()[1:]] == ["0", "0", "1", "1"]


def test_of_an_infinite_word_it_is_said_whether_it_is_accepted(run: Run) -> None:
    status, out, err = run("step", "F G y & G !b", "--word", "{} then for ever {y}")
    assert (status, err) == (
        0,
        "accepted: from time 1 on this repeats, and accepts again and again\n",
    )
    assert [line.split()[2] for line in out.splitlines()[1:]] == ["0", "1"]
    status, out, err = run("step", "F G y & G !b", "--word", "cycle{y; !y}")
    assert (status, err) == (0, "rejected: no run accepts again and again\n")
    assert len(out.splitlines()) == 5


def test_a_word_that_cannot_be_read_is_a_finding(run: Run) -> None:
    status, out, err = run("step", CYCLE, "--word", "{r} {q}")
    assert (status, out) == (1, "")
    assert "error[LTL203]: unknown proposition `q`" in err
    assert "1 | {r} {q}\n  |      ^ not declared" in err


def test_a_demonstration_is_walked(run: Run, root: Path) -> None:
    status, out, err = run("step", root / "specs/grid_sequential_easy.yaml", "--demo", 0)
    assert status == 0
    lines = out.splitlines()
    assert lines[0] + "\n" == HEAD
    assert lines[1] == "   0  {}                0  0 of 3"
    assert [int(line.split()[0]) for line in lines[1:]] == list(range(len(lines) - 1))
    assert "accepting, visit 1" in out
    assert err.startswith("demonstration 0: ")
    assert err.endswith(" after the start, never lost\n")


def test_a_demonstration_of_a_build_folder_is_the_one_of_its_task(
    run: Run, root: Path, tmp_path: Path
) -> None:
    task = root / "specs/flatworld_stabilization.yaml"
    run("compile", task, "-o", tmp_path / "built")
    walked = run("step", task, "--demo", 3)
    assert walked == run("step", tmp_path / "built", "--demo", 3)
    assert "by an ε-jump" in walked[1]


def test_a_demonstration_that_is_not_there_is_a_usage_error(run: Run, root: Path) -> None:
    status, out, err = run("step", root / "specs/grid_avoid_easy.yaml", "--demo", 5)
    assert (status, out) == (2, "")
    assert "there are demonstrations 0 to 4, none with number 5" in err
    assert run("step", CYCLE, "--demo", 0)[0] == 2
    assert run("step", CYCLE, "--demo", 0, "--word", "r")[0] == 2


def test_an_automaton_from_a_file_is_walked(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "own.hoa").write_text(run("translate", CYCLE)[1], encoding="utf-8")
    status, out, _ = piped(run, monkeypatch, "r\ng\ny\n", tmp_path / "own.hoa", "-q")
    assert status == 0
    assert out.endswith("accepting, visit 1\n")
    assert run("step", tmp_path / "none.hoa")[0] == 2


def test_a_formula_that_nothing_satisfies_is_lost_from_the_start(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, err = piped(run, monkeypatch, "a\n", "F a & G !a")
    assert status == 0
    assert out == HEAD + "   0  {a}               0  -       lost for ever\n"
    assert "lost for ever, whatever comes" in err


# A terminal


def _heed_interrupts() -> None:
    """As at a terminal: what runs in the background is started with interrupts ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


class Terminal:
    """`tiloilc step` at a pseudo-terminal."""

    def __init__(self, *arguments: str) -> None:
        self.master, slave = pty.openpty()
        command = [sys.executable, "-m", "tiloilc", "step", *arguments]
        environment = {**os.environ, "NO_COLOR": "1", "TERM": "dumb"}
        self.process = subprocess.Popen(
            command,
            stdin=slave,
            stdout=slave,
            stderr=slave,
            env=environment,
            start_new_session=True,
            preexec_fn=_heed_interrupts,
        )
        os.close(slave)
        self.shown = ""

    def until(self, text: str) -> str:
        """What is shown from now on up to `text`."""
        begun, deadline = len(self.shown), time.monotonic() + 60
        while text not in self.shown[begun:]:
            assert time.monotonic() < deadline, self.shown
            try:
                self.shown += os.read(self.master, 4096).decode().replace("\r\n", "\n")
            except OSError:
                raise AssertionError(f"it ended: {self.shown}") from None
        return self.shown[begun:]

    def say(self, text: str) -> None:
        os.write(self.master, text.encode())

    def ends(self) -> int:
        status = self.process.wait(timeout=60)
        os.close(self.master)
        return status


def test_a_person_is_asked_which_way_to_go() -> None:
    terminal = Terminal("F G y & G !b")
    assert "propositions: y, b. `help` says what can be written." in terminal.until("\n> ")
    terminal.say("y\n")
    asked = terminal.until("which? [0/1] ")
    assert "to 1 by an ε-jump: from then on G y & G !b" in asked
    terminal.say("7\n")
    assert "`7` is none of them: the letter was not read" in terminal.until("\n> ")
    terminal.say("y\n")
    terminal.until("which? [0/1] ")
    terminal.say("1\n")
    assert "1 of 1  accepting, visit 1; by an ε-jump" in terminal.until("\n> ")
    terminal.say("b\n")
    assert "lost for ever" in terminal.until("\n> ")
    terminal.say("\x04")
    assert terminal.ends() == 0


def test_at_a_terminal_a_proposition_comes_before_a_command_and_its_short_names() -> None:
    terminal = Terminal("F q")
    terminal.until("\n> ")
    terminal.say("q\n")
    assert "0  {q}  " in terminal.until("\n> ")
    terminal.say("undo\n")
    assert "state 0, " in terminal.until("\n> ")
    terminal.say(":q\n")
    assert terminal.ends() == 0


def test_an_interrupt_ends_the_walk_quietly() -> None:
    terminal = Terminal("G F a")
    terminal.until("\n> ")
    os.killpg(terminal.process.pid, signal.SIGINT)
    assert terminal.ends() == 0
    assert "Traceback" not in terminal.shown

"""Reads and runs the pages of docs/diagnostics: what a page shows is what happens.

A page is Markdown. Its blocks run from top to bottom, in an empty folder; the words after the
language of a fence say what a block is:

| fence              | the block is                                                              |
|--------------------|---------------------------------------------------------------------------|
| `yaml bad`         | a task file in which `tiloilc lint` finds the code                        |
| `yaml good`        | one in which it finds neither the code nor any error                      |
| `yaml task`        | one for the commands that follow                                          |
| `console bad`      | commands; what the last one prints names the code                         |
| `console good`     | commands that end well, without naming the code                           |
| `console task`     | commands that lead up to those that follow                                |
| `python bad`       | a program that is refused with the code                                   |
| `python good`      | a program that is not                                                     |
| `text`             | what the bad block before it prints, to the letter                        |
| `LANGUAGE FILE`    | a file beside the task file                                               |
| `python run`       | a program that is run, for instance to write demonstrations               |
| no word            | not run                                                                   |

A task file is completed from BASE: the sections that it does not have are put behind it, so that
line numbers count from the block. With `whole` nothing is put behind it. `<!-- run … -->` is a
program that readers do not see; it has pytest's `monkeypatch`.

`python -m tests.diag.pages [CODE…]` writes what is printed now into the `text` blocks.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tiloilc.cli.console import sources
from tiloilc.diag import RULES, CompileError, render
from tiloilc.driver import lint

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "diagnostics"

BASE = """\
name: task
environment:
  id: tiloilc/FlatWorld-v0
  horizon: 50
propositions:
  a: pos[0] > 1
  b: pos[1] > 1
formula: "G F a & G !b"
train:
  steps: 20_000
"""

TASK = "task.yaml"
_BLOCK = re.compile(r"^```(?P<info>[^\n`]*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
_HIDDEN = re.compile(r"^<!-- run\n(?P<hidden>.*?)^-->$", re.MULTILINE | re.DOTALL)
_ANY = re.compile(f"{_BLOCK.pattern}|{_HIDDEN.pattern}", re.MULTILINE | re.DOTALL)
_SECTION = re.compile(r"^([a-z]+):", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """One fence of a page: its language, the words after it, its text, where the text stands."""

    language: str
    words: tuple[str, ...]
    body: str
    start: int

    @property
    def role(self) -> str:
        """`bad`, `good`, `task`, `run`, a file's name, or nothing."""
        return self.words[0] if self.words else ""


@dataclass(frozen=True)
class Shown:
    """A bad block, what it printed, and the `text` block that shows it, if there is one."""

    bad: Block
    printed: str
    text: Block | None


def blocks(page: str) -> Iterator[Block]:
    """The blocks of a page, hidden programs among them."""
    for found in _ANY.finditer(page):
        if found["hidden"] is not None:
            yield Block("python", ("run",), found["hidden"], found.start("hidden"))
        else:
            language, *words = found["info"].split() or [""]
            yield Block(language, tuple(words), found["body"], found.start("body"))


def completed(text: str) -> str:
    """A task file with the sections of BASE that it does not have behind it."""
    own = set(_SECTION.findall(text))
    if "automaton" in own:
        own.add("formula")
    sections = re.split(r"^(?=[a-z]+:)", BASE, flags=re.MULTILINE)
    return text + "".join(s for s in sections if s and s.split(":")[0] not in own)


def run_page(code: str, page: str) -> list[Shown]:
    """Run every block of a page in the current folder, which is empty, and judge the good ones."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        return _run_blocks(code, page, monkeypatch)


def _run_blocks(code: str, page: str, monkeypatch: pytest.MonkeyPatch) -> list[Shown]:
    shown: list[Shown] = []
    printed: tuple[Block, str] | None = None
    for block in blocks(page):
        if block.role == "bad":
            assert printed is None, f"a bad block without its text: {printed}"
            printed = block, _printed(block)
            assert f"[{code}]" in printed[1], f"not {code}:\n{printed[1]}"
        elif block.language == "text" and not block.words and printed is not None:
            shown.append(Shown(*printed, block))
            printed = None
        elif block.role == "good":
            output = _printed(block)
            assert f"[{code}]" not in output, f"the good example:\n{output}"
            assert "error" not in output, f"the good example:\n{output}"
        elif block.role == "task" and block.language == "console":
            _printed(block)
        elif block.role == "task":
            Path(TASK).write_text(completed(block.body), encoding="utf-8")
        elif block.role == "run":
            _run(block, {"monkeypatch": monkeypatch})
        elif block.words:
            Path(block.role).write_text(block.body, encoding="utf-8")
    return shown if printed is None else [*shown, Shown(*printed, None)]


@contextlib.contextmanager
def own_modules(folder: Path) -> Iterator[None]:
    """Afterwards the modules of `folder` are forgotten, so that the next page may have the same."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # environments are registered again by the next page
        try:
            yield
        finally:
            for name, module in list(sys.modules.items()):
                if str(getattr(module, "__file__", None) or "").startswith(str(folder)):
                    del sys.modules[name]


def _printed(block: Block) -> str:
    if block.language == "yaml":
        text = block.body if "whole" in block.words else completed(block.body)
        Path(TASK).write_text(text, encoding="utf-8")
        try:
            found = list(lint(TASK))
        except CompileError as error:
            found = list(error.diagnostics)
        return render(found, "text", {**sources(found), TASK: text})
    if block.language == "python":
        try:
            _run(block, {})
        except CompileError as error:
            return render(error.diagnostics, "text", {})
        return ""
    assert block.language == "console", f"cannot run {block.language}"
    output = ""
    for line in block.body.splitlines():
        assert line.startswith("$ "), f"not a command: {line}"
        status, output = _command(line.removeprefix("$ "))
        assert block.role == "bad" or status == 0, output
    return output


def _run(block: Block, names: dict[str, object]) -> None:
    sys.path.insert(0, "")
    try:
        exec(compile(block.body, "<page>", "exec"), names)
    finally:
        sys.path.remove("")


def _command(line: str) -> tuple[int, str]:
    """Exit status and all output of a command, run in this process."""
    import shlex

    from tiloilc.cli import main

    program, *arguments = shlex.split(line)
    assert program == "tiloilc", line
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
        try:
            main(arguments)
        except SystemExit as end:
            return int(end.code or 0), output.getvalue()
    raise AssertionError("main ends by SystemExit")


def rewritten(page: str, shown: list[Shown]) -> str:
    """The page with what is printed now; where there was no `text` block, with a new one."""
    for one in reversed(shown):
        if one.text is not None:
            end = one.text.start + len(one.text.body)
            page = page[: one.text.start] + one.printed + page[end:]
        else:
            end = one.bad.start + len(one.bad.body) + len("```\n")
            page = f"{page[:end]}\n```text\n{one.printed}```\n{page[end:]}"
    return page


INDEX = """\
# Diagnostics

One page a code: what it means, an example of it with what is printed, and what to write instead.
`tiloilc explain CODE` prints the page. The pages are run as tests.
"""

AREAS = {
    "SPEC": "Task files",
    "LTL": "Formulas",
    "AUT": "Automata",
    "PLAN": "Stages and plans",
    "DEMO": "Demonstrations",
    "JOB": "Environments and settings",
    "RUN": "Training",
}


def index() -> str:
    """The text of the pages' README: every code, its severity and its name, by area."""
    lines = [INDEX]
    for area, title in AREAS.items():
        lines += [f"## {title}\n", "| code | severity | name |", "|---|---|---|"]
        lines += [
            f"| [{code}]({code}.md) | {rule.severity} | {rule.name} |"
            for code, rule in RULES.items()
            if code.rstrip("0123456789") == area
        ]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def write(codes: list[str]) -> None:
    """Bring the `text` blocks of the pages, and the index, up to date."""
    (FOLDER / "README.md").write_text(index(), encoding="utf-8")
    for code in codes:
        path, here = FOLDER / f"{code}.md", Path.cwd()
        page = path.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder, own_modules(Path(folder)):
            os.chdir(folder)
            try:
                shown = run_page(code, page)
            except Exception as error:
                sys.stderr.write(f"{code}: {type(error).__name__}: {error}\n")
                continue
            finally:
                os.chdir(here)
        path.write_text(rewritten(page, shown), encoding="utf-8")


if __name__ == "__main__":
    write(sys.argv[1:] or sorted(path.stem for path in FOLDER.glob("*[0-9].md")))

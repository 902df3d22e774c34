"""Every command that the README shows is run.

Commands stand in fenced blocks marked `console` (lines that begin with `$ ` are commands, the
others what they print) or `bash` (all lines). Blocks share one folder, a copy of the checkout's
tracked files, and run from top to bottom as a reader would. A comment right before a block says how
it is tested:

    (none)                                      it runs in the everyday tests
    <!-- test: slow -->                         it runs in the slow tests
    <!-- test: tests/e2e/test_x.py::test_y -->  that test runs these commands; it must exist

There is no way to say that a block is not tested.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.e2e.conftest import Run

COPIED = ("specs", "sweeps", "examples", "results", "tasks", "README.md", "pyproject.toml")
"""What of the checkout the commands find in their folder."""

PAGES = (
    "README.md",
    "examples/exported_policy/README.md",
    "examples/own_environment/README.md",
    "examples/third_party/README.md",
    "examples/own_demonstrations/README.md",
    "examples/imported_automaton/README.md",
)
"""Pages with commands; those of the examples are run by test_examples.py."""

BLOCK = re.compile(
    r"(?:^<!-- *test: *(?P<mark>[^>]*?) *-->\n\n?)?"
    r"^```(?P<language>console|bash)\n(?P<body>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Block:
    """One fenced block: where it begins, how it is tested, its commands as one script."""

    line: int
    mark: str
    script: str


def blocks(text: str) -> list[Block]:
    """The command blocks of a Markdown text, in order."""
    found = []
    for match in BLOCK.finditer(text):
        body = match["body"]
        if match["language"] == "console":
            body = "".join(
                line[2:] + "\n" for line in body.splitlines() if line.startswith(("$ ", "> "))
            )
        line = text.count("\n", 0, match.start("language")) + 1
        found.append(Block(line, match["mark"] or "", body))
    return found


def run(block: Block, folder: Path) -> None:
    """Run a block's commands in `folder`; the first that fails, fails the test."""
    commands = str(Path(sys.executable).parent)
    path = os.pathsep.join([commands, os.environ.get("PATH", os.defpath)])
    result = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", block.script],
        cwd=folder,
        env={**os.environ, "PATH": path, "NO_COLOR": "1"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    told = f"README.md:{block.line}\n{block.script}\n{result.stdout}\n{result.stderr}"
    assert result.returncode == 0, told


@pytest.fixture
def readme(root: Path) -> list[Block]:
    return blocks((root / "README.md").read_text(encoding="utf-8"))


@pytest.fixture
def folder(root: Path, tmp_path: Path) -> Path:
    for name in COPIED:
        source = root / name
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "build", "runs")
            shutil.copytree(source, tmp_path / name, ignore=ignored)
        elif source.exists():
            shutil.copy(source, tmp_path)
    return tmp_path


def test_quick_commands_of_the_readme_run(readme: list[Block], folder: Path) -> None:
    quick = [block for block in readme if not block.mark]
    assert quick
    for block in quick:
        run(block, folder)


@pytest.mark.slow
def test_all_commands_of_the_readme_run_in_order(readme: list[Block], folder: Path) -> None:
    assert any(block.mark == "slow" for block in readme), "the quick test runs all of them"
    for block in readme:
        if block.mark in ("", "slow"):
            run(block, folder)


@pytest.mark.parametrize("page", PAGES)
def test_every_mark_is_known_and_every_named_test_exists(page: str, root: Path) -> None:
    for block in blocks((root / page).read_text(encoding="utf-8")):
        if block.mark in ("", "slow"):
            continue
        path, separator, name = block.mark.partition("::")
        assert separator, f"{page}:{block.line}: `{block.mark}` is no mark"
        tree = ast.parse((root / path).read_text(encoding="utf-8"))
        functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        assert name in functions, f"{page}:{block.line}: no test {block.mark}"


@pytest.mark.parametrize("page", PAGES)
def test_no_block_escapes_the_harness(page: str, root: Path) -> None:
    text = (root / page).read_text(encoding="utf-8")
    fences = re.findall(r"^( *)```(\S*)", text, re.MULTILINE)
    assert [indent for indent, _ in fences if indent] == [], "an indented block is not read"
    opened = [language for _, language in fences][::2]
    assert all(opened), "a block without a language"
    assert {"sh", "shell", "zsh", "shell-session"}.isdisjoint(opened), "say console or bash"
    assert sum(language in ("console", "bash") for language in opened) == len(blocks(text))
    others = re.findall(r"^```(?!console|bash)\w+\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    command = re.compile(r"^(\$ |make |pip |python |tiloilc )", re.MULTILINE)
    assert [block for block in others if command.search(block)] == [], "commands in another block"


@pytest.mark.parametrize("page", [*PAGES, "CONTRIBUTING.md", "CHANGELOG.md", "examples/README.md"])
def test_every_link_into_the_checkout_leads_somewhere(page: str, root: Path) -> None:
    text = (root / page).read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)#\s]+)", text)
    inside = [target for target in targets if "://" not in target]
    assert [target for target in inside if not (root / page).parent.joinpath(target).exists()] == []


def test_the_task_files_of_the_readme_are_without_findings(
    root: Path, tmp_path: Path, tiloilc: Run
) -> None:
    text = (root / "README.md").read_text(encoding="utf-8")
    tasks = re.findall(r"^```yaml\n(name:.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert tasks
    for number, task in enumerate(tasks):
        (tmp_path / f"{number}.yaml").write_text(task, encoding="utf-8")
        tiloilc("lint", "--deny", "warnings", f"{number}.yaml", cwd=tmp_path)


def test_blocks_are_read_with_their_marks_and_without_their_output() -> None:
    text = (
        "Text.\n\n```console\n$ tiloilc lint a.yaml\nall fine\n$ tiloilc \\\n> --help\n```\n\n"
        "<!-- test: slow -->\n```bash\nmake run\n```\n\n```python\nimport tiloilc\n```\n"
    )
    assert blocks(text) == [
        Block(3, "", "tiloilc lint a.yaml\ntiloilc \\\n--help\n"),
        Block(11, "slow", "make run\n"),
    ]


def test_a_failing_command_is_noticed_even_when_another_follows(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match=r"README\.md:7"):
        run(Block(7, "", "false\ntrue\n"), tmp_path)
    with pytest.raises(AssertionError):
        run(Block(7, "", "false | true\n"), tmp_path)

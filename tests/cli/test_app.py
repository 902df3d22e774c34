import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from tests.cli.running import Run, runner
from tests.driver.specs import spec
from tiloilc.cli import app
from tiloilc.cli.app import VERBS, main
from tiloilc.diag import CompileError, Diagnostic


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


def python(*arguments: str, cwd: Path, **env: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=cwd,
        env={**os.environ, **env},
        capture_output=True,
        text=True,
        timeout=120,
    )


def verb(monkeypatch: pytest.MonkeyPatch, body: Callable[[], None]) -> None:
    """Put `body` in the place of the verb `schema`."""
    module = ModuleType("schema")
    module.command = body  # type: ignore[attr-defined]
    monkeypatch.setattr(app, "import_module", lambda name: module)


def test_the_help_lists_the_verbs_and_no_others(run: Run) -> None:
    status, out, _ = run("--help")
    listed = [line.split()[0] for line in out.partition("Commands:")[2].splitlines() if line]
    assert status == 0
    assert listed == list(VERBS)


def test_every_verb_has_help(run: Run) -> None:
    for name in VERBS:
        status, out, _ = run(name, "--help")
        assert status == 0
        assert out.startswith("Usage: tiloilc")


def test_the_version_is_printed(run: Run) -> None:
    import tiloilc

    assert run("--version")[:2] == (0, f"tiloilc {tiloilc.__version__}\n")


def test_a_misspelt_verb_is_a_usage_error(run: Run) -> None:
    status, out, err = run("lnit")
    assert (status, out) == (2, "")
    assert "lnit" in err


def test_a_missing_file_is_a_usage_error(run: Run, tmp_path: Path) -> None:
    for name in ("lint", "compile", "viz"):
        assert run(name, tmp_path / "none.yaml")[0] == 2


def test_an_internal_error_says_that_it_is_ours(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails() -> None:
        raise ZeroDivisionError("one by none")

    verb(monkeypatch, fails)
    status, out, err = run("schema")
    assert (status, out) == (2, "")
    assert "internal error: ZeroDivisionError: one by none" in err
    assert "tiloilc schema" in err
    assert "Traceback" not in err


def test_the_traceback_of_an_internal_error_is_for_those_who_ask(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fails() -> None:
        raise ZeroDivisionError

    verb(monkeypatch, fails)
    monkeypatch.setenv(app.TRACEBACK, "1")
    with pytest.raises(ZeroDivisionError):
        main(["schema"])


def test_a_place_where_nothing_can_be_written_is_the_users_matter(run: Run, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    status, _, err = run("compile", spec(tmp_path), "-q", "-o", tmp_path / "file" / "out")
    assert status == 2
    assert err.startswith("error: cannot use")


def test_findings_that_stop_a_verb_go_to_standard_error(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails() -> None:
        raise CompileError(Diagnostic.of("PLAN402"))

    verb(monkeypatch, fails)
    status, out, err = run("schema")
    assert (status, out) == (1, "")
    assert err.startswith("error[PLAN402]")


def test_the_help_loads_nothing_that_takes_long(root: Path) -> None:
    helped = python("-X", "importtime", "-m", "tiloilc", "--help", cwd=root)
    assert helped.returncode == 0
    loaded = {line.rpartition("|")[2].strip().split(".")[0] for line in helped.stderr.splitlines()}
    assert "typer" in loaded
    assert not loaded & {"numpy", "torch", "gymnasium", "networkx", "pydantic", "lark", "mujoco"}


@pytest.mark.parametrize("arguments", [["lint"], ["sweep", "--dry-run"]], ids=" ".join)
def test_what_does_not_train_imports_no_torch(root: Path, arguments: list[str]) -> None:
    command = ("-X", "importtime", "-m", "tiloilc", *arguments, "specs/flatworld_cycle.yaml")
    imported = python(*command, cwd=root)
    assert imported.returncode == 0
    assert "tiloilc.driver" in imported.stderr
    assert " torch" not in imported.stderr


def test_output_that_nobody_reads_is_no_error(root: Path) -> None:
    command = f"{sys.executable} -m tiloilc schema | head -1"
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command],
        cwd=root, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(28, "No space left on device"), "error: No space left on device\n"),
        (OSError(21, "Is a directory", ".x.tmp", None, "x"), "error: cannot use `x`: Is a dir"),
    ],
)
def test_what_the_machine_refuses_is_not_our_fault(
    run: Run, monkeypatch: pytest.MonkeyPatch, error: OSError, said: str
) -> None:
    def fails() -> None:
        raise error

    verb(monkeypatch, fails)
    status, _, err = run("schema")
    assert status == 2
    assert err.startswith(said)


@pytest.mark.parametrize("verb", ["explain", "lint"])
def test_what_a_terminal_cannot_show_is_escaped(root: Path, verb: str) -> None:
    task = "specs/flatworld_stabilization.yaml"
    done = python("-m", "tiloilc", verb, task, cwd=root, PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    assert "\\u" in done.stdout


def test_closed_streams_are_no_reason_to_fail(root: Path) -> None:
    closed = "import sys; sys.stdout = sys.stderr = None; from tiloilc.cli import main; "
    assert python("-c", closed + "main(['translate', 'F a'])", cwd=root).returncode == 0

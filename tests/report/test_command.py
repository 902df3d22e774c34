"""`tiloilc report`, and the page in a browser."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.report.runs import write_run
from tiloilc.cli import main
from tiloilc.report import write_report

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


def status(*arguments: object) -> object:
    with pytest.raises(SystemExit) as left:
        main([str(argument) for argument in arguments])
    return left.value.code


def test_one_run_gets_its_report_in_its_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = write_run(tmp_path / "a1", seeds=2)
    assert status("report", run) == 0
    assert capsys.readouterr().out == f"{run / 'report.html'}\n"
    assert (run / "report.html").read_text().startswith("<!DOCTYPE html>")


def test_a_report_does_not_change_the_next_one(tmp_path: Path) -> None:
    run = write_run(tmp_path / "a1", seeds=2)
    assert status("report", run, "--quiet") == 0
    first = (run / "report.html").read_bytes()
    assert status("report", run, "--quiet") == 0
    assert (run / "report.html").read_bytes() == first


def test_several_runs_are_compared_where_the_user_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = [write_run(tmp_path / name, seeds=2) for name in ("a", "b")]
    monkeypatch.chdir(tmp_path)
    assert status("report", *runs) == 0
    assert "2 runs compared" in (tmp_path / "report.html").read_text()
    assert status("report", *runs, "-o", tmp_path / "new" / "both.html") == 0
    assert (tmp_path / "new" / "both.html").is_file()


def test_a_missing_folder_is_a_usage_error_and_a_damaged_one_a_finding(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status("report", tmp_path / "none") == 2
    assert "no run folder" in capsys.readouterr().err
    assert status("report", tmp_path) == 1
    assert "error[RUN701]" in capsys.readouterr().err
    run = write_run(tmp_path / "a", seeds=2)
    assert status("report", run, "-o", tmp_path) == 2


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here")
def test_a_browser_shows_the_page_without_a_complaint(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / name) for name in ("a", "b")]
    page = write_report(runs, tmp_path / "report.html")
    done = subprocess.run(
        [
            str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu",
            "--disable-background-networking", f"--user-data-dir={tmp_path / 'profile'}",
            "--enable-logging=stderr", "--dump-dom", page.as_uri(),
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert "2 runs compared" in done.stdout
    assert [line for line in done.stderr.splitlines() if "CONSOLE" in line] == []

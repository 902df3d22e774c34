"""`tiloilc report`, and the page in a browser."""

import json
import re
import shutil
import subprocess
from html import escape
from pathlib import Path

import pytest

from tests.report.runs import write_run
from tests.report.test_several import VERIFIED
from tiloilc.cli import main
from tiloilc.report import write_report

GIF = bytes.fromhex(
    "47494638396101000100800000ffffff00000021f90400000000002c00000000010001000002024401003b"
)
"""One white pixel."""

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


def test_a_report_is_written_to_a_page_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run, mine = write_run(tmp_path / "a", seeds=2), tmp_path / "mine.yaml"
    mine.write_text("mine")
    assert status("report", run, "-o", "mine.yaml") == 2
    assert capsys.readouterr().err == "error: a report is x.html or x.htm, not `mine.yaml`\n"
    assert mine.read_text() == "mine"
    assert status("report", run, "-o", "mine.HTM") == 0


def browsed(page: Path, profile: Path) -> tuple[str, list[str]]:
    """(the document after its scripts ran, what the console says) of a page in Chromium."""
    done = subprocess.run(
        [
            str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu",
            "--disable-background-networking", f"--user-data-dir={profile}",
            "--enable-logging=stderr", "--virtual-time-budget=5000", "--dump-dom", page.as_uri(),
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def compared(folder: Path) -> Path:
    """The page of two runs that has all there is: films, verification, rewards."""
    runs = [write_run(folder / "a"), write_run(folder / "b", overrides={"beta": 0})]
    (runs[0] / "verify.json").write_text(json.dumps(VERIFIED))
    (runs[1] / "video.gif").write_bytes(GIF)
    return write_report(runs, folder / "report.html")


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here")
def test_a_browser_shows_the_page_without_a_complaint(tmp_path: Path) -> None:
    document, complaints = browsed(compared(tmp_path), tmp_path / "profile")
    assert "2 runs compared" in document
    assert complaints == []


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here")
def test_on_a_phone_nothing_is_wider_than_the_screen(tmp_path: Path) -> None:
    page = compared(tmp_path).read_text(encoding="utf-8")
    open_page = page.replace('<details class="run">', '<details class="run" open>')
    outer = tmp_path / "phone.html"
    outer.write_text(
        f"""<iframe width="390" height="800" style="border:0" srcdoc="{escape(open_page)}"></iframe>
        <script>document.querySelector("iframe").addEventListener("load", (event) => {{
          const inside = event.target.contentDocument.documentElement;
          document.title = `${{inside.clientWidth}} ${{inside.scrollWidth}}`;
        }});</script>""",
        encoding="utf-8",
    )
    document, _ = browsed(outer, tmp_path / "profile")
    title = re.search(r"<title>(\d+) (\d+)</title>", document)
    assert title is not None
    assert int(title[1]) > 300
    assert title[1] == title[2]

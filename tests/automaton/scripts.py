"""Runs JavaScript for tests: in node where it is installed, else in a headless Chromium."""

from __future__ import annotations

import html
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
SECONDS = 120


def run_script(script: str) -> str:
    """What `script` gives to `print`, in node or in a browser. Skips where neither is there."""
    node = shutil.which("node") or shutil.which("nodejs")
    if node is None:
        page = f"<!DOCTYPE html><meta charset=utf-8><pre id=printed></pre><script>{_PRINT}{script}"
        return printed(page + "</script>")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "script.js"
        file.write_text(f"const print = (text) => console.log(text);\n{script}", encoding="utf-8")
        command = [node, str(file)]
        result = subprocess.run(
            command, capture_output=True, text=True, timeout=SECONDS, check=False
        )
    assert result.returncode == 0, result.stderr
    return result.stdout.removesuffix("\n")


_PRINT = "const print = (text) => { document.getElementById('printed').textContent += text; };\n"


def acted(page: str, script: str) -> str:
    """What `script`, run in the page once it is there, gives to `print`. In a browser only."""
    end = f"<pre id=printed></pre><script>{_PRINT}{script}</script>\n</body>"
    return printed(page.replace("</body>", end))


def printed(page: str) -> str:
    """The text of the element `printed` after a browser has run the page from a file."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip("no browser here: this runs the page's script in a headless Chromium")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        file.write_text(page, encoding="utf-8")
        result = subprocess.run(
            [browser, *FLAGS, f"--user-data-dir={folder}/profile", "--dump-dom", file.as_uri()],
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
    found = re.search(r'<pre id="printed">(.*?)</pre>', result.stdout, re.DOTALL)
    assert found is not None, result.stderr
    return html.unescape(found[1])

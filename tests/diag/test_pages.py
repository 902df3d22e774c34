"""Every code has a page, and what the page shows is what happens."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.diag.pages import FOLDER, blocks, completed, index, own_modules, run_page
from tiloilc.diag import RULES
from tiloilc.diag.pages import meaning, page, readable

CODES = sorted(path.stem for path in FOLDER.glob("*[0-9].md"))


def test_every_code_has_a_page_and_every_page_a_code() -> None:
    assert set(CODES) == set(RULES)


def test_the_index_lists_all_pages() -> None:
    written = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert written == index(), "write it anew: python -m tests.diag.pages"


@pytest.mark.parametrize("code", CODES)
def test_a_page_begins_with_its_code_and_has_a_bad_and_a_good_example(code: str) -> None:
    rule, text = RULES[code], page(code)
    assert text.startswith(f"# {rule.severity}[{code}]: {rule.name}\n\n")
    assert len(meaning(code)) > 40
    assert re.findall(r"^## (.*)$", text, re.MULTILINE) == ["Example", "Instead"]
    roles = {block.role for block in blocks(text)}
    assert {"bad", "good"} <= roles
    assert max(map(len, re.sub(r"```text.*?```", "", text, flags=re.DOTALL).splitlines())) <= 100


@pytest.mark.parametrize("code", CODES)
def test_a_page_shows_what_happens(code: str, workdir: Path) -> None:
    with own_modules(workdir):
        shown = run_page(code, page(code))
    for one in shown:
        assert one.text is not None, f"no text block after:\n{one.bad.body}"
        assert one.text.body == one.printed, f"write it anew: python -m tests.diag.pages {code}"


def test_a_snippet_is_completed_by_the_sections_that_it_does_not_have() -> None:
    text = completed('formula: "F a"\ntrain:\n  steps: 5\n')
    assert text.startswith('formula: "F a"\ntrain:\n  steps: 5\nname: task\n')
    assert text.count("formula:") == text.count("train:") == 1
    assert "formula" not in completed("automaton: mine.hoa\n")


def test_a_page_that_shows_something_else_is_noticed(
    workdir: Path,
) -> None:
    good = '```yaml good\nformula: "G F a & G !q"\n```\n'
    with pytest.raises(AssertionError, match="the good example"):
        run_page("LTL203", good)
    with pytest.raises(AssertionError, match="not LTL203"):
        run_page("LTL203", good.replace("good", "bad").replace("q", "b"))
    (shown,) = run_page("LTL203", good.replace("good", "bad") + "\n```text\nx\n```\n")
    assert shown.text is not None
    assert shown.text.body != shown.printed


def test_a_page_is_readable_in_a_terminal() -> None:
    markdown = (
        "# X1\n\nWords.\n\n<!-- run\nx = 1\n-->\n\n## Example\n\n```yaml bad\na:\n\n  b\n```\n"
    )
    assert readable(markdown) == "X1\n\nWords.\n\nExample\n\n    a:\n\n      b\n"

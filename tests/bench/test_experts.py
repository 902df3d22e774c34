"""The page of tasks and experts."""

import re
from pathlib import Path

import pytest

from tiloilc.bench import experts
from tiloilc.bench.experts import main, page_of, row, rows_of
from tiloilc.spec import read_spec


def test_a_row_tells_what_is_asked_and_how_the_expert_does(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(experts, "EPISODES", 3)
    told = row(root / "specs" / "grid_avoid_easy.yaml")
    first = r"\| `grid_avoid_easy` \| `F a & G !z` \| 17 \| 2 \| one of 5 \| 11 \| `avoid` "
    assert re.fullmatch(first + r"\| 100% \| 100% \| \d+ \|\n", told)


def test_an_expert_that_fails_is_not_counted(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experts, "EPISODES", 2)
    text = (root / "specs" / "grid_avoid_easy.yaml").read_text(encoding="utf-8")
    hasty = root / "specs" / "grid_avoid_easy.yaml"
    assert "horizon: 17" in text
    monkeypatch.setattr(experts, "analyse", _with_horizon(5))
    assert row(hasty).endswith("| 0% | 0% | nan |\n")


def _with_horizon(horizon: int) -> object:
    from dataclasses import replace

    from tiloilc.driver import analyse

    def wrapped(path: Path, demos: object) -> object:
        about = analyse(path, demos)
        made = about.spec.environment.model_copy(update={"horizon": horizon})
        return replace(about, spec=about.spec.model_copy(update={"environment": made}))

    return wrapped


def test_rows_of_other_tasks_stay_as_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(experts, "EPISODES", 1)
    page = tmp_path / "tasks.md"
    old = "| `flatworld_cycle` | as it was |\n"
    page.write_text(page_of({"flatworld_cycle": old, "gone": "| `gone` | – |\n"}))
    main([str(page), "grid_avoid_easy"])
    rows = rows_of(page.read_text())
    assert rows["flatworld_cycle"] == old
    assert sorted(rows) == ["flatworld_cycle", "grid_avoid_easy"]


def test_the_page_of_tasks_is_about_the_task_files_of_today(root: Path) -> None:
    """`make experts` writes it anew."""
    page = (root / "docs" / "tasks.md").read_text(encoding="utf-8")
    rows = rows_of(page)
    assert page == page_of(rows)
    for name, told in rows.items():
        spec = read_spec(root / "specs" / f"{name}.yaml").spec
        formula = str(spec.formula).replace("|", "\\|")
        assert told.startswith(f"| `{name}` | `{formula}` | {spec.environment.horizon} |")

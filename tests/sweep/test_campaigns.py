"""The sweep files of sweeps/ ask for what there is, and for what the pages of results want."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.report.results.records import records
from tests.sweep.made import asked
from tiloilc.evaluate import Record
from tiloilc.report.results.book import Book
from tiloilc.report.results.pages import ablations, demonstrations
from tiloilc.report.results.tasks import read_tasks
from tiloilc.spec import read_spec
from tiloilc.sweep import Options, check
from tiloilc.sweep.request import of_specs, requests

FILES = sorted((ROOT / "sweeps").glob("*.yaml"))

VARIED = [path for path in FILES if path.stem.startswith("demonstrations_")]
"""Those with other demonstrations than the task files', of tasks that the others run."""

PARTS = [path for path in FILES if path.stem.startswith("ablations_")]
"""Those that change a part of TiLoIL, on tasks that the others run."""

FAST = (
    "ablations_carlo",
    "ablations_flatworld",
    "ablations_grids",
    "grids",
    "flatworld",
    "carlo_rooms",
    "demonstrations_carlo",
)
"""Those of tasks without MuJoCo."""


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_campaign_names_specs_and_settings_that_there_are(path: Path) -> None:
    (request,) = asked(path)
    assert request.first_seed is not None
    assert all(spec.resolve().parent == ROOT / "specs" for spec in request.specs)
    fast = ROOT / "specs" / "grid_avoid_easy.yaml"  # every setting is tried on one task
    names = {str(variant.settings["algorithm"]) for variant in request.variants}
    assert check([of_specs((fast,), Options(algorithms=tuple(sorted(names))))])[0]


def test_every_task_is_in_one_campaign_or_is_a_twin() -> None:
    whole = [path for path in FILES if path not in (*VARIED, *PARTS)]
    named = [spec.resolve() for path in whole for spec in asked(path)[0].specs]
    assert len(named) == len(set(named))
    left = set((ROOT / "specs").glob("*.yaml")) - set(named)
    assert {path.stem for path in left} == {"sixteen_rooms_prose"}


def campaign(path: Path) -> list[Record]:
    """Made-up records of all that a campaign asks for."""
    (request,) = asked(path)
    found = []
    for spec in request.specs:
        task = read_spec(spec).spec
        for variant in request.variants:
            shown = variant.laid.over(task.demonstrations, spec.parent)
            assert shown.file is None or (spec.parent / shown.file).is_file()
            settings = task.train.override(variant.train)
            found += records(
                [1.0],
                name=task.name,
                algorithm=settings.algorithm,
                overrides=settings.overrides(),
                steps=settings.steps,
                demonstrations=shown.model_dump(mode="json", exclude_none=True),
            )
    return found


def test_the_pages_by_demonstrations_lack_nothing_after_their_campaigns() -> None:
    tasks = read_tasks(ROOT / "specs")
    every = [record for path in VARIED for record in campaign(path)]
    book = Book.of(every, tasks)
    pages = demonstrations.files(book)
    tables = [demonstrations.table_3(book), demonstrations.table_4(book)]
    texts = [pages["figure-6.md"], pages["figure-7.md"], *tables]
    assert all("| Carlo |" in text and "ot run" not in text for text in texts)
    assert len(book.rows) == len(every)  # and no two of them are taken for one
    few = [record for path in VARIED[1:] for record in campaign(path)]
    assert "not run" in demonstrations.table_3(Book.of(few, tasks))


def test_the_pages_of_ablations_lack_nothing_after_their_campaigns() -> None:
    tasks = read_tasks(ROOT / "specs")
    book = Book.of([record for path in PARTS for record in campaign(path)], tasks)
    pages = (ablations.files(book)["figure-4.md"], ablations.table_1(book), ablations.table_2(book))
    for text in pages:
        rows = [line for line in text.splitlines() if line.startswith("| ")][2:]
        assert len(rows) == 3 + 9 + 1 + 5  # FlatWorld, grids, Carlo, robots
        assert not any("not run" in row for row in rows)


@pytest.mark.slow
def test_campaigns_are_found_to_be_without_fault() -> None:
    fast = [path for path in FILES if path.stem in FAST]
    for path in fast:
        (request,) = asked(path)
        experiments, _ = check([request])
        assert len(experiments) == len(request.specs) * len(request.variants)
    usual = 2  # Carlo with its own demonstrations and five seeds, by TiLoIL and GAIL, is in two
    both = [path for path in fast if "carlo" in path.stem]
    apart = sum(len(request.specs) * len(request.variants) for request in requests(both, Options()))
    assert len(check(requests(both, Options()))[0]) == apart - usual

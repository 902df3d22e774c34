"""The sweep files of sweeps/ ask for what there is."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.sweep.made import asked
from tiloilc.sweep import Options, check
from tiloilc.sweep.request import of_specs, requests

FILES = sorted((ROOT / "sweeps").glob("*.yaml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_campaign_names_specs_and_settings_that_there_are(path: Path) -> None:
    (request,) = asked(path)
    assert request.first_seed is not None
    assert all(spec.resolve().parent == ROOT / "specs" for spec in request.specs)
    fast = ROOT / "specs" / "grid_avoid_easy.yaml"  # every setting is tried on one task
    names = {str(variant.settings["algorithm"]) for variant in request.variants}
    assert check([of_specs((fast,), Options(algorithms=tuple(sorted(names))))])[0]


def test_every_task_is_in_one_campaign_or_is_a_twin() -> None:
    named = [spec.resolve() for path in FILES for spec in asked(path)[0].specs]
    assert len(named) == len(set(named))
    left = set((ROOT / "specs").glob("*.yaml")) - set(named)
    assert {path.stem for path in left} == {"sixteen_rooms_prose"}


@pytest.mark.slow
def test_campaigns_are_found_to_be_without_fault() -> None:
    numpy = [path for path in FILES if path.stem != "robots"]
    experiments, _ = check(requests(numpy, Options()))
    variants = sum(len(asked(path)[0].specs) * len(asked(path)[0].variants) for path in numpy)
    assert len(experiments) == variants

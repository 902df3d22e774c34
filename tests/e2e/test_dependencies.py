"""What the package imports, pyproject.toml declares; what it declares, constraints.txt pins."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions, requires
from pathlib import Path

OPTIONAL = {
    "imageio-ffmpeg": "video",
    "minari": "minari",
    "mujoco": "mujoco",
    "onnx": "onnx",
    "stormpy": "verify",
    "ray": "ray",
    "submitit": "slurm",
    "tensorboard": "tensorboard",
    "stable-baselines3": "bench",
    "sbx-rl": "bench",
}
"""Imported where present only, each named by an extra."""

DISTRIBUTIONS = {"sbx": "sbx-rl"}
"""What distributes a module, where that is not installed to tell."""


def normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def names(requirements: list[str]) -> set[str]:
    """The normalised project names of requirement lines."""
    return {normalised(re.match(r"[\w.-]+", line).group()) for line in requirements}  # type: ignore[union-attr]


def third_party(root: Path) -> dict[str, str]:
    """Top-level modules from elsewhere that the package imports, each with one file that does."""
    found: dict[str, str] = {}
    for folder in ("tiloilc", "tasks"):
        for path in sorted((root / folder).rglob("*.py")):
            if "templates" in path.parts:
                continue
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    modules = [alias.name for alias in node.names]
                elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                    modules = [node.module]
                else:
                    continue
                for module in modules:
                    found.setdefault(module.partition(".")[0], str(path.relative_to(root)))
    ours = {"tiloilc", *sys.stdlib_module_names}
    return {module: path for module, path in found.items() if module not in ours}


def test_every_import_is_declared_and_every_dependency_is_imported(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    distributions = packages_distributions()
    imported = {
        normalised(distribution): path
        for module, path in third_party(root).items()
        for distribution in distributions.get(module, [DISTRIBUTIONS.get(module, module)])
    }
    declared = names(project["dependencies"])
    assert {k: v for k, v in imported.items() if k not in declared | OPTIONAL.keys()} == {}
    assert {k: v for k, v in OPTIONAL.items() if k not in names(extras[v])} == {}
    assert declared - imported.keys() == set()


def test_every_dependency_is_pinned_with_what_it_brings_along(root: Path) -> None:
    lines = (root / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert [line for line in pins if not re.fullmatch(r"[\w.-]+==[\w.]+", line)] == []
    pinned = names(pins)
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = names(project["dependencies"])
    for extra in project["optional-dependencies"].values():
        declared |= names(extra)
    assert declared - pinned - {"tiloilc"} == set()
    brought = {
        requirement
        for name in names([*project["dependencies"], *project["optional-dependencies"]["mujoco"]])
        for requirement in names([line for line in requires(name) or [] if ";" not in line])
    }
    assert brought - pinned == set()

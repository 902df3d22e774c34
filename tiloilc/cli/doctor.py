"""`tiloilc doctor`: what is installed, what works, what to do about the rest."""

from __future__ import annotations

import platform
import shutil
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module, metadata
from typing import Annotated

import typer

import tiloilc
from tiloilc.versions import is_broken_mujoco

REQUIRED = {
    "gymnasium": "gymnasium",
    "lark": "lark",
    "networkx": "networkx",
    "numpy": "numpy",
    "pillow": "PIL",
    "pydantic": "pydantic",
    "pygraphviz": "pygraphviz",
    "rich": "rich",
    "ruamel.yaml": "ruamel.yaml",
    "safetensors": "safetensors",
    "scipy": "scipy",
    "torch": "torch",
    "typer": "typer",
}
"""The distributions that tiloilc cannot do without, and the modules that prove them."""

OPTIONAL = {
    "mujoco": ("mujoco", "environments on MuJoCo", "pip install 'tiloilc[mujoco]'"),
    "gymnasium-robotics": (
        "gymnasium_robotics",
        "the robot of the Fetch tasks",
        "pip install 'tiloilc[mujoco]'",
    ),
    "minari": ("minari", "demonstrations as Minari datasets", "pip install 'tiloilc[minari]'"),
    "onnx": ("onnx", "exported policies", "pip install 'tiloilc[onnx]'"),
    "imageio-ffmpeg": (
        "imageio_ffmpeg",
        "films as MP4",
        "pip install 'tiloilc[video]'",
    ),
    "stormpy": (
        "stormpy",
        "exact verification of policies",
        "pip install 'tiloilc[verify]'",
    ),
    "ray": ("ray", "sweeps over many machines", "pip install 'tiloilc[ray]'"),
    "submitit": ("submitit", "sweeps over a Slurm cluster", "pip install 'tiloilc[slurm]'"),
    "tensorboard": (
        "tensorboard",
        "curves while training",
        "pip install 'tiloilc[tensorboard]'",
    ),
}
"""What adds something: the module, what it is for, how to get it."""


@dataclass(frozen=True)
class Finding:
    """One line: `state` is ok, missing, broken, or absent for what is not needed."""

    state: str
    name: str
    about: str = ""
    remedy: str = ""


def command(
    fast: Annotated[
        bool, typer.Option("--fast", help="Look at versions only, import nothing.")
    ] = False,
) -> None:
    """Say what is installed, what works, and what to do.

    Exit with 1 if something that is needed is missing or broken.
    """
    findings = [*_machine(), *_required(fast), *_optional(fast)]
    if not fast:
        findings += [*_drawing(), *_learning()]
    for finding in findings:
        remedy = f"  -> {finding.remedy}" if finding.remedy else ""
        print(f"{finding.state:<8}{finding.name:<20}{finding.about}{remedy}".rstrip())
    if any(finding.state in ("missing", "broken") for finding in findings):
        raise typer.Exit(1)


def _machine() -> Iterator[Finding]:
    yield Finding("ok", "tiloilc", tiloilc.__version__)
    yield Finding("ok", "python", f"{platform.python_version()} on {platform.system()}")


def _required(fast: bool) -> Iterator[Finding]:
    for name, module in REQUIRED.items():
        version = _version(name)
        if version is None:
            yield Finding("missing", name, remedy=f"pip install '{name}'")
        elif problem := "" if fast else _problem(module):
            yield Finding("broken", name, f"{version}: {problem}", f"pip install -U '{name}'")
        else:
            yield Finding("ok", name, version)


def _optional(fast: bool) -> Iterator[Finding]:
    for name, (module, purpose, remedy) in OPTIONAL.items():
        version = _version(name)
        if version is None:
            yield Finding("absent", name, purpose, remedy)
        elif name == "mujoco" and is_broken_mujoco(version):
            about = f"{version}: breaks the environments of Gymnasium-Robotics"
            yield Finding("broken", name, about, "pip install 'mujoco>=3.3,<3.12'")
        elif problem := "" if fast else _problem(module):
            yield Finding("broken", name, f"{version}: {problem}", remedy)
        else:
            yield Finding("ok", name, f"{version}, {purpose}")


def _drawing() -> Iterator[Finding]:
    try:
        from tiloilc.automaton import rendered

        rendered("digraph { a -> b }", "svg")
    except Exception as error:
        yield Finding("broken", "drawing", _words(error), "pip install -U 'pygraphviz>=2'")
    else:
        yield Finding("ok", "drawing", "Graphviz lays out graphs")


def _learning() -> Iterator[Finding]:
    try:
        import torch

        cuda = torch.cuda.get_device_name() if torch.cuda.is_available() else ""
    except Exception:
        return
    yield Finding("ok", "device", f"cuda, {cuda}" if cuda else "cpu")
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    yield Finding(
        "ok" if compiler else "absent",
        "C++ compiler",
        compiler or "lets torch compile the updates",
        "" if compiler else "install g++ or clang",
    )


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _problem(module: str) -> str:
    """Why `module` cannot be imported, empty if it can."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import_module(module)
    except Exception as error:
        return _words(error)
    return ""


def _words(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]

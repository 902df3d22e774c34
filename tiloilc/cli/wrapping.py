"""A task folder for an environment that exists: what `tiloilc init --env` writes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from tiloilc.cli.console import guests
from tiloilc.diag import CompileError

if TYPE_CHECKING:
    from tiloilc.driver.environment import Asked

MOST_NAMES = 8
"""Components that get a name each; of more, all are one vector."""

HORIZON = 200
"""Steps of an episode where the environment does not say."""


def wrapped(name: str, env_id: str) -> dict[str, bytes]:
    """The files of a task in the Gymnasium environment `env_id`, by name.

    Raises CompileError JOB600, JOB602, JOB603 or JOB608 if it cannot be used.
    """
    from tiloilc.driver.environment import source_of
    from tiloilc.plan import importable
    from tiloilc.spec import Environment

    with importable(Path.cwd()), guests():
        asked, horizon = _asked(env_id)
    spec = f"{name}.yaml"
    about = {
        "name": name,
        "env_id": env_id,
        "horizon": str(horizon),
        "spec": spec,
        "environment": f"The environment is\n`{env_id}`; `drive.py` is for an expert of your own.",
        "action": _action(asked),
        **_fields(asked),
    }
    own = source_of(Environment(id=env_id, horizon=1), Path.cwd())
    copied = {} if own is None else {own.relative_to(Path.cwd()).as_posix(): own.read_bytes()}
    return {
        spec: _filled("wrapped.yaml.in", about),
        "drive.py": _filled("drive.py.in", about),
        "README.md": _filled("README.md.in", about),
        **copied,
    }


def _asked(env_id: str) -> tuple[Asked, int]:
    """What the environment says of itself, and how long its episodes are."""
    import gymnasium

    from tiloilc.driver import backbone_findings
    from tiloilc.driver.environment import ask
    from tiloilc.spec import Environment, Settings, examine_text

    document, _, _ = examine_text("name: new\n", "new.yaml")
    try:
        asked = ask(Environment(id=env_id, horizon=1), document)
        if wrong := list(backbone_findings(Settings.model_validate({"steps": 1}), None, asked)):
            raise CompileError(*wrong)
    except CompileError as error:  # there is no file yet that findings could point into
        raise CompileError(
            *(dataclasses.replace(found, span=None) for found in error.diagnostics)
        ) from None
    limit = gymnasium.spec(env_id.rpartition(":")[2]).max_episode_steps
    return asked, limit or HORIZON


def _fields(asked: Asked) -> dict[str, str]:
    """Names for what is observed, the first number among it, and a value in its middle."""
    if asked.fields:
        said = "".join(
            f"# {name}: {start if stop == start + 1 else [start, stop]}\n"
            for name, (start, stop) in asked.fields.items()
        )
        text = f"# fields that the environment publishes:\n{said}"
        (name, (start, stop)), *_ = asked.fields.items()
    elif asked.dimensions <= MOST_NAMES:
        names = "".join(f"  x{i}: {i}\n" for i in range(asked.dimensions))
        text = f"observation:              # names for what is observed\n{names}"
        name, start, stop = "x0", 0, 1
    else:
        text = "observation:              # names for what is observed\n"
        text += f"  x: [0, {asked.dimensions}]\n"
        name, start, stop = "x", 0, asked.dimensions
    first = name if stop == start + 1 else f"{name}[0]"
    middle = float(asked.seen[:, start].mean())
    return {"fields": text, "first": first, "middle": f"{middle:.3g}"}


def _action(asked: Asked) -> str:
    """Some action, as it is written in Python."""
    from gymnasium.spaces import Discrete

    space = asked.action_space
    if isinstance(space, Discrete):
        return str(int(space.start))
    middle = ((space.low + space.high) / 2).tolist()  # type: ignore[attr-defined]  # a Box
    return repr(middle)


def _filled(file: str, about: Mapping[str, str]) -> bytes:
    text = (files("tiloilc.cli") / "templates" / file).read_text(encoding="utf-8")
    return Template(text).substitute(about).encode()

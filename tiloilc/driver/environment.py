"""What the environment itself says: its fields, its size, whether it resets reproducibly."""

from __future__ import annotations

import importlib
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tiloilc.diag import CompileError, Diagnostic, counted, did_you_mean
from tiloilc.foreign import dimensions_of, sized
from tiloilc.plan import importable
from tiloilc.spec import Document, Environment
from tiloilc.versions import is_broken_mujoco

if TYPE_CHECKING:
    import gymnasium
    import numpy as np
    from numpy.typing import NDArray

STEPS = 3
"""How many steps are tried."""

ROBOTICS = ("Fetch", "Hand", "Adroit", "Franka", "PointMaze", "AntMaze")
"""How the ids of Gymnasium-Robotics begin."""

PHYSICS = "pip install 'tiloilc[mujoco]'"
"""What brings MuJoCo and the robots."""


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """The answers. `fields` are [start, stop) of the flat observation of `dimensions` numbers.

    `seen` are a few observations [n, d] of a first episode.
    """

    fields: dict[str, tuple[int, int]]
    dimensions: int
    finite: bool
    reproducible: bool
    observation_space: gymnasium.Space[Any]
    action_space: gymnasium.Space[Any]
    seen: NDArray[np.float32]

    @property
    def discrete(self) -> bool:
        """Whether actions are numbered."""
        from gymnasium.spaces import Discrete

        return isinstance(self.action_space, Discrete)

    @property
    def greatest_entropy(self) -> float:
        """Of a policy, in nats; real actions count as scaled to [-1, 1]."""
        from gymnasium.spaces import Discrete

        if isinstance(self.action_space, Discrete):
            return math.log(int(self.action_space.n))
        return math.prod(self.action_space.shape or (1,)) * math.log(2)


def ask(environment: Environment, document: Document) -> Asked:
    """Make the environment once, try a few steps. Its module may stand beside the task file.

    Raises CompileError JOB600 (cannot be made or used), JOB602 (a space that nothing here learns
    in), JOB603 (a version known to break it).
    """
    from tiloilc.product import is_finite

    span = document.span("environment", "id")
    with importable(document.path.parent), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = _make(environment, document)
        doing = "asking for its spaces"
        try:
            if problem := _unsupported(env):
                raise CompileError(
                    Diagnostic.of("JOB602", span, environment=environment.id, problem=problem)
                )
            seen, acts = env.observation_space, env.action_space
            dimensions, finite = dimensions_of(seen), is_finite(seen, acts)
            doing = "reading observation_fields"
            published = {**_keys(seen), **_published(env, dimensions)}
            doing = "`reset()`"
            reproducible = _reproducible(env)
            doing = "`step()`"
            tried = _tried(env, dimensions)
            return Asked(published, dimensions, finite, reproducible, seen, acts, tried)
        except CompileError:
            raise
        except (Exception, SystemExit) as error:
            raise _cannot(environment, document, f"{doing} fails: {_words(error)}") from error
        finally:
            env.close()


def source_of(environment: Environment, root: Path) -> Path | None:
    """The file in the task's own folder that defines the environment, if it is of the user's."""
    module = environment.id.rpartition(":")[0]
    relative = Path(*module.split(".")) if module else None
    if relative is None:
        return None
    for candidate in (root / relative.with_suffix(".py"), root / relative / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None


def _make(environment: Environment, document: Document) -> gymnasium.Env[Any, Any]:
    import gymnasium

    module, _, name = environment.id.rpartition(":")
    if name.startswith(ROBOTICS):
        _check_mujoco(name, document)
    if module or name.startswith("tiloilc/"):
        _import(module or "tiloilc.tasks", environment, document)
    try:
        gymnasium.spec(name)
    except gymnasium.error.Error as error:
        known = list(gymnasium.registry)
        package = PHYSICS if name.startswith(ROBOTICS) else ""
        if name.startswith(ROBOTICS) and not module:
            package = "write `gymnasium_robotics:" + name + "`"
        help = did_you_mean(name, known) or package or "own environments: `module:Id-v0`"
        raise _cannot(environment, document, _words(error), help=package or help) from None
    try:
        return gymnasium.make(name, disable_env_checker=True, **environment.kwargs)
    except gymnasium.error.DependencyNotInstalled as error:
        help = PHYSICS if name.startswith("tiloilc/") else ""
        raise _cannot(environment, document, _words(error), help=help) from error
    except (Exception, SystemExit) as error:
        raise _cannot(environment, document, _words(error), at_kwargs=True) from error


def _check_mujoco(name: str, document: Document) -> None:
    try:
        version = metadata.version("mujoco")
    except metadata.PackageNotFoundError:
        return
    if is_broken_mujoco(version):
        raise CompileError(
            Diagnostic.of(
                "JOB603",
                document.span("environment", "id"),
                package="mujoco",
                version=version,
                help="pip install 'mujoco>=3.3,<3.12'",
            )
        )


def _import(module: str, environment: Environment, document: Document) -> None:
    try:
        importlib.import_module(module)
    except (Exception, SystemExit) as error:
        problem = f"`import {module}` fails: {_words(error)}"
        help = "the module must be installed or stand beside the task file"
        raise _cannot(environment, document, problem, help=help) from error


def _cannot(
    environment: Environment,
    document: Document,
    problem: str,
    *,
    help: str = "",
    at_kwargs: bool = False,
) -> CompileError:
    at_kwargs = at_kwargs and document.has("environment", "kwargs") and bool(environment.kwargs)
    span = document.key_span("environment", "kwargs") if at_kwargs else None
    span = span or document.span("environment", "id")
    return CompileError(
        Diagnostic.of("JOB600", span, help=help, environment=environment.id, problem=problem)
    )


def _words(error: BaseException) -> str:
    """The first line of what an exception says."""
    if isinstance(error, SystemExit):
        return "it ends the program"
    if isinstance(error, KeyError):
        return f"KeyError: {error}"
    lines = str(error).partition(" was raised from the environment creator")[0].splitlines()
    return lines[0].strip().rstrip(".") if lines else type(error).__name__


def _unsupported(env: gymnasium.Env[Any, Any]) -> str:
    from gymnasium import spaces

    plain = (spaces.Box, spaces.Discrete, spaces.MultiDiscrete, spaces.MultiBinary)
    seen, acts = env.observation_space, env.action_space
    parts = seen.spaces if isinstance(seen, spaces.Dict) else {"": seen}
    for key, part in parts.items():
        if not isinstance(part, plain):
            at = f" under `{key}`" if key else ""
            return f"observations that are no flat numbers ({type(part).__name__}{at})"
    if not dimensions_of(seen):
        return "observations without a number in them"
    if isinstance(acts, spaces.Discrete):
        return ""
    if not isinstance(acts, spaces.Box):
        return f"{type(acts).__name__} actions"
    if not acts.is_bounded():
        return "unbounded actions"
    return "" if (acts.low < acts.high).all() and acts.low.size else "actions that cannot vary"


def _keys(space: gymnasium.Space[Any]) -> dict[str, tuple[int, int]]:
    """The keys of a Dict observation, in the order of `gymnasium.spaces.utils.flatten`."""
    from gymnasium import spaces

    if not isinstance(space, spaces.Dict):
        return {}
    fields, start = {}, 0
    for key, part in space.spaces.items():
        fields[key] = (start, start + spaces.flatdim(part))
        start = fields[key][1]
    return fields


def _published(env: gymnasium.Env[Any, Any], dimensions: int) -> dict[str, tuple[int, int]]:
    published: Mapping[str, slice | int] = getattr(env.unwrapped, "observation_fields", {})
    if not isinstance(published, Mapping):
        raise TypeError("it is no dict of names and slices")
    fields = {}
    for name, where in published.items():
        if isinstance(where, slice):
            start, stop, _ = where.indices(dimensions)
        else:
            start, stop = int(where), int(where) + 1
        if not 0 <= start < stop <= dimensions:
            raise ValueError(f"`{name}` is outside the {counted(dimensions, 'component')}")
        fields[name] = (start, stop)
    return fields


def _tried(env: gymnasium.Env[Any, Any], dimensions: int) -> NDArray[np.float32]:
    """The observations [n, d] of a few random steps. Raises whatever the environment raises."""
    import numpy as np

    space = env.observation_space
    env.action_space.seed(7)
    rows = [sized(space, env.reset(seed=7)[0], dimensions)]
    for _ in range(STEPS):
        observation, _, terminated, truncated, _ = env.step(env.action_space.sample())
        rows.append(sized(space, observation, dimensions))
        if terminated or truncated:
            break
    return np.stack(rows)


def _reproducible(env: gymnasium.Env[Any, Any]) -> bool:
    import numpy as np
    from gymnasium.spaces.utils import flatten

    seen = [flatten(env.observation_space, env.reset(seed=7)[0]) for _ in range(2)]
    first, second = (np.asarray(observation, dtype=np.float64) for observation in seen)
    return bool(np.array_equal(first, second, equal_nan=True))

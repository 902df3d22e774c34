"""Demonstrations as Minari datasets (https://minari.farama.org), read and written.

The package `minari` comes with the extra of that name. Datasets are those on this machine: nothing
is downloaded. Observations of a dictionary are flattened as Gymnasium flattens them.
"""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from tiloilc.demos.files import SCHEMA_VERSION, Damaged, check_actions, checked_observations
from tiloilc.demos.model import Actions, Demo, DemoSet, Floats
from tiloilc.diag import CompileError, Diagnostic, Span, did_you_mean

if TYPE_CHECKING:
    import gymnasium

INSTALL = "pip install 'tiloilc[minari]'"

NAME = re.compile(r"(?:[-\w][-\w/]*[-\w]/)?[-\w]+-v\d+")
"""Minari looks at names late: a malformed one leaves a folder that it stumbles over ever after."""

ABOUT = "tiloilc_demonstrations"
"""The key of a dataset's metadata that holds our sidecar."""


def from_minari(name: str, span: Span | None = None) -> DemoSet:
    """The episodes of the local dataset `name`. Actions that are all nan are none.

    Raises CompileError DEMO500, at `span`, if there is no such dataset or it cannot be read.
    """
    if not NAME.fullmatch(name):
        raise _unreadable(name, "a dataset's id is `name-v0` or `namespace/name-v0`", span)
    try:
        with _quiet():
            import minari

            there = sorted(minari.list_local_datasets())
            if name not in there:
                help = did_you_mean(name, there) or f"minari download {name}"
                raise _unreadable(name, "there is no such dataset on this machine", span, help)
            dataset = minari.load_dataset(name)
            space = dataset.observation_space
            episodes = tuple(
                _episode(e.observations, e.actions, space, i)
                for i, e in enumerate(dataset.iterate_episodes())
            )
            meta = _meta(dataset, [demo.steps for demo in episodes])
    except ImportError as error:
        problem = f"the package `{_package(error)}` is not installed"
        raise _unreadable(name, problem, span, INSTALL) from None
    except Damaged as damage:
        raise _unreadable(name, str(damage), span) from None
    except (OSError, ValueError, KeyError) as error:
        problem = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise _unreadable(name, problem, span) from None
    return DemoSet(episodes, meta)


def to_minari(name: str, demos: DemoSet) -> None:
    """Write `demos` as the new local dataset `name`, with the spaces of their environment.

    Where the sidecar names no environment that can be made here, spaces are unbounded boxes. An
    episode without actions gets nan, as Minari has no episode without. Raises CompileError DEMO510
    if the name is malformed or taken, or the package is missing.
    """
    if not NAME.fullmatch(name):
        raise _unwritable(name, "a dataset's id is `name-v0` or `namespace/name-v0`")
    if not len(demos):
        raise _unwritable(name, "there are no episodes")
    try:
        with _quiet():
            import minari
            from minari.data_collector import EpisodeBuffer

            if name in minari.list_local_datasets():
                raise _unwritable(name, "it is there already", f"minari delete {name}")
            env = _environment(demos)
            spaces = _spaces(env, demos)
            seeds = demos.meta.get("seeds") or [None] * len(demos)
            buffers = [
                EpisodeBuffer(
                    id=i,
                    seed=seeds[i],
                    observations=_structured(demo.observations, spaces[0]),
                    actions=_actions(demo, spaces[1]),
                    rewards=[0.0] * demo.steps,
                    terminations=[False] * demo.steps,
                    truncations=[False] * (demo.steps - 1) + [True],
                )
                for i, demo in enumerate(demos.episodes)
                if demo.steps
            ]
            dataset = minari.create_dataset_from_buffers(
                name,
                buffers,
                env=env,
                observation_space=spaces[0],
                action_space=spaces[1],
                algorithm_name=str(demos.meta.get("expert") or "demonstrations"),
            )
            about = json.dumps(dict(demos.meta), sort_keys=True)
            dataset.storage.update_metadata({ABOUT: about})
    except ImportError as error:
        problem = f"the package `{_package(error)}` is not installed"
        raise _unwritable(name, problem, INSTALL) from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Minari warns of every field of a dataset's description that is left empty."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _package(error: ImportError) -> str:
    """What is missing; Minari says it of its own extras in words only."""
    return error.name or "h5py"


def _episode(observations: Any, actions: Any, space: gymnasium.Space[Any], index: int) -> Demo:
    states = checked_observations(_flat(observations, space), f"observations of episode {index}")
    if not isinstance(actions, np.ndarray) or _unknown(actions):
        return Demo(states)
    check_actions(actions, len(states) - 1, index)
    return Demo(states, actions)


def _unknown(actions: Actions) -> bool:
    floating = np.issubdtype(actions.dtype, np.floating)
    return bool(floating and np.isnan(actions.astype(np.float64)).all())


def _flat(observations: Any, space: gymnasium.Space[Any]) -> Floats:
    """Stacked observations, perhaps of a dictionary, as [T+1, d]."""
    from gymnasium import spaces

    if isinstance(space, spaces.Dict):
        return np.concatenate(
            [_flat(observations[key], part) for key, part in space.spaces.items()], axis=1
        )
    if isinstance(space, spaces.Tuple):
        parts = zip(observations, space.spaces, strict=True)
        return np.concatenate([_flat(seen, part) for seen, part in parts], axis=1)
    rows = np.asarray(observations)
    if rows.dtype.kind not in "biuf":
        raise Damaged("its observations are no numbers")
    return rows.astype(np.float32).reshape(len(rows), -1)


def _structured(observations: Floats, space: gymnasium.Space[Any]) -> Any:
    """[T+1, d] as the environment gives them, stacked: the inverse of `_flat`."""
    from gymnasium import spaces

    if isinstance(space, spaces.Dict):
        parts, start = {}, 0
        for key, part in space.spaces.items():
            stop = start + spaces.flatdim(part)
            parts[key] = _structured(observations[:, start:stop], part)
            start = stop
        return parts
    rows = observations.reshape(len(observations), *(space.shape or ()))
    return rows.astype(space.dtype)


def _actions(demo: Demo, space: gymnasium.Space[Any]) -> Actions:
    shape = (demo.steps, *(space.shape or ()))
    if demo.actions is None:
        return np.full(shape, np.nan, space.dtype)
    return demo.actions.reshape(shape).astype(space.dtype)


def _environment(demos: DemoSet) -> gymnasium.Env[Any, Any] | None:
    """The environment that the sidecar names, if it can be made here."""
    import gymnasium

    made = demos.meta.get("environment")
    if not isinstance(made, dict) or not isinstance(made.get("id"), str):
        return None
    try:
        import tiloilc.tasks  # noqa: F401  # registers the environments

        return gymnasium.make(made["id"], disable_env_checker=True, **(made.get("kwargs") or {}))
    except Exception:  # an environment is anyone's code, and may not be installed
        return None


def _spaces(
    env: gymnasium.Env[Any, Any] | None, demos: DemoSet
) -> tuple[gymnasium.Space[Any], gymnasium.Space[Any]]:
    from gymnasium import spaces

    seen: gymnasium.Space[Any] = spaces.Box(-np.inf, np.inf, (demos.dimensions,), np.float32)
    first = demos.episodes[0].actions
    shape = (1,) if first is None or not demos.has_actions else first.shape[1:]
    acts: gymnasium.Space[Any] = spaces.Box(-np.inf, np.inf, shape, np.float32)
    if env is not None:
        seen = env.observation_space
        acts = env.action_space if demos.has_actions else acts
    return seen, acts


def _meta(dataset: Any, steps: list[int]) -> dict[str, Any]:
    """The sidecar that was written with the dataset, or what the dataset itself tells."""
    ours = dataset.storage.metadata.get(ABOUT)
    meta: dict[str, Any] = json.loads(ours) if isinstance(ours, str) else {}
    spec = dataset.env_spec
    if "environment" not in meta and spec is not None:
        kwargs = {k: v for k, v in spec.kwargs.items() if k != "render_mode"}
        meta["environment"] = {"id": spec.id, "kwargs": kwargs}
    return {**meta, "schema_version": SCHEMA_VERSION, "steps": steps}


def _unreadable(name: str, problem: str, span: Span | None, help: str = "") -> CompileError:
    return CompileError(Diagnostic.of("DEMO500", span, path=name, problem=problem, help=help))


def _unwritable(name: str, problem: str, help: str = "") -> CompileError:
    return CompileError(Diagnostic.of("DEMO510", name=name, problem=problem, help=help))

"""Demonstrations as files: an .npz without pickles, and a JSON sidecar beside it.

The archive has `observations_0`, `observations_1`, … (float32 [T+1, d]) and, if known, `actions_0`,
… ([T, …]). An archive with a single `observations` [k, T+1, d] or [T+1, d], as one would write by
hand, is read too, and so is one without a sidecar. Equal values give equal bytes.
"""

from __future__ import annotations

import json
import zipfile
import zlib
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from tiloilc.demos.model import Actions, Demo, DemoSet, Floats
from tiloilc.diag import CompileError, Diagnostic, Span
from tiloilc.writing import write_file

SCHEMA_VERSION = 1

MAX_BYTES = 2 << 30
"""An archive that unpacks to more is refused: it could only be a mistake or an attack."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest time a zip archive can name; it stands for no time at all."""


NAMES_SHOWN = 4
"""Of more arrays than these, a help line names the first."""


class Damaged(Exception):
    """What is wrong with stored demonstrations, in words, and what to do about it."""

    def __init__(self, problem: str, help: str = "") -> None:
        super().__init__(problem)
        self.help = help


def save(path: Path | str, demos: DemoSet) -> None:
    """Write `path` (.npz) and its sidecar, each in one step so that no half file is ever seen.

    The sidecar holds `demos.meta` with the schema version and the steps of each episode.
    """
    path = Path(path)
    assert path.suffix != ".json", "the sidecar would take the archive's place"
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_STORED) as bundle:
        for i, demo in enumerate(demos.episodes):
            _add(bundle, f"observations_{i}", demo.observations.astype(np.float32))
        for i, demo in enumerate(demos.episodes):
            if demo.actions is not None:
                _add(bundle, f"actions_{i}", demo.actions)
    meta = {
        **demos.meta,
        "schema_version": SCHEMA_VERSION,
        "steps": [demo.steps for demo in demos.episodes],
    }
    text = json.dumps(meta, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    write_file(path, archive.getvalue())
    write_file(path.with_suffix(".json"), text)


def foreign_sidecar(path: Path) -> Path | None:
    """The file where the sidecar of `path` goes, if there is one that is no sidecar."""
    sidecar = path.with_suffix(".json")
    try:
        meta = json.loads(sidecar.read_bytes())
    except FileNotFoundError:
        return None
    except (ValueError, RecursionError):
        return sidecar
    return None if isinstance(meta, dict) and {"schema_version", "steps"} <= set(meta) else sidecar


def load(path: Path | str, span: Span | None = None) -> DemoSet:
    """Read demonstrations. Raises CompileError DEMO500, at `span`, if they cannot be read."""
    path = Path(path)
    try:
        arrays = _arrays(path)
        episodes = _episodes(arrays)
        meta = _sidecar(path.with_suffix(".json"), len(episodes))
    except (Damaged, OSError) as damage:
        problem = damage.strerror if isinstance(damage, OSError) else str(damage)
        problem = problem or type(damage).__name__
        help = damage.help if isinstance(damage, Damaged) else ""
        raise CompileError(
            Diagnostic.of("DEMO500", span, path=path.as_posix(), problem=problem, help=help)
        ) from None
    return DemoSet(episodes, meta)


def _add(bundle: zipfile.ZipFile, name: str, array: npt.NDArray[np.generic]) -> None:
    member = zipfile.ZipInfo(f"{name}.npy", date_time=_EPOCH)
    member.external_attr = 0o644 << 16
    member.create_system = 3
    content = BytesIO()
    np.lib.format.write_array(
        content, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False
    )
    bundle.writestr(member, content.getvalue())


def _arrays(path: Path) -> dict[str, npt.NDArray[np.generic]]:
    try:
        with zipfile.ZipFile(path) as bundle:
            members = bundle.infolist()
            if sum(member.file_size for member in members) > MAX_BYTES:
                raise Damaged("it unpacks to more than 2 GiB")
            arrays = {}
            for member in members:
                with bundle.open(member) as stream:
                    name = member.filename.removesuffix(".npy")
                    arrays[name] = _array(stream, name, member.file_size)
            return arrays
    except zipfile.BadZipFile:
        raise Damaged("it is not a whole .npz archive") from None
    except (zlib.error, EOFError, RuntimeError, NotImplementedError, UnicodeError):
        raise Damaged("its archive is damaged") from None


def _array(stream: IO[bytes], name: str, size: int) -> npt.NDArray[np.generic]:
    """One array; its header is believed only if it fits the member's size."""
    try:
        version = np.lib.format.read_magic(stream)
        if version == (1, 0):
            shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream)
        elif version == (2, 0):
            shape, fortran, dtype = np.lib.format.read_array_header_2_0(stream)
        else:
            raise Damaged(f"`{name}` has an unknown array format")
    except ValueError:
        raise Damaged(f"`{name}` is not an array") from None
    if dtype.hasobject or dtype.kind not in "biuf":
        raise Damaged(f"`{name}` does not hold numbers")
    count = 1
    for length in shape:
        count *= length
    if count * dtype.itemsize > size:
        raise Damaged(f"`{name}` is cut off")
    content = stream.read()
    if len(content) != count * dtype.itemsize:
        raise Damaged(f"`{name}` is cut off")
    array = np.frombuffer(content, dtype)
    return array.reshape(shape, order="F" if fortran else "C").copy()


def _episodes(arrays: dict[str, npt.NDArray[np.generic]]) -> tuple[Demo, ...]:
    if "observations" in arrays:
        arrays = _split(arrays)
    if "observations_0" not in arrays:
        raise Damaged("it has no `observations_0`", _naming(list(arrays)))
    count = sum(name.startswith("observations_") for name in arrays)
    episodes = []
    for i in range(count):
        if f"observations_{i}" not in arrays:
            raise Damaged(f"it has {count} episodes, but no `observations_{i}`")
        observations = checked_observations(arrays[f"observations_{i}"], f"observations_{i}")
        actions = arrays.get(f"actions_{i}")
        if actions is not None:
            check_actions(actions, len(observations) - 1, i)
        episodes.append(Demo(observations, actions))
    sizes = sorted({demo.observations.shape[1] for demo in episodes})
    if len(sizes) > 1:
        raise Damaged(f"its episodes have different numbers of components: {sizes}")
    return tuple(episodes)


def _naming(names: Sequence[str]) -> str:
    """How arrays are called, where these `names` were found."""
    more = ", …" if len(names) > NAMES_SHOWN else ""
    found = ", ".join(f"`{name}`" for name in names[:NAMES_SHOWN]) + more
    wanted = "`observations_0`, `observations_1`, … (and `actions_0`, …)"
    return f"it has {found or 'no arrays'}: call them {wanted}, one for each episode"


def _split(arrays: dict[str, npt.NDArray[np.generic]]) -> dict[str, npt.NDArray[np.generic]]:
    """Equally long episodes in one array, as one array each."""
    split: dict[str, npt.NDArray[np.generic]] = {}
    single = arrays["observations"].ndim == 2
    for name in ("observations", "actions"):
        if name in arrays:
            rows = arrays[name][None] if single else arrays[name]
            if rows.ndim == 0:
                raise Damaged(f"`{name}` is a single number")
            split |= {f"{name}_{i}": row for i, row in enumerate(rows)}
    return split


def checked_observations(array: npt.NDArray[np.generic], name: str) -> Floats:
    """Observations [T+1, d] as they are kept. Raises Damaged if `array` is none of them."""
    if array.ndim != 2 or 0 in array.shape:
        raise Damaged(f"`{name}` has shape {list(array.shape)}, not [T+1, d]")
    with np.errstate(over="ignore"):
        observations = array.astype(np.float32)
    if not np.isfinite(observations).all():
        raise Damaged(f"`{name}` has entries that are not finite numbers")
    return observations


def check_actions(actions: Actions, steps: int, index: int) -> None:
    """Raises Damaged if `actions` are not those of episode `index`, of `steps` steps."""
    if actions.ndim == 0 or len(actions) != steps:
        given = 0 if actions.ndim == 0 else len(actions)
        raise Damaged(f"`actions_{index}` has {given} actions for {steps} steps")
    if not np.isfinite(actions.astype(np.float64)).all():
        raise Damaged(f"`actions_{index}` has entries that are not finite numbers")


def _sidecar(path: Path, episodes: int) -> dict[str, Any]:
    try:
        meta = json.loads(path.read_bytes())
    except FileNotFoundError:
        return {"schema_version": SCHEMA_VERSION}
    except (ValueError, RecursionError):
        raise Damaged(f"its sidecar {path.name} is not JSON") from None
    if not isinstance(meta, dict):
        raise Damaged(f"its sidecar {path.name} is not a JSON object")
    version = meta.get("schema_version")
    if version != SCHEMA_VERSION:
        raise Damaged(f"its sidecar has schema version {version}, not {SCHEMA_VERSION}")
    steps = meta.get("steps")
    if isinstance(steps, list) and len(steps) != episodes:
        raise Damaged(f"its sidecar is of {len(steps)} episodes, the archive has {episodes}")
    return meta

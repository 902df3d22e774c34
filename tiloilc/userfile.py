"""Python files of the user's own, which a task file or a command names."""

from __future__ import annotations

import hashlib
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from tiloilc.diag import did_you_mean


class Unusable(Exception):
    """Why a file cannot be used."""


def run_file(path: Path) -> ModuleType:
    """Execute the file, whose suffix is `.py`. Raises Unusable if it is not there or fails."""
    if not path.is_file():
        raise Unusable("there is no such file")
    resolved = str(path.resolve())
    unique = f"tiloilc_userfile_{hashlib.sha256(resolved.encode()).hexdigest()[:16]}"
    spec = spec_from_file_location(unique, resolved)
    assert spec is not None, "the suffix is .py"
    assert spec.loader is not None, "the suffix is .py"
    module = module_from_spec(spec)
    sys.modules[unique] = module  # dataclasses in the file look themselves up here
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise Unusable(f"the file fails with {named(error)}") from error
    return module


def meant(module: ModuleType, name: str) -> str:
    """Which of the file's functions may be meant by `name`, which it does not have."""
    names = [n for n, v in vars(module).items() if callable(v) and not n.startswith("_")]
    return did_you_mean(name, names, listed="in the file")


def named(error: BaseException) -> str:
    """An error of the user's code, in a few words."""
    return f"{type(error).__name__}: {error}"

"""Predicates in Python: one function of one file that the user names."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic, SourceText, did_you_mean
from tiloilc.label.functions import Array

EXAMPLE = 'write it as python: "file.py:function"'


def python_predicate(reference: SourceText) -> Callable[[Array], NDArray[np.bool_]]:
    """The function that `file.py:function` names, observations [n, d] to truth values [n].

    The file is executed once. Raises CompileError SPEC117 if it cannot be used; the function
    itself raises it when it fails or returns something else.
    """
    path, _, name = reference.value.rpartition(":")
    if not path.endswith(".py") or not name.isidentifier():
        raise _unusable(reference, "it is not `file.py:function`", EXAMPLE)
    function = _load(reference, Path(path), name)

    def test(observations: Array) -> NDArray[np.bool_]:
        shown = observations.view()
        shown.flags.writeable = False  # the next predicate sees the same array
        try:
            result = np.asarray(function(shown))
        except (Exception, SystemExit) as error:
            problem = f"it raised {type(error).__name__}: {error}"
            raise _unusable(reference, problem) from error
        wanted = observations.shape[:1]
        if result.dtype != np.bool_ or result.shape != wanted:
            given = f"{result.dtype} {list(result.shape)}"
            problem = f"it returned {given} for observations {list(observations.shape)}"
            raise _unusable(reference, problem, f"return a bool array {list(wanted)}")
        return result

    return test


def _load(reference: SourceText, path: Path, name: str) -> Callable[[Array], object]:
    if not path.is_file():
        raise _unusable(reference, "there is no such file")
    resolved = str(path.resolve())
    unique = f"tiloilc_predicates_{hashlib.sha256(resolved.encode()).hexdigest()[:16]}"
    spec = spec_from_file_location(unique, resolved)
    assert spec is not None, "the suffix is .py"
    assert spec.loader is not None, "the suffix is .py"
    module = module_from_spec(spec)
    sys.modules[unique] = module  # dataclasses in the file look themselves up here
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        problem = f"the file fails with {type(error).__name__}: {error}"
        raise _unusable(reference, problem) from error
    function: object = getattr(module, name, None)
    if function is None:
        names = [n for n, v in vars(module).items() if callable(v) and not n.startswith("_")]
        help = did_you_mean(name, names, listed="in the file")
        raise _unusable(reference, f"the file has no `{name}`", help)
    if not callable(function):
        raise _unusable(reference, f"`{name}` is not a function")
    return function


def _unusable(reference: SourceText, problem: str, help: str = "") -> CompileError:
    span = None if reference.file.startswith("<") else reference.span()
    name = reference.value
    return CompileError(Diagnostic.of("SPEC117", span, reference=name, problem=problem, help=help))

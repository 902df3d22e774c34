"""Predicates in Python: one function of one file that the user names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tiloilc.diag import CompileError, Diagnostic, SourceText
from tiloilc.label.functions import Array
from tiloilc.userfile import Unusable, meant, named, run_file

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
            raise _unusable(reference, f"it raised {named(error)}") from error
        wanted = observations.shape[:1]
        if result.dtype != np.bool_ or result.shape != wanted:
            given = f"{result.dtype} {list(result.shape)}"
            problem = f"it returned {given} for observations {list(observations.shape)}"
            raise _unusable(reference, problem, f"return a bool array {list(wanted)}")
        return result

    return test


def _load(reference: SourceText, path: Path, name: str) -> Callable[[Array], object]:
    try:
        module = run_file(path)
    except Unusable as error:
        raise _unusable(reference, str(error)) from error
    function: object = getattr(module, name, None)
    if function is None:
        raise _unusable(reference, f"the file has no `{name}`", meant(module, name))
    if not callable(function):
        raise _unusable(reference, f"`{name}` is not a function")
    return function


def _unusable(reference: SourceText, problem: str, help: str = "") -> CompileError:
    span = None if reference.file.startswith("<") else reference.span()
    name = reference.value
    return CompileError(Diagnostic.of("SPEC117", span, reference=name, problem=problem, help=help))

"""The functions of the predicate language: how many arguments, of which kinds, and what they do.

A kind is a number of components: 0 is a truth value, 1 a number, 2 and more a vector. At run time a
truth value and a number are arrays [...] and a vector is an array [..., components], where the
leading axes are those of the observations, or none for constants.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
"""Truth values or float64, as its kind says."""

Kind = int

TRUTH: Kind = 0
NUMBER: Kind = 1


def describe(kind: Kind) -> str:
    """A kind in words."""
    return {TRUTH: "a truth value", NUMBER: "a number"}.get(kind, f"a vector of {kind}")


def fit(array: Array, kind: Kind, wanted: Kind) -> Array:
    """A number as a vector of any size, by a last axis of one component."""
    return array[..., None] if kind == NUMBER and wanted > NUMBER else array


def as_vector(array: Array, kind: Kind) -> Array:
    """A number as a vector of one component; vectors as they are."""
    return array[..., None] if kind == NUMBER else array


@dataclass(frozen=True, slots=True)
class Function:
    """One function. `most` None: any number of arguments.

    `same` are the arguments that must have the size of the first, `bounds` those that may also be
    a number, `numbers` those that must be one; all others go together if each is a number or a
    vector of one size. `result` is the kind of the value, None: that of the arguments.
    """

    least: int
    most: int | None
    run: Callable[[Sequence[Array], Sequence[Kind]], Array]
    result: Kind | None = None
    same: tuple[int, ...] = ()
    bounds: tuple[int, ...] = ()
    numbers: tuple[int, ...] = ()

    @property
    def takes(self) -> str:
        """How many arguments, in words."""
        if self.most is None:
            return f"at least {self.least} argument{'s' * (self.least > 1)}"
        return f"{self.least} argument{'s' * (self.least > 1)}"


@dataclass(frozen=True, slots=True)
class Misfit:
    """The argument that does not go with the others, and why."""

    position: int
    problem: str


def common_kind(name: str, function: Function, kinds: Sequence[Kind]) -> Kind | Misfit:
    """The size of the arguments together: numbers go with everything, unless they must not."""
    common = kinds[0]
    for position, kind in enumerate(kinds):
        if position in function.numbers:
            if kind != NUMBER:
                return Misfit(position, f"`{name}` needs a number here, not {describe(kind)}")
            continue
        if position in function.same and kind != kinds[0]:
            pair = f"{describe(kinds[0])} and {describe(kind)}"
            return Misfit(position, f"`{name}` needs two of the same size, not {pair}")
        if position in function.bounds and kind not in (NUMBER, kinds[0]):
            pair = f"{describe(kinds[0])} against {describe(kind)}"
            return Misfit(position, f"`{name}` tests {pair}")
        if kind != common and NUMBER not in (kind, common):
            pair = f"{describe(common)} and {describe(kind)}"
            return Misfit(position, f"{pair} do not fit together")
        common = max(common, kind)
    return common


def _each(operation: Callable[[Array], Array]) -> Function:
    """A function of each component by itself."""
    return Function(1, 1, lambda arrays, kinds: operation(arrays[0]))


def _pairwise(operation: Callable[[Array, Array], Array], most: int | None = 2) -> Function:
    def run(arrays: Sequence[Array], kinds: Sequence[Kind]) -> Array:
        wanted = max(kinds)
        fitted = [fit(a, k, wanted) for a, k in zip(arrays, kinds, strict=True)]
        return reduce(operation, fitted)

    return Function(2, most, run)


def wrap(angle: Array) -> Array:
    """An angle in radians brought into (-pi, pi]."""
    return np.asarray(np.pi - np.mod(np.pi - angle, 2 * np.pi))


def norm(vector: Array) -> Array:
    """Euclidean length over the last axis."""
    return np.asarray(np.sqrt(np.add.reduce(vector * vector, axis=-1)))


def _norm(arrays: Sequence[Array], kinds: Sequence[Kind]) -> Array:
    return np.abs(arrays[0]) if kinds[0] == NUMBER else norm(arrays[0])


def _dist(arrays: Sequence[Array], kinds: Sequence[Kind]) -> Array:
    return _norm([arrays[0] - arrays[1]], kinds)


def _dot(arrays: Sequence[Array], kinds: Sequence[Kind]) -> Array:
    product = as_vector(arrays[0] * arrays[1], kinds[0])
    return np.asarray(np.sum(product, axis=-1))


def _in_box(arrays: Sequence[Array], kinds: Sequence[Kind]) -> Array:
    point, low, high = (fit(a, k, kinds[0]) for a, k in zip(arrays, kinds, strict=True))
    inside = (low <= point) & (point <= high)
    return np.asarray(np.all(as_vector(inside, kinds[0]), axis=-1))


def _in_ball(arrays: Sequence[Array], kinds: Sequence[Kind]) -> Array:
    return np.asarray(_dist(arrays[:2], kinds[:2]) <= arrays[2])


def _extreme(operation: np.ufunc) -> Function:
    """min and max: over the components of one vector, or pairwise over several arguments."""
    pairwise = _pairwise(lambda a, b: np.asarray(operation(a, b)), most=None)

    def run(arrays: Sequence[Array], kinds: Sequence[Kind]) -> Array:
        if len(arrays) == 1:
            return np.asarray(operation.reduce(as_vector(arrays[0], kinds[0]), axis=-1))
        return pairwise.run(arrays, kinds)

    return Function(1, None, run)


FUNCTIONS = MappingProxyType(
    {
        "abs": _each(lambda a: np.asarray(np.abs(a))),
        "min": _extreme(np.minimum),
        "max": _extreme(np.maximum),
        "sqrt": _each(lambda a: np.asarray(np.sqrt(a))),
        "sin": _each(lambda a: np.asarray(np.sin(a))),
        "cos": _each(lambda a: np.asarray(np.cos(a))),
        "tan": _each(lambda a: np.asarray(np.tan(a))),
        "atan2": _pairwise(lambda a, b: np.asarray(np.arctan2(a, b))),
        "hypot": _pairwise(lambda a, b: np.asarray(np.hypot(a, b))),
        "norm": Function(1, 1, _norm, result=NUMBER),
        "dot": Function(2, 2, _dot, result=NUMBER, same=(1,)),
        "dist": Function(2, 2, _dist, result=NUMBER, same=(1,)),
        "wrap": _each(wrap),
        "in_box": Function(3, 3, _in_box, result=TRUTH, bounds=(1, 2)),
        "in_ball": Function(3, 3, _in_ball, result=TRUTH, same=(1,), numbers=(2,)),
    }
)
"""All functions by name. Boxes and balls contain their boundary; NaN is in none."""

CONSTANTS = MappingProxyType({"pi": float(np.pi)})
"""Named numbers; a field of the same name wins."""

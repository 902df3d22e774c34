"""Products are those of double precision, whatever the sizes, strides and the way to them."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor
from torch._inductor import config
from torch._inductor.cpu_vec_isa import pick_vec_isa

from tests.learn.examples import COMPILER
from tiloilc.learn.engine import products
from tiloilc.learn.engine.program import Program

SIZES = [
    (1, 1, 1, 1),
    (2, 64, 256, 256),
    (10, 64, 64, 64),
    (3, 7, 5, 37),
    (2, 13, 40, 31),
    (1, 6, 3, 32),
    (1, 8, 3, 32),
    (2, 9, 4, 64),
    (3, 24, 7, 70),
    (4, 5, 1, 8),
    (2, 64, 33, 65),
    (1, 0, 3, 4),
    (1, 3, 0, 4),
]
"""stack, rows, depth, columns: around what a tile and a vector hold, and far from it."""


def straight(stack: int, rows: int, columns: int) -> Tensor:
    return torch.randn(stack, rows, columns)


def turned(stack: int, rows: int, columns: int) -> Tensor:
    return torch.randn(stack, columns, rows).transpose(1, 2)


def part(stack: int, rows: int, columns: int) -> Tensor:
    """Neither beginning where its memory does nor without gaps."""
    return torch.randn(stack, rows + 2, columns + 3)[:, 2:, 1 : columns + 1]


def turned_part(stack: int, rows: int, columns: int) -> Tensor:
    return part(stack, columns, rows).transpose(1, 2)


def spread(stack: int, rows: int, columns: int) -> Tensor:
    """One matrix for the whole stack, every second of its columns."""
    return torch.randn(1, rows, 2 * columns)[:, :, ::2].expand(stack, rows, columns)


LAYOUTS = [straight, turned, part, turned_part, spread]


@pytest.fixture(scope="module")
def operator() -> Callable[[Tensor, Tensor], Tensor]:
    if COMPILER is None or "avx512" not in str(pick_vec_isa()):
        pytest.skip("no C++ compiler, or no AVX-512")
    products.build()
    return torch.ops.tiloilc.product.default


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("right", LAYOUTS)
@pytest.mark.parametrize("left", LAYOUTS)
def test_the_operator_multiplies(
    left: Callable[[int, int, int], Tensor],
    right: Callable[[int, int, int], Tensor],
    size: tuple[int, int, int, int],
    operator: Callable[[Tensor, Tensor], Tensor],
) -> None:
    stack, rows, depth, columns = size
    a, b = left(stack, rows, depth), right(stack, depth, columns)
    found = operator(a, b)
    assert found.dtype == torch.float32
    assert found.is_contiguous()
    np.testing.assert_allclose(found, torch.bmm(a.double(), b.double()), rtol=1e-5, atol=1e-4)


def test_an_element_is_the_same_sum_whatever_is_multiplied_beside_it(
    operator: Callable[[Tensor, Tensor], Tensor],
) -> None:
    """A seed learns alone what it learns among ten, bit for bit."""
    a, b = straight(10, 64, 100), turned(10, 100, 70)
    together = operator(a, b)
    assert torch.equal(operator(a[3:4], b[3:4]), together[3:4])
    assert torch.equal(operator(a[:, 11:12], b), together[:, 11:12])
    assert torch.equal(operator(a, b[:, :, 69:].contiguous()), together[:, :, 69:])


def test_the_operator_refuses_what_does_not_fit(
    operator: Callable[[Tensor, Tensor], Tensor],
) -> None:
    a = straight(2, 3, 4)
    with pytest.raises(RuntimeError, match=r"\[2, 3, 4\] by \[2, 3, 4\]"):
        operator(a, a)
    with pytest.raises(RuntimeError, match=r"\[2, 3, 4\] by \[1, 4, 3\]"):
        operator(a, straight(1, 4, 3))
    with pytest.raises(RuntimeError, match="float32"):
        operator(a.double(), turned(2, 4, 3).double())


def test_there_is_no_operator_for_short_vectors() -> None:
    """With those of AVX2 it is no faster than torch's library, without any much slower."""
    refused = pytest.raises(Exception, match="shorter vectors" if COMPILER else "")
    with config.patch({"cpp.simdlen": 256}), refused:
        products.build.__wrapped__()


def test_a_compiled_program_multiplies_by_the_operator_if_it_can_be_built(
    monkeypatch: pytest.MonkeyPatch, operator: Callable[[Tensor, Tensor], Tensor]
) -> None:
    a, b, said = part(2, 9, 33), turned_part(2, 33, 40), list[str]()

    def ours(a: Tensor, b: Tensor) -> Tensor:
        return products.product(a, b)

    program = Program(ours, compiled=True, settled=True, say=said.append)
    assert torch.equal(program(a, b), operator(a, b))

    def too_old() -> None:
        raise RuntimeError("no such header")

    monkeypatch.setattr("tiloilc.learn.engine.program.build", too_old)
    monkeypatch.setattr(products, "_registered", lambda: False)
    other = Program(ours, compiled=True, settled=True, say=said.append)
    assert torch.equal(other(a, b), torch.bmm(a, b))
    assert len(said) == 2  # that each is compiled, and no more

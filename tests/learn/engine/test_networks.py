"""Stacked perceptrons: their slopes are autograd's, their optimiser is torch's Adam."""

import pytest
import torch

from tests.learn.examples import generator
from tiloilc.learn.engine.networks import Adam, StackedMLP, product


@pytest.fixture(autouse=True)
def double() -> None:
    torch.set_default_dtype(torch.float64)
    yield
    torch.set_default_dtype(torch.float32)


def random(*shape: int, seed: int = 0) -> torch.Tensor:
    return torch.randn(shape, generator=generator(seed))


@pytest.mark.parametrize("shape", [(3, 5, 4, 6), (3, 5, 1, 6), (3, 5, 4, 1), (1, 1, 1, 1)])
def test_products_are_those_of_each_stack(shape: tuple[int, ...]) -> None:
    stack, n, k, m = shape
    a, b, out = random(stack, n, k), random(stack, k, m, seed=1), torch.zeros(stack, n, m)
    expected = torch.stack([a[i] @ b[i] for i in range(stack)])
    assert torch.allclose(product(a, b), expected)
    assert product(a, b, out=out) is out
    assert torch.allclose(out, expected)
    across = b.transpose(1, 2).contiguous().transpose(1, 2)  # as gradients multiply
    assert torch.allclose(product(a, across), expected)


@pytest.mark.parametrize("layer_norm", [True, False])
@pytest.mark.parametrize("outputs", [1, 3])
def test_slopes_are_those_of_autograd(layer_norm: bool, outputs: int) -> None:
    nets = StackedMLP(2, [4, 8, 7, outputs], generator(), layer_norm)
    x = random(2, 6, 4, seed=1).requires_grad_()
    parameters = [p.clone().requires_grad_() for p in nets.parameters]
    hidden, last = x, len(nets.sizes) - 2
    for i in range(last + 1):
        hidden = torch.baddbmm(parameters[2 * i + 1], hidden, parameters[2 * i])
        if i < last:
            if layer_norm:
                hidden = torch.nn.functional.layer_norm(hidden, hidden.shape[-1:])
            hidden = hidden.relu()
    slope = random(2, 6, outputs, seed=2)
    *expected, at_input = torch.autograd.grad((hidden * slope).sum(), [*parameters, x])
    out, tape = nets.forward(x.detach())
    assert torch.allclose(out, hidden)
    nets.backward(tape, slope)
    for mine, theirs in zip(nets.slopes, expected, strict=True):
        assert torch.allclose(mine, theirs, rtol=1e-7)
    assert torch.allclose(nets.input_slope(tape, slope, 3), at_input[..., -3:])


def test_some_rows_have_the_slopes_of_these_rows() -> None:
    nets = StackedMLP(2, [4, 8, 2], generator(), layer_norm=True)
    x, slope = random(2, 6, 4), random(2, 3, 2, seed=1)
    _, tape = nets.forward(x)
    found = [t.clone() for t in nets.backward(tape.rows(slice(2, 5)), slope)]
    alone = nets.backward(nets.forward(x[:, 2:5])[1], slope)
    assert all(map(torch.allclose, alone, found))


def test_a_clone_has_parameters_of_its_own() -> None:
    nets = StackedMLP(2, [3, 4, 1], generator())
    copy, x = nets.clone(), random(2, 5, 3)
    before = copy(x)
    for parameter in nets.parameters:
        parameter.zero_()
    assert torch.equal(copy(x), before)
    assert not torch.equal(nets(x), before)


def test_steps_are_those_of_torchs_adam() -> None:
    mine = random(50)
    theirs = mine.clone().requires_grad_()
    adam, reference = Adam([mine], 0.01), torch.optim.Adam([theirs], lr=0.01)
    for k in range(5):
        slope = random(50, seed=k)
        theirs.grad = slope.clone()
        adam.step([slope])
        reference.step()
        assert torch.allclose(mine, theirs)

"""A policy as an ONNX graph, written node by node: observation and automaton state to action."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from tiloilc import __version__
from tiloilc.deploy.actor import NORM_EPSILON, Actor, Layers, Networks, Table

OPSET, IR = 17, 8
"""Old enough for every runtime of the last years; LayerNormalization came with 17."""


class Graph:
    """Nodes and constants as they are written; each call returns the name of its result."""

    def __init__(self) -> None:
        self.nodes: list[onnx.NodeProto] = []
        self.constants: list[onnx.TensorProto] = []

    def __call__(self, kind: str, *inputs: str, into: str = "", **attributes: Any) -> str:
        """Add an operation."""
        name = into or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], name=name, **attributes))
        return name

    def constant(self, value: NDArray[Any]) -> str:
        """Add an array."""
        name = f"constant_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(value), name))
        return name


def model_of(actor: Actor, size: int, name: str, values: bool) -> bytes:
    """The model for observations [batch, size] and automaton states [batch].

    Its outputs are `action` and, with `values`, `value`: what arriving in each state is worth, to
    choose among ε-jumps by.
    """
    graph = Graph()
    if isinstance(actor, Networks):
        shape: Sequence[int | str] = ("batch", *actor.low.shape)
        kind = TensorProto.FLOAT
        _networks(graph, actor, values)
    else:
        shape, kind = ("batch",), TensorProto.INT64
        _table(graph, actor, values)
    inputs = [
        helper.make_tensor_value_info("observation", TensorProto.FLOAT, ["batch", size]),
        helper.make_tensor_value_info("state", TensorProto.INT64, ["batch"]),
    ]
    outputs = [helper.make_tensor_value_info("action", kind, shape)]
    if values:
        outputs.append(helper.make_tensor_value_info("value", TensorProto.FLOAT, ["batch"]))
    model = helper.make_model(
        helper.make_graph(graph.nodes, name, inputs, outputs, graph.constants),
        producer_name="tiloilc",
        producer_version=__version__,
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR,
    )
    onnx.checker.check_model(model, full_check=True)
    written: bytes = model.SerializeToString(deterministic=True)
    return written


def _networks(graph: Graph, actor: Networks, values: bool) -> None:
    centred = graph("Sub", "observation", graph.constant(actor.middle))
    seen = graph("Div", centred, graph.constant(actor.half))
    told = graph("Gather", graph.constant(actor.told), "state")
    x = graph("Concat", seen, told, axis=1)
    weight, bias = actor.actor[-1]
    mean = actor.low.size  # the last layer also gives a spread, which greedy actions do not need
    layers = (*actor.actor[:-1], (weight[:, :mean], bias[:mean]))
    scaled = graph("Tanh", _perceptron(graph, layers, x, normalised=False))
    low, high = actor.low.reshape(-1), actor.high.reshape(-1)
    one = graph("Add", scaled, graph.constant(np.ones(1, np.float32)))
    halved = graph("Mul", one, graph.constant(np.full(1, 0.5, np.float32)))
    spread = graph("Mul", halved, graph.constant(high - low))
    flat = graph("Add", spread, graph.constant(low))
    graph("Reshape", flat, graph.constant(np.array([-1, *actor.low.shape])), into="action")
    if not values:
        return
    joint = graph("Concat", x, scaled, axis=1)
    judged = [_perceptron(graph, net, joint, actor.layer_norm) for net in actor.critics]
    least = graph("Squeeze", graph("Min", *judged), graph.constant(np.array([1])))
    _arriving(graph, actor, least)


def _table(graph: Graph, actor: Table, values: bool) -> None:
    cells, states, actions = actor.q.shape
    steps = np.cumprod([1, *actor.sizes[:0:-1]])[::-1].astype(np.int64)
    whole = graph("Cast", "observation", to=TensorProto.INT64)
    place = graph("Sub", whole, graph.constant(actor.low))
    parts = graph("Mul", place, graph.constant(steps))
    cell = graph("ReduceSum", parts, graph.constant(np.array([1])), keepdims=0)
    code = graph("Gather", graph.constant(actor.code), "state")
    first = graph("Mul", cell, graph.constant(np.array([states])))
    row = graph("Add", first, code)
    q = graph("Gather", graph.constant(actor.q.reshape(cells * states, actions)), row)
    best = graph("ArgMax", q, axis=1, keepdims=0)
    graph("Add", best, graph.constant(np.array([actor.first_action])), into="action")
    if not values:
        return
    if actor.alpha > 0:
        alpha = graph.constant(np.full(1, actor.alpha, np.float32))
        hot = graph("Div", q, alpha)
        soft = graph("Mul", graph("ReduceLogSumExp", hot, axes=[1], keepdims=0), alpha)
    else:
        soft = graph("ReduceMax", q, axes=[1], keepdims=0)
    floor = graph("Gather", graph.constant(actor.floor.reshape(-1)), row)
    _arriving(graph, actor, graph("Max", soft, floor))


def _arriving(graph: Graph, actor: Actor, value: str) -> None:
    """What arriving in the state is worth, V there being `value`."""
    pay = graph("Gather", graph.constant(actor.pay), "state")
    discount = graph("Gather", graph.constant(actor.discount), "state")
    graph("Add", pay, graph("Mul", discount, value), into="value")


def _perceptron(graph: Graph, layers: Layers, x: str, normalised: bool) -> str:
    for weight, bias in layers[:-1]:
        x = graph("Add", graph("MatMul", x, graph.constant(weight)), graph.constant(bias))
        if normalised:
            scale = graph.constant(np.ones(len(bias), dtype=np.float32))
            x = graph("LayerNormalization", x, scale, axis=-1, epsilon=NORM_EPSILON)
        x = graph("Relu", x)
    weight, bias = layers[-1]
    return graph("Add", graph("MatMul", x, graph.constant(weight)), graph.constant(bias))

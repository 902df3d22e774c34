"""Tree to typed closure: every name, kind and shape is settled here, nothing at run time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from lark import Token, Tree

from tiloilc.diag import Diagnostic, SourceText, did_you_mean, nearest
from tiloilc.label.expressions import (
    ARITHMETIC,
    COMPARISON,
    WRONG,
    Expression,
    as_token,
    constant,
    extent,
    trees_of,
    whole_number,
)
from tiloilc.label.functions import (
    CONSTANTS,
    FUNCTIONS,
    NUMBER,
    TRUTH,
    Array,
    Kind,
    Misfit,
    common_kind,
    describe,
    fit,
)


@dataclass(slots=True)
class Checker:
    """Checks one predicate; `findings` gathers everything that is wrong with it."""

    text: SourceText
    fields: Mapping[str, tuple[int, int]]
    findings: list[Diagnostic] = field(default_factory=list)

    def predicate(self, tree: Tree[Token]) -> Expression:
        """The whole: it must be a truth value."""
        whole = self.expression(tree)
        if whole.kind is None or whole.kind == TRUTH:
            return whole
        return self._wrong(
            "SPEC113", tree, kind=describe(whole.kind), help="compare it, as in `x > 0`"
        )

    def expression(self, node: Tree[Token]) -> Expression:
        """Any piece, by what the grammar calls it."""
        match node.data:
            case "number":
                return constant(float(str(node.children[0]).replace("_", "")))
            case "true" | "false":
                truth = np.asarray(node.data == "true")
                return Expression(TRUTH, lambda observations: truth)
            case "name":
                return self._name(node)
            case "call":
                return self._call(node)
            case "vector":
                return self._vector(node)
            case "component":
                return self._component(node)
            case "signed":
                return self._signed(node)
            case "power":
                base, exponent = trees_of(node)
                return self._arithmetic(base, [("**", exponent)])
            case "sum" | "product":
                return self._chain(node)
            case "comparison":
                return self._comparison(node)
            case "negation":
                return self._junction(node, "not")
            case "conjunction":
                return self._junction(node, "and")
            case "disjunction":
                return self._junction(node, "or")
        raise AssertionError(f"the grammar knows no {node.data}")

    def _wrong(
        self,
        code: str,
        node: Tree[Token] | Token,
        *,
        label: str = "",
        help: str = "",
        **about: object,
    ) -> Expression:
        start, end = extent(node)
        finding = Diagnostic.of(code, self.text.span(start, end), label=label, help=help, **about)
        self.findings.append(finding)
        return WRONG

    def _name(self, node: Tree[Token]) -> Expression:
        name = str(node.children[0])
        if name in self.fields:
            start, stop = self.fields[name]
            if stop - start == 1:
                return Expression(NUMBER, lambda observations: observations[..., start])
            return Expression(stop - start, lambda observations: observations[..., start:stop])
        if name in CONSTANTS:
            return constant(CONSTANTS[name])
        if name in FUNCTIONS:
            help = f"`{name}` is a function: write `{name}(…)`"
        else:
            help = did_you_mean(name, self.fields, listed="fields")
        help = help or "name it under `observation:`, for example `pos: [0, 2]`"
        return self._wrong("SPEC111", node, name=name, label="not a field", help=help)

    def _vector(self, node: Tree[Token]) -> Expression:
        entries = [(tree, self._number(tree, "a component")) for tree in trees_of(node)]
        if not entries:
            return self._wrong("SPEC112", node, problem="a vector needs at least one component")
        if any(entry.kind is None for _, entry in entries):
            return WRONG
        if len(entries) == 1:
            return entries[0][1]
        runs = [entry.run for _, entry in entries]

        def run(observations: Array) -> Array:
            parts = np.broadcast_arrays(*(part(observations) for part in runs))
            return np.stack(parts, axis=-1)

        if not any(node.find_data("name")):
            with np.errstate(all="ignore"):
                same = run(np.empty(0))
            return Expression(len(runs), lambda observations: same)
        return Expression(len(runs), run)

    def _component(self, node: Tree[Token]) -> Expression:
        whole_node, index_node = trees_of(node)
        whole, index = self.expression(whole_node), whole_number(index_node)
        if index is None:
            return self._wrong(
                "SPEC112",
                index_node,
                problem="an index is a whole number that is written out",
                help="for example `pos[0]`, or `pos[-1]` for the last",
            )
        if whole.kind is None or whole.kind == TRUTH:
            return whole if whole.kind is None else self._not_numbers(whole_node, "an index")
        size = whole.kind
        if not -size <= index < size:
            return self._wrong(
                "SPEC114",
                index_node,
                index=index,
                size="one component" if size == 1 else f"{size} components",
                label=f"0 to {size - 1}" if size > 1 else "only 0",
            )
        if size == NUMBER:
            return whole
        run = whole.run
        return Expression(NUMBER, lambda observations: run(observations)[..., index])

    def _signed(self, node: Tree[Token]) -> Expression:
        sign, operand = node.children
        assert isinstance(operand, Tree), "the grammar says so"
        value = self._numeric(operand, f"`{sign}`")
        if value.kind is None or sign == "+":
            return value
        run = value.run
        return Expression(value.kind, lambda observations: -run(observations))

    def _chain(self, node: Tree[Token]) -> Expression:
        """`a + b - c`: from left to right."""
        first, *rest = node.children
        assert isinstance(first, Tree), "the grammar says so"
        others = zip(map(str, rest[::2]), trees_of(node)[1:], strict=True)
        return self._arithmetic(first, others)

    def _arithmetic(
        self, first: Tree[Token], others: Iterable[tuple[str, Tree[Token]]]
    ) -> Expression:
        """Operators and operands after the first; run in a loop, as there may be thousands."""
        start = self.expression(first)
        kind, steps = start.kind, []
        for operator, operand in others:
            if kind == TRUTH:
                kind = self._not_numbers(first, f"`{operator}`").kind
            before, right = kind, self._numeric(operand, f"`{operator}`")
            if before is None or right.kind is None:
                kind = None
                continue
            kind = self._common(before, right.kind, operand)
            if kind is not None:
                steps.append((ARITHMETIC[operator], before, right.run, right.kind, kind))
        if kind is None:
            return WRONG

        def run(observations: Array) -> Array:
            value = start.run(observations)
            for operation, before, right, own, both in steps:
                value = operation(fit(value, before, both), fit(right(observations), own, both))
            return value

        return Expression(kind, run)

    def _comparison(self, node: Tree[Token]) -> Expression:
        """`a < b <= c`: each neighbouring pair, all of them."""
        operators = [str(c) for c in node.children if isinstance(c, Token)]
        operands = []
        for position, tree in enumerate(trees_of(node)):
            operator = operators[max(0, position - 1)]
            operands.append(self._number(tree, f"`{operator}`"))
        if any(operand.kind is None for operand in operands):
            return WRONG
        first, second, *rest = [operand.run for operand in operands]
        test, *others = [COMPARISON[operator] for operator in operators]
        steps = list(zip(others, rest, strict=True))

        def run(observations: Array) -> Array:
            left, right = first(observations), second(observations)
            result: Array = test(left, right)
            for other, part in steps:
                left, right = right, part(observations)
                result = result & other(left, right)
            return result

        return Expression(TRUTH, run)

    def _junction(self, node: Tree[Token], word: str) -> Expression:
        operands = [self._truth(tree, word) for tree in trees_of(node)]
        if any(operand.kind is None for operand in operands):
            return WRONG
        runs = [operand.run for operand in operands]
        if word == "not":
            return Expression(TRUTH, lambda observations: np.logical_not(runs[0](observations)))
        ufunc = np.logical_and if word == "and" else np.logical_or

        def run(observations: Array) -> Array:
            result = runs[0](observations)
            for part in runs[1:]:
                result = ufunc(result, part(observations))
            return result

        return Expression(TRUTH, run)

    def _call(self, node: Tree[Token]) -> Expression:
        token, *argument_nodes = node.children
        name = str(token)
        function = FUNCTIONS.get(name)
        trees = [tree for tree in argument_nodes if isinstance(tree, Tree)]
        if function is None:
            guess = nearest(name, FUNCTIONS)
            help = f"did you mean `{guess}`?" if guess else f"functions: {', '.join(FUNCTIONS)}"
            if name in self.fields:
                help = f"`{name}` is a field: write `{name}[0]` for a component"
            self._wrong("SPEC115", as_token(token), name=name, label="no such function", help=help)
        arguments = [self._numeric(tree, f"`{name}`") for tree in trees]
        if function is None:
            return WRONG
        most = len(trees) if function.most is None else function.most
        if not function.least <= len(trees) <= most:
            return self._wrong(
                "SPEC116", node, name=name, expected=function.takes, given=len(trees)
            )
        kinds = [argument.kind for argument in arguments if argument.kind is not None]
        if len(kinds) < len(arguments):
            return WRONG
        kind = common_kind(name, function, kinds)
        if isinstance(kind, Misfit):
            position, problem = kind.position, kind.problem
            return self._wrong(
                "SPEC112", trees[position], problem=problem, label=describe(kinds[position])
            )
        runs, apply = [argument.run for argument in arguments], function.run
        result = kind if function.result is None else function.result
        if name in ("min", "max") and len(runs) == 1:
            result = NUMBER
        return Expression(
            result, lambda observations: apply([part(observations) for part in runs], kinds)
        )

    def _common(self, left: Kind, right: Kind, right_node: Tree[Token]) -> Kind | None:
        """Numbers go with everything, vectors with vectors of their size."""
        if left == right or NUMBER in (left, right):
            return max(left, right)
        problem = f"{describe(left)} and {describe(right)} do not fit together"
        self._wrong("SPEC112", right_node, problem=problem, label=describe(right))
        return None

    def _numeric(self, node: Tree[Token], user: str) -> Expression:
        """A number or vector, for `user`."""
        value = self.expression(node)
        return self._not_numbers(node, user) if value.kind == TRUTH else value

    def _not_numbers(self, node: Tree[Token], user: str) -> Expression:
        return self._wrong("SPEC112", node, problem=f"{user} needs numbers, not a truth value")

    def _number(self, node: Tree[Token], user: str) -> Expression:
        """A single number, for `user`."""
        value = self._numeric(node, user)
        if value.kind is None or value.kind == NUMBER:
            return value
        problem = f"{user} needs a single number, not {describe(value.kind)}"
        start, end = extent(node)
        text = self.text.value[start:end]
        help = f"take a component `{text}[0]`, or its length `norm({text})`"
        return self._wrong(
            "SPEC112",
            node,
            problem=problem,
            label=describe(value.kind),
            help=help if node.data == "name" else "take a component, or its length with `norm`",
        )

    def _truth(self, node: Tree[Token], word: str) -> Expression:
        value = self.expression(node)
        if value.kind is None or value.kind == TRUTH:
            return value
        problem = f"`{word}` needs truth values, not {describe(value.kind)}"
        return self._wrong("SPEC112", node, problem=problem, help="compare it, as in `x > 0`")

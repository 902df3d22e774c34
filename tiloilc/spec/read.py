"""Reads a task file: text to tree, tree to the typed task, every finding in one go."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath

from pydantic import ValidationError

from tiloilc.diag import CompileError, Diagnostic, Severity, SourceText, Span
from tiloilc.spec.base import Model
from tiloilc.spec.compose import compose
from tiloilc.spec.model import Spec
from tiloilc.spec.nodes import (
    MappingNode,
    Node,
    Scalar,
    SequenceNode,
    Source,
    child,
    entries_of,
    find,
    is_empty,
    scalar_value,
)
from tiloilc.spec.problems import TASK_FILE, Form, Read, key_place, model_findings, place_of

MAX_PROPOSITIONS = 62
"""A letter is the bits of one signed 64-bit integer, and one bit is kept free."""

_TEXT_KEYS = ("name", "description", "formula", "automaton")
"""Their values are text, whatever they look like: `formula: true`, `name: 2026`."""

_ALTERNATIVES = (
    ((), ("formula", "automaton")),
    (("demonstrations",), ("source", "file", "minari")),
)
"""In these mappings exactly one of these keys is needed."""

_CONSTANTS = frozenset({"true", "false", "0", "1"})


@dataclass(frozen=True, slots=True)
class Document:
    """A task file as it is written: its tree and the place of everything in it.

    `file` is the path as it was given, which is how findings name it.
    """

    path: Path
    file: str
    text: str
    root: MappingNode

    def has(self, *keys: str | int) -> bool:
        """Whether the file gives a value there."""
        return find(self.root, keys) is not None

    def keys(self, *keys: str | int) -> tuple[str, ...]:
        """The keys of the mapping there, in the written order; none if it is no mapping."""
        return tuple(name for name, _ in entries_of(find(self.root, keys)))

    def value_text(self, *keys: str | int) -> SourceText:
        """The text of the single value there, each character with its place.

        Raises KeyError if there is none.
        """
        node = find(self.root, keys)
        if not isinstance(node, Scalar):
            raise KeyError(keys)
        return node.text

    def span(self, *keys: str | int) -> Span:
        """Where the value stands; for what the file does not say, where it would belong."""
        return place_of(self.root, keys)

    def key_span(self, *keys: str | int) -> Span:
        """Where the key stands; for what the file does not say, where it would belong."""
        return key_place(self.root, keys)


@dataclass(frozen=True, slots=True)
class SpecFile(Document):
    """A task file that was read without an error."""

    spec: Spec


def read_spec(path: str | os.PathLike[str]) -> SpecFile:
    """The task in the YAML file at `path`.

    Raises CompileError with all findings, SPEC100 to SPEC109 and SPEC121 to SPEC122.
    """
    document, spec, findings = examine_spec(path)
    if spec is None or any(f.severity is Severity.ERROR for f in findings):
        raise CompileError(*findings)
    return SpecFile(document.path, document.file, document.text, document.root, spec)


def examine_spec(
    path: str | os.PathLike[str],
) -> tuple[Document, Spec | None, tuple[Diagnostic, ...]]:
    """The file as it is written, the task if it can be had, and every finding, sorted by place.

    For those who look on although something is wrong: the formula can be checked while a key of
    another section is misspelt. Raises CompileError only where there is no mapping to look at.
    """
    file = PurePath(path).as_posix()
    return examine_text(file_text(path), file)


def examine_text(text: str, file: str) -> tuple[Document, Spec | None, tuple[Diagnostic, ...]]:
    """Like `examine_spec`, of a text that is already at hand; `file` names it."""
    document, findings = read_document(text, file, TASK_FILE)
    own = _own_findings(document.root)
    return document, *examine_document(document, TASK_FILE, [*findings, *own])


def read_document(text: str, file: str, form: Form[Model]) -> tuple[Document, list[Diagnostic]]:
    """The tree of a file that has the form of a mapping, and what is wrong with its YAML.

    Raises CompileError SPEC100, SPEC104, SPEC106 or SPEC109.
    """
    root, findings = compose(Source(text, file))
    if not isinstance(root, MappingNode):
        kind = "an empty file" if _nothing(root) else "a single value"
        span = root.span if root is not None else Span.at(file)
        kind = "a list" if isinstance(root, SequenceNode) else kind
        about = {"form": form.called, "kind": kind}
        raise CompileError(*findings, Diagnostic.of("SPEC106", span, **about))
    return Document(Path(file), file, text, root), findings


def examine_document(
    document: Document, form: Form[Read], found: Sequence[Diagnostic]
) -> tuple[Read | None, tuple[Diagnostic, ...]]:
    """The document as its model, and all findings; what was `found` is not said in other words."""
    read: Read | None = None
    findings = list(found)
    try:
        read = form.model.model_validate(_plain(document.root, ()))
    except ValidationError as error:
        said = {(f.span.line, f.span.column) for f in findings if f.span}
        for finding in model_findings(error, document.root, form):
            place = finding.span
            if finding.code != "SPEC103" or place is None or (place.line, place.column) not in said:
                findings.append(finding)
    return read, tuple(sorted(dict.fromkeys(findings), key=Diagnostic.sort_key))


def file_text(path: str | os.PathLike[str]) -> str:
    """The text of a YAML file. Raises CompileError SPEC105."""
    path, file = Path(path), PurePath(path).as_posix()
    place = Span.at(file)
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        problem = f"not UTF-8 text (byte {error.start})"
        read = error.object[: error.start].decode()
        place = SourceText.plain(read, file).span(len(read))
    except IsADirectoryError:
        problem = "it is a folder"
    except FileNotFoundError:
        problem = "there is no such file"
    except (OSError, ValueError) as error:
        problem = getattr(error, "strerror", None) or "the path is not valid"
    help = "" if path.suffix in (".yaml", ".yml") else "a task file ends in .yaml"
    raise CompileError(Diagnostic.of("SPEC105", place, path=file, problem=problem, help=help))


def _nothing(root: Node | None) -> bool:
    return root is None or (isinstance(root, Scalar) and is_empty(root))


def _plain(node: Node, path: tuple[str, ...]) -> object:
    """The node as plain values; formulas and predicates as the text that stands there."""
    match node:
        case MappingNode():
            return {k: _plain(e.value, (*path, k)) for k, e in node.entries.items()}
        case SequenceNode():
            return [_plain(item, (*path, "")) for item in node.items]
        case Scalar():
            is_text = path in {(key,) for key in _TEXT_KEYS}
            is_text |= len(path) == 2 and path[0] == "propositions"
            return node.text.value if is_text and not is_empty(node) else scalar_value(node)


def _own_findings(root: MappingNode) -> Iterator[Diagnostic]:
    """What the model cannot say: keys that need or exclude each other, names, empty texts."""
    for parent, keys in _ALTERNATIVES:
        node = find(root, parent)
        if isinstance(node, MappingNode):
            yield from _exactly_one(root, node, parent, keys)
    texts = [(key,) for key in _TEXT_KEYS if key != "description"]
    names = list(entries_of(find(root, ("propositions",))))
    for path in [*texts, *(("propositions", name) for name, _ in names)]:
        value = find(root, path)
        if isinstance(value, Scalar) and not value.text.value.strip():
            yield Diagnostic.of(
                "SPEC103", place_of(root, path), key=".".join(path), problem="is empty"
            )
    for name, entry in names:
        if name in _CONSTANTS or not _printable(name):
            yield Diagnostic.of("SPEC121", entry.key.span, name=name, help="choose another name")
    if len(names) > MAX_PROPOSITIONS:
        yield Diagnostic.of(
            "SPEC122",
            names[MAX_PROPOSITIONS][1].key.span,
            count=len(names),
            limit=MAX_PROPOSITIONS,
        )


def _printable(name: str) -> bool:
    return bool(name.strip()) and name.isprintable() and not set(name) & set("\"'\\`")


def _exactly_one(
    root: MappingNode, node: MappingNode, parent: tuple[str, ...], keys: Iterable[str]
) -> Iterator[Diagnostic]:
    given = [key for key in keys if child(node, key) is not None]
    names = " and ".join(f"`{key}`" for key in given or keys)
    if not given:
        where = f"`{'.'.join(parent)}`" if parent else "the task file"
        yield Diagnostic.of(
            "SPEC108",
            key_place(root, parent),
            problem=f"{where} needs one of {names}",
            help=f"add {' or '.join(f'`{key}:`' for key in keys)}",
        )
    if len(given) > 1:
        first = key_place(root, (*parent, given[0]))
        yield Diagnostic.of(
            "SPEC108",
            key_place(root, (*parent, given[-1])),
            problem=f"{names} exclude each other",
            label=f"`{given[0]}` is given in line {first.line}",
            help="keep one of the two",
        )


__all__ = [
    "MAX_PROPOSITIONS",
    "Document",
    "SpecFile",
    "examine_spec",
    "examine_text",
    "read_spec",
]

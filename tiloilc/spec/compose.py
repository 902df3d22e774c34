"""YAML events to nodes: aliases, merges, duplicate keys, swallowed formulas, limits."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from tiloilc.diag import CompileError, Diagnostic, SourceText, Span
from tiloilc.spec.nodes import Entry, MappingNode, Node, Scalar, SequenceNode, Source, kind_of
from tiloilc.spec.places import places_of
from tiloilc.spec.swallowed import quoting_help, swallowed, what_yaml_reads, without_comment
from tiloilc.spec.syntax import syntax_finding

MAX_CHARACTERS = 1_000_000
MAX_DEPTH = 64
MAX_NODES = 100_000
"""Nodes with all aliases expanded; the largest task file of the paper has 60."""

_KNOWN_TAGS = {f"tag:yaml.org,2002:{t}" for t in ("str", "int", "float", "bool", "null", "map")}
_KNOWN_TAGS |= {"tag:yaml.org,2002:seq"}
_PROPERTIES = re.compile(r"(?:[&!]\S*\s+)*")


@dataclass(slots=True)
class _Open:
    """A collection whose end has not come yet."""

    start: int
    anchor: str | None
    is_mapping: bool
    key: Scalar | None = None
    entries: dict[str, Entry] = field(default_factory=dict)
    merges: list[Entry] = field(default_factory=list)
    items: list[Node] = field(default_factory=list)
    size: int = 1


def compose(source: Source) -> tuple[Node | None, list[Diagnostic]]:
    """The tree of one YAML document and what is wrong with it; None for an empty file.

    Raises CompileError SPEC100, SPEC104 or SPEC109 where reading cannot go on.
    """
    if len(source.text) > MAX_CHARACTERS:
        raise _too_large(None, f"more than {MAX_CHARACTERS:,} characters")
    composer = _Composer(source)
    reader = YAML(typ="safe", pure=True)
    try:
        for event in reader.parse(source.text):
            composer.take(event)
    except YAMLError as error:
        last = syntax_finding(error, source)
        known = [f for f in composer.findings if f.code != last.code or f.span != last.span]
        raise CompileError(*known, last) from None
    return composer.root, composer.findings


class _Composer:
    """Builds the tree without recursion, so that no nesting exhausts the stack."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.root: Node | None = None
        self.findings: list[Diagnostic] = []
        self._anchors: dict[str, Node] = {}
        self._open: list[_Open] = []
        self._documents = 0

    def take(self, event: Event) -> None:
        match event:
            case DocumentStartEvent():
                self._documents += 1
                if self._documents > 1:
                    place = self._span(event)
                    problem = "a task file is one document, here begins another"
                    raise CompileError(Diagnostic.of("SPEC100", place, problem=problem))
            case AliasEvent():
                self._add(self._alias(event))
            case ScalarEvent():
                node = self._scalar(event)
                self._name(event.anchor, node)
                self._add(node)
            case MappingStartEvent() | SequenceStartEvent():
                self._begin(event)
            case MappingEndEvent() | SequenceEndEvent():
                self._end(event)

    def _span(self, event: Event) -> Span:
        return self.source.span(event.start_mark.index, event.end_mark.index)

    def _path(self) -> tuple[str, ...]:
        """The keys that lead to the value which comes next."""
        return tuple(o.key.text.value if o.key else "" for o in self._open if o.is_mapping)

    def _scalar(self, event: ScalarEvent) -> Scalar:
        start, end, tag = event.start_mark.index, event.end_mark.index, event.tag
        if event.anchor is not None or tag is not None:
            foreign = tag is not None and tag not in _KNOWN_TAGS
            if foreign or (event.style is None and swallowed(self._path(), self._at(start))):
                return self._swallow(start)
            properties = _PROPERTIES.match(self.source.text, start, end)
            start = properties.end() if event.value and properties else end
        raw, value = self.source.text[start:end], event.value
        indices = places_of(value, raw, event.style, start)
        text = SourceText(value, self.source.file, tuple(map(self.source.place, indices)))
        # trailing line breaks of a block scalar are no part of what a caret should cover
        span = self.source.span(start, start + len(raw.rstrip()))
        plain = event.style is None and (tag is None or not tag.endswith(":str"))
        return Scalar(text, span, plain)

    def _at(self, index: int) -> str:
        return self.source.text[index : index + 1]

    def _swallow(self, start: int) -> Scalar:
        """SPEC104, and the text that was meant, so that it can be checked all the same."""
        line = without_comment(self.source.text[start : self.source.line_end(start)])
        key = self._open[-1].key if self._open else None
        reading, token = what_yaml_reads(line)
        self.findings.append(
            Diagnostic.of(
                "SPEC104",
                self.source.span(start, start + len(token)),
                problem=f"`{token}` is read as {reading}",
                label=f"{reading} to YAML",
                help=quoting_help(key.text.value if key else None, line),
            )
        )
        places = tuple(self.source.place(start + i) for i in range(len(line) + 1))
        span = self.source.span(start, start + len(line))
        return Scalar(SourceText(line, self.source.file, places), span, plain=False)

    def _alias(self, event: AliasEvent) -> Node:
        return self._anchors.get(event.anchor) or self._swallow(event.start_mark.index)

    def _name(self, anchor: str | None, node: Node) -> None:
        if anchor is not None:
            self._anchors[anchor] = node

    def _begin(self, event: MappingStartEvent | SequenceStartEvent) -> None:
        start = event.start_mark.index
        if len(self._open) >= MAX_DEPTH:
            place = self.source.span(start, start + 1)
            raise _too_large(place, f"nested more than {MAX_DEPTH} levels deep")
        foreign = event.tag is not None and event.tag not in _KNOWN_TAGS
        path, mapping = self._path(), isinstance(event, MappingStartEvent)
        flow = swallowed(path, self._at(start))
        if foreign or (flow and not (mapping and path[0] == "propositions")):
            self._swallow(start)
        self._open.append(_Open(start, event.anchor, mapping))

    def _end(self, event: Event) -> None:
        done = self._open.pop()
        text = self.source.text[done.start : event.end_mark.index].rstrip()
        span = self.source.span(done.start, done.start + len(text))
        node: Node
        if done.is_mapping:
            self._merge(done)
            node = MappingNode(done.entries, span, done.size)
        else:
            node = SequenceNode(tuple(done.items), span, done.size)
        self._name(done.anchor, node)
        self._add(node)

    def _add(self, node: Node) -> None:
        if not self._open:
            self.root = node
            return
        parent = self._open[-1]
        parent.size += node.size
        if parent.size > MAX_NODES:
            raise _too_large(node.span, f"more than {MAX_NODES:,} values, aliases expanded")
        if not parent.is_mapping:
            parent.items.append(node)
        elif parent.key is not None:
            self._store(parent, Entry(parent.key, node))
            parent.key = None
        elif isinstance(node, Scalar):
            parent.key = node
        else:
            problem = f"a key is a single word, not {kind_of(node)}"
            raise CompileError(Diagnostic.of("SPEC100", node.span, problem=problem))

    def _store(self, parent: _Open, entry: Entry) -> None:
        name = entry.key.text.value
        if name == "<<" and entry.key.plain:
            parent.merges.append(entry)
            return
        first = parent.entries.get(name)
        if first is None:
            parent.entries[name] = entry
            return
        place = first.key.span
        self.findings.append(
            Diagnostic.of(
                "SPEC107",
                entry.key.span,
                key=".".join((*self._path()[:-1], name)),
                label=f"first given in line {place.line}, column {place.column}",
                help="keep one of the two",
            )
        )

    def _merge(self, mapping: _Open) -> None:
        """`<<: *other`: keys of another mapping, where they are not given here."""
        for merge in mapping.merges:
            parts: Sequence[Node] = (
                merge.value.items if isinstance(merge.value, SequenceNode) else (merge.value,)
            )
            for part in parts:
                if isinstance(part, MappingNode):
                    for name, entry in part.entries.items():
                        mapping.entries.setdefault(name, entry)
                    continue
                problem = f"must be a mapping or a list of mappings, not {kind_of(part)}"
                self.findings.append(Diagnostic.of("SPEC103", part.span, key="<<", problem=problem))


def _too_large(place: Span | None, problem: str) -> CompileError:
    return CompileError(Diagnostic.of("SPEC109", place, problem=problem))

"""An automaton as a page to play with: one file, which fetches nothing and runs from a disk."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from typing import Protocol

from tiloilc.automaton.drawing.picture.compose import picture
from tiloilc.automaton.drawing.picture.svg import svg_element
from tiloilc.automaton.guards import guard_text
from tiloilc.automaton.ldba import Cube, Ldba
from tiloilc.ltl import name_text

PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>{title}</title>
<style>
{css}</style>
</head>
<body>
<h1>{title}</h1>
<div id="picture" tabindex="0" role="region" aria-label="picture of the automaton">
{svg}</div>
<div id="state" role="status" aria-live="polite">
<p id="where"></p>
<p id="told"></p>
<p id="name"></p>
<p id="count"></p>
</div>
<div id="choice" hidden></div>
<div id="desk">
<section>
<h2>Next letter: what holds?</h2>
<div id="letter"></div>
<p><button type="button" id="read" class="main"></button> <span id="leads"></span></p>
<p>
<button type="button" id="back">Undo</button>
<button type="button" id="reset">Reset</button>
</p>
<h2><label for="word">Or read a word</label></h2>
<textarea id="word" spellcheck="false" placeholder="{example}"></textarea>
<p id="fault" role="alert"></p>
<p>
<button type="button" id="run">Read word</button>
<button type="button" id="repeat" hidden>Repeat its cycle</button>
</p>
<p class="hint">Keys: 1–9 turn propositions on and off, Enter reads the letter, Backspace takes the
last one back, Escape begins anew.</p>
</section>
<section>
<h2>What leads on from here (a click sets the letter)</h2>
<ul id="ahead"></ul>
</section>
<section>
<h2>The way so far (a click goes back to that step)</h2>
<ol id="path"></ol>
</section>
</div>
<noscript><p>The picture needs no script; walking does.</p></noscript>
<script type="application/json" id="automaton">{data}</script>
<script>
{walk}
{script}</script>
</body>
</html>
"""


class HasOrder(Protocol):
    """The stages of an automaton: stage and number of stages of each state."""

    @property
    def index(self) -> Sequence[int]:
        """By state."""

    @property
    def length(self) -> Sequence[int]:
        """By state."""


def to_html(
    ldba: Ldba,
    stages: HasOrder | None = None,
    title: str | None = None,
    told: Sequence[str] = (),
) -> str:
    """`ldba` as a whole HTML page. `told` says of each state in words what it means.

    Words are read in the page as `Ldba.options` and `parse_word` read them here.
    """
    assert not ldba.accepting_edges, "walked are automata with accepting states"
    data = json.dumps(_data(ldba, stages, told), ensure_ascii=False, sort_keys=True)
    here = files(__package__)
    return PAGE.format(
        title=escape(title or "Automaton"),
        css=here.joinpath("page.css").read_text(encoding="utf-8"),
        svg=svg_element(picture(ldba, stages, title)),
        example=escape(_example(ldba)),
        data=data.replace("<", "\\u003c"),
        walk=here.joinpath("walk.js").read_text(encoding="utf-8"),
        script=here.joinpath("page.js").read_text(encoding="utf-8"),
    )


def _example(ldba: Ldba) -> str:
    """A word in both ways of writing, with propositions of the automaton."""
    names = [name_text(name) for name in (*ldba.propositions[:1], *ldba.propositions[-1:])]
    first, last = names if names else ("", "")
    return f"{{{first}}} {{}} then for ever {{{last}}}    or: {first}; !{first}; cycle{{{last}}}"


def _data(ldba: Ldba, stages: HasOrder | None, told: Sequence[str]) -> dict[str, object]:
    """What walk.js works on."""
    return {
        "propositions": list(ldba.propositions),
        "quoted": [name_text(name) for name in ldba.propositions],
        "initial": ldba.initial,
        "sink": ldba.sink,
        "accepting": sorted(ldba.accepting),
        "states": [
            {
                "name": name,
                "stage": None if stages is None else stages.index[b],
                "length": None if stages is None else stages.length[b],
                "told": told[b] if b < len(told) else "",
            }
            for b, name in enumerate(ldba.names)
        ],
        "edges": [
            {
                "source": edge.source,
                "target": edge.target,
                "guard": guard_text(edge.guard, ldba.propositions),
                "cubes": [_literals(cube) for cube in edge.guard],
            }
            for edge in ldba.edges
        ],
        "jumps": [list(jump) for jump in ldba.jumps],
    }


def _literals(cube: Cube) -> list[list[int]]:
    """The propositions that a cube speaks of, each with its value, 0 or 1."""
    bits = range(cube.mask.bit_length())
    return [[i, cube.value >> i & 1] for i in bits if cube.mask >> i & 1]

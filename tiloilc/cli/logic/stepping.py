"""A walk led by lines of text, and how each of its steps is shown."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TextIO

from tiloilc.cli.console import fail, say
from tiloilc.cli.logic.formulas import Written, show
from tiloilc.cli.logic.subjects import Subject
from tiloilc.diag import CompileError

if TYPE_CHECKING:
    from tiloilc.automaton.language.trace import Trace
    from tiloilc.ltl.words import Word

HELP = """\
A line is a letter, the propositions that hold: `a b`, `a, b`, `a & !b`, `{a, b}`; an empty line
is the letter in which none holds. Several letters: `{a} {b}` or `a; b`. Where an ε-jump gives a
choice, `a > 1` goes to state 1.
  back [N]  takes the last letter back, or the last N     reset  begins anew
  where     shows the state again                         word   shows the letters so far
  help      shows this                                    quit   ends, as Ctrl-D does
If a proposition has the name of a command, write `:back` for the command. What comes from a file
or another program has commands with the colon only.
"""

COMMANDS = ("back", "reset", "where", "word", "help", "quit")
ALIASES = {"?": "help", "exit": "quit", "q": "quit", "undo": "back"}
WIDEST_LETTER = 30


def read_word(written: Written, known: Subject) -> Word | None:
    """The word that is written; None, with its faults shown, if it cannot be read."""
    from tiloilc.ltl.words import parse_word

    try:
        return parse_word(written.source, known.ldba.propositions)
    except CompileError as error:
        show(error.diagnostics, written)
        return None


@dataclass(frozen=True)
class Table:
    """The lines about a run; `letters` are those to come, as far as they are known."""

    known: Subject
    propositions: Sequence[str]
    letters: Sequence[int] = ()

    @property
    def width(self) -> int:
        """Of the column of letters."""
        from tiloilc.diag.text import cells

        longest = max((cells(self.letter(letter)) for letter in self.letters), default=0)
        return min(WIDEST_LETTER, max(longest, 12))

    def letter(self, letter: int) -> str:
        """As the table shows it."""
        from tiloilc.ltl.words import letter_text

        return letter_text(letter, self.propositions)

    def head(self) -> str:
        """The names of the columns."""
        return f"time  {'letter':<{self.width}}  state  stage"

    def line(self, trace: Trace, at: int, counted_from: int = 0) -> str:
        """The line about letter `at` of the run."""
        from tiloilc.diag.text import cells

        step, ldba = trace.steps[at], trace.ldba
        text = self.letter(step.letter)
        stages = self.known.stages
        stage, notes = "-", []
        if step.state == ldba.sink:
            notes.append("lost for ever")
        elif stages is not None:
            stage = f"{stages.index[step.state]} of {stages.length[step.state]}"
        if step.state in ldba.accepting and at < counted_from:
            notes.append("accepting")
        elif step.state in ldba.accepting:
            states = [s.state for s in trace.steps[counted_from : at + 1]]
            notes.append(f"accepting, visit {sum(state in ldba.accepting for state in states)}")
        if step.state != ldba.successor(step.source, step.letter):
            notes.append("by an ε-jump")
        filled = text + " " * (self.width - cells(text))
        return f"{at:>4}  {filled}  {step.state:>5}  {stage:<8}{'; '.join(notes)}".rstrip()

    def print(self, trace: Trace, counted_from: int = 0) -> None:
        """All lines, with their head."""
        print(self.head())
        for at in range(len(trace.steps)):
            print(self.line(trace, at, counted_from))


class Session:
    """A walk led by lines of text: a person at a terminal, or a program."""

    def __init__(self, known: Subject, source: TextIO, quiet: bool) -> None:
        from tiloilc.automaton.language.trace import Trace

        self.known = known
        self.source = source
        self.talks = source.isatty()
        self.quiet = quiet
        self.trace = Trace(known.ldba)
        self.table = Table(known, known.ldba.propositions)
        self.fine = True
        self.lines = 0

    def run(self) -> bool:
        """Read all lines. Whether each of them could be understood."""
        say(self.known.title, self.quiet)
        if self.talks:
            names = ", ".join(self.known.ldba.propositions) or "none"
            say(f"propositions: {names}. `help` says what can be written.", self.quiet)
        self.where()
        print(self.table.head())
        try:
            for line in self._lines():
                if not self.obey(line):
                    break
        except KeyboardInterrupt:
            if self.talks:
                sys.stderr.write("\n")
        return self.fine or self.talks

    def _lines(self) -> Iterator[str]:
        while True:
            if self.talks:
                sys.stdout.flush()
                sys.stderr.write("> ")
                sys.stderr.flush()
            try:
                line = self.source.readline()
            except UnicodeDecodeError as error:
                raise fail(f"standard input is not UTF-8 text (byte {error.start})") from None
            if not line:
                if self.talks:
                    sys.stderr.write("\n")
                return
            self.lines += 1
            yield line.strip()

    def obey(self, line: str) -> bool:
        """Do what a line says. Whether to go on."""
        first, _, rest = line.partition(" ")
        if name := self._meant(first):
            return self._command(name, rest.strip())
        self._letters(line)
        return True

    def _meant(self, word: str) -> str:
        """The command that a line's first word is; empty if the line is of letters."""
        name = word.removeprefix(":")
        if name == word and (not self.talks or word in self.known.ldba.propositions):
            return ""
        name = ALIASES.get(name, name) if self.talks else name
        return name if name in COMMANDS else ""

    def _command(self, name: str, rest: str) -> bool:
        if name == "quit":
            return False
        if name == "help":
            sys.stderr.write(HELP)
        elif name == "word":
            say(
                " ".join(map(self.table.letter, (s.letter for s in self.trace.steps)))
                or "no letter"
            )
        elif name == "back":
            self._back(rest)
        else:
            if name == "reset":
                self.trace = type(self.trace)(self.known.ldba)
            self.where()
        return True

    def _back(self, rest: str) -> None:
        if rest and not rest.isdecimal():
            self._wrong(f"`back {rest}`: how many letters? `back` or `back 2`")
            return
        for _ in range(min(int(rest or 1), len(self.trace.steps))):
            self.trace = self.trace.back()
        self.where()

    def _letters(self, line: str) -> None:
        text, chosen = line, None
        if found := re.search(r">\s*(\d+)\s*$", line):
            text, chosen = line[: found.start()], int(found[1])
        written = Written(text, "<letter>") if self.talks else Written(text, "<stdin>", self.lines)
        word = read_word(written, self.known)
        if word is None:
            self.fine = False
            return
        if word.loop:
            self._wrong("what is repeated for ever is walked with --word")
            return
        letters = word.letters or (0,)
        for i, letter in enumerate(letters):
            options = self.trace.options(letter)
            wanted = chosen if i == len(letters) - 1 else None
            if wanted is not None and wanted not in options:
                there = ", ".join(map(str, options))
                self._wrong(
                    f"{self.table.letter(letter)} cannot lead to state {wanted}; it can to {there}"
                )
                return
            if wanted is None and len(options) > 1:
                wanted = self._choice(letter, options)
                if wanted is None:
                    return
            self.trace = self.trace.read(letter, wanted)
            print(self.table.line(self.trace, len(self.trace.steps) - 1))
        if self.talks:
            self.where()

    def _choice(self, letter: int, options: Sequence[int]) -> int | None:
        """The state to go to: asked for at a terminal, else the first. None to take it back."""
        names = self.known.ldba.names
        if not self.talks:
            others = ", ".join(f"`> {state}`" for state in options[1:])
            say(
                f"{self.table.letter(letter)} leads to {options[0]}; by a jump too: {others}",
                self.quiet,
            )
            return options[0]
        for i, state in enumerate(options):
            how = "by an ε-jump" if i else "without a jump"
            then = f": from then on {names[state]}" if self.known.meant else ""
            say(f"  to {state} {how}{then}")
        sys.stderr.write(f"which? [{'/'.join(map(str, options))}] ")
        sys.stderr.flush()
        answer = self.source.readline().strip()
        if answer == "":
            return options[0]
        if answer.isdecimal() and int(answer) in options:
            return int(answer)
        say(f"`{answer}` is none of them: the letter was not read")
        return None

    def _wrong(self, text: str) -> None:
        self.fine = False
        say(f"error: {text}")

    def where(self) -> None:
        """Tell of the state: what it means, and what leads on."""
        if self.quiet:
            return
        from tiloilc.plan.sentences import case_lines, decision_lines, sentence
        from tiloilc.plan.telling import Teller

        trace, stages = self.trace, self.known.stages
        if trace.lost or stages is None:
            say(f"state {trace.state}: lost for ever, whatever comes (`back` takes a letter back)")
            return
        teller = Teller(self.known.ldba, stages)
        place = f"stage {stages.index[trace.state]} of {stages.length[trace.state]}"
        say(f"state {trace.state}, {place}: {sentence(teller, trace.state)}")
        rows = case_lines(teller, trace.state)
        width = max(len(guard) for guard, _ in rows)
        for guard, leads in rows:
            say(f"  {guard:<{width}}  {leads}")
        for line in decision_lines(teller, trace.state, self.known.meant):
            say(f"  {line}")

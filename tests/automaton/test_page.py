"""The page to play with: self-contained, and its script walks as the automaton does here."""

from __future__ import annotations

import json
import random
import re
from importlib.resources import files

import pytest

from tests.automaton.formulas import PAPER
from tests.automaton.scripts import acted, run_script
from tests.strategies import random_formula, random_lasso
from tiloilc.automaton import Ldba, to_html, translate
from tiloilc.automaton.drawing.page import _data
from tiloilc.automaton.language.trace import Trace
from tiloilc.diag import CompileError
from tiloilc.ltl import parse, to_text
from tiloilc.ltl.words import letter_text, parse_word, word_text
from tiloilc.plan import stage_plan
from tiloilc.plan.sentences import sentence
from tiloilc.plan.telling import Teller

NAMES = ("a", "b c", 'd"e')
WALK = files("tiloilc.automaton.drawing").joinpath("walk.js").read_text(encoding="utf-8")
CYCLE = "G F (r & X F (g & X F y)) & G !b"


def automaton(text: str, names: tuple[str, ...] | None = None) -> Ldba:
    parsed = parse(text, names)
    return translate(parsed.formula, parsed.propositions)


def page(text: str) -> str:
    ldba = automaton(text)
    stages = stage_plan(ldba)
    teller = Teller(ldba, stages)
    told = [sentence(teller, b) if b != ldba.sink else "" for b in ldba.states]
    return to_html(ldba, stages, text, told)


def some() -> list[Ldba]:
    generator = random.Random("pages")
    shapes = ("{0}", "F G ({0}) | G F ({1})", "G F ({0}) & F G ({1})")
    found = [automaton(known.text) for known in PAPER.values()]
    for _ in range(60):
        parts = [to_text(random_formula(generator, NAMES, 6)) for _ in range(2)]
        found.append(automaton(generator.choice(shapes).format(*parts), NAMES))
    return found


def test_the_page_is_one_file_that_fetches_nothing() -> None:
    text = page(CYCLE)
    assert text == page(CYCLE)
    assert "default-src 'none'" in text
    outside = text.replace("http://www.w3.org/2000/svg", "")
    assert not re.search(r"https?:|\bsrc=|\bhref=|@import|url\(|fetch\(|XMLHttp|import\(", outside)


def test_names_cannot_break_out_of_the_data() -> None:
    odd = '"</script><script>alert(1)</script>"'
    text = to_html(automaton(f"F {odd}"), title=f"F {odd}")
    assert text.count("</script>") == 2
    assert "alert(1)" in text
    found = re.search(r'id="automaton">(.*?)</script>', text)
    assert found is not None
    assert json.loads(found[1])["propositions"] == [odd.strip('"')]


def test_the_script_leads_where_the_automaton_does() -> None:
    generator = random.Random("walks")
    asked, expected = [], []
    for ldba in some():
        steps = []
        trace = Trace(ldba)
        for _ in range(15):
            letter = generator.randrange(1 << len(ldba.propositions))
            options = trace.options(letter)
            chosen = generator.randrange(len(options))
            trace = trace.read(letter, options[chosen])
            bits = [bool(letter >> i & 1) for i in range(len(ldba.propositions))]
            steps.append([bits, chosen])
        asked.append([_data(ldba, None, ()), steps])
        choices = [list(step.options) for step in trace.steps]
        texts = [letter_text(step.letter, ldba.propositions) for step in trace.steps]
        expected.append([choices, texts, trace.visits])
    assert sum(len(options) > 1 for choices, _, _ in expected for options in choices) > 30
    script = """
    print(JSON.stringify(CASES.map(([automaton, letters]) => {
      let state = automaton.initial;
      const steps = [];
      const choices = letters.map(([letter, chosen]) => {
        const options = Walk.options(automaton, state, letter);
        options.forEach((option) => {
          if (automaton.edges[option.edge].target !== option.state) throw new Error("edge");
        });
        state = options[chosen].state;
        steps.push(options[chosen]);
        return options.map((option) => option.state);
      });
      const texts = letters.map(([letter]) => Walk.text(automaton, letter));
      return [choices, texts, Walk.visits(automaton, steps)];
    })));
    """
    cases = json.dumps(asked).replace("<", "\\u003c")
    assert json.loads(run_script(f"{WALK}\nconst CASES = {cases};\n{script}")) == expected


def test_the_script_reads_words_as_they_are_read_here() -> None:
    generator = random.Random("texts")
    texts = [word_text(random_lasso(generator, NAMES), NAMES) for _ in range(100)]
    texts += ["", ";", "a; !a; cycle{a}", "a &  !!a", "for ever a", "{a} a", "cycle{}", '"b c" a']
    alphabet = [*"a{};,!& ", '"b c"', "cycle{", "then for ever ", "}", "true", "|", "zz"]
    texts += ["".join(generator.choices(alphabet, k=generator.randrange(9))) for _ in range(600)]
    expected: list[list[list[int]] | None] = []
    for text in texts:
        try:
            word = parse_word(text, NAMES)
            expected.append([list(word.letters), list(word.loop)])
        except CompileError:
            expected.append(None)
    assert sum(word is None for word in expected) > 50
    assert sum(word is not None for word in expected) > 150
    script = """
    const automaton = { propositions: NAMES };
    const number = (letter) => letter.reduce((sum, value, p) => sum + (value ? 2 ** p : 0), 0);
    print(JSON.stringify(TEXTS.map((text) => {
      try {
        const word = Walk.parse(automaton, text);
        return [word.letters.map(number), word.loop.map(number)];
      } catch (fault) {
        return null;
      }
    })));
    """
    given = f"const NAMES = {json.dumps(NAMES)}; const TEXTS = {json.dumps(texts)};"
    assert json.loads(run_script(f"{WALK}\n{given}\n{script}")) == expected


def test_an_example_of_a_guard_is_a_letter_of_it() -> None:
    script = """
    print(JSON.stringify(CASES.map((automaton) => automaton.edges.every((edge) =>
      Walk.holds(edge.cubes, Walk.example(automaton, edge.cubes))))));
    """
    cases = json.dumps([_data(ldba, None, ()) for ldba in some()])
    assert set(json.loads(run_script(f"{WALK}\nconst CASES = {cases};\n{script}"))) == {True}


CLICKS = """
const text = (id) => document.getElementById(id).textContent.trim();
const click = (id) => document.getElementById(id).click();
const toggle = (p) => document.querySelectorAll('#letter button')[p].click();
const key = (name) => document.dispatchEvent(new KeyboardEvent('keydown', { key: name }));
const type = (word) => { document.getElementById('word').value = word; click('run'); };
const now = () => [...document.querySelectorAll('.ldba g.now')].map((g) =>
  Object.entries(g.dataset).map((pair) => pair.join(' ')).join());
const path = () => document.querySelectorAll('#path li').length;
const seen = [];
const look = () => seen.push([text('where'), text('count'), now().join(), path()]);
"""


def looked(formula: str, script: str) -> list[list[object]]:
    """What `script` saw when it said `look()`: state, count, what is lit, length of the path."""
    end = "print(JSON.stringify(seen));"
    found = acted(page(formula), f"(() => {{ {CLICKS}\n{script}\n{end} }})();")
    shown: list[list[object]] = json.loads(found)
    return shown


def test_letters_are_clicked_and_taken_back() -> None:
    seen = looked(
        CYCLE,
        "look(); toggle(0); click('read'); look(); toggle(0); toggle(1); click('read'); look();"
        "click('back'); look(); document.querySelectorAll('#ahead button')[2].click();"
        "click('read'); look(); click('reset'); look();",
    )
    assert seen == [
        ["state 0, stage 0", "0 letters read, 0 accepting visits", "state 0", 0],
        ["state 1, stage 1", "1 letter read, 0 accepting visits", "state 1", 1],
        ["state 2, stage 2", "2 letters read, 0 accepting visits", "state 2", 2],
        ["state 1, stage 1", "1 letter read, 0 accepting visits", "state 1", 1],
        ["lost for ever", "2 letters read, 0 accepting visits", "lost 1", 2],
        ["state 0, stage 0", "0 letters read, 0 accepting visits", "state 0", 0],
    ]


def test_words_are_read_and_repeated() -> None:
    seen = looked(
        CYCLE,
        "type('{r} {} then for ever {g} {y} {r}'); look(); click('repeat'); look();"
        "type('{q}'); look(); seen.push([text('fault')]);",
    )
    assert seen[0] == ["state 1, stage 1", "5 letters read, 1 accepting visit", "state 1", 5]
    assert seen[1] == ["state 1, stage 1", "8 letters read, 2 accepting visits", "state 1", 8]
    assert seen[2] == seen[1]
    assert "unknown proposition `q`" in str(seen[3][0])


def test_a_choice_is_asked_for_before_a_word_goes_on() -> None:
    seen = looked(
        "F G y & G !b",
        "type('y; y; y; b'); look(); const box = document.getElementById('choice');"
        "seen.push([box.hidden, box.querySelectorAll('button').length, text('choice')]);"
        "box.querySelectorAll('button')[1].click(); look(); seen.push([box.hidden]);"
        "click('back'); look();",
    )
    assert seen[0] == ["state 0, stage 0", "0 letters read, 0 accepting visits", "state 0", 0]
    assert seen[1][:2] == [False, 2]
    assert "ε-jump: state 1, stage 1, accepting" in str(seen[1][2])
    assert seen[2] == ["lost for ever", "4 letters read, 3 accepting visits", "lost 1", 4]
    assert seen[3] == [True]
    assert seen[4][0] == "state 1, stage 1, accepting"


def test_all_can_be_done_with_keys() -> None:
    seen = looked(
        CYCLE,
        "key('1'); key('Enter'); look(); key('Backspace'); look(); key('Enter'); key('4');"
        "key('Enter'); look(); key('Escape'); look();",
    )
    assert [row[0] for row in seen] == [
        "state 1, stage 1",
        "state 0, stage 0",
        "lost for ever",
        "state 0, stage 0",
    ]


@pytest.mark.parametrize("text", ["true", "F a & G !a", PAPER["sixteen_rooms"].text])
def test_every_automaton_has_a_page_without_faults(text: str) -> None:
    ldba = automaton(text)
    script = "print(document.getElementById('where').textContent);"
    begin = "lost for ever" if ldba.sink == ldba.initial else "state 0"
    assert acted(to_html(ldba, title=text), script).startswith(begin)

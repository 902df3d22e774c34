"""HOA in: every form of the format, and what is said about what is none."""

from __future__ import annotations

import re
from itertools import permutations

import pytest

from tiloilc.automaton import Ldba, accepts, from_hoa, is_empty, read_hoa, to_hoa, translate
from tiloilc.automaton.hoa.tokens import MAX_CHARACTERS
from tiloilc.diag import CompileError, Diagnostic
from tiloilc.ltl import Lasso, parse

TWO = "Acceptance: 2 Inf(0) & Inf(1)\n"

UNTIL = """HOA: v1
States: 3
Start: 0
AP: 2 "a" "b"
acc-name: Buchi
Acceptance: 1 Inf(0)
--BODY--
State: 0 "wait"
[0 & !1] 0
[1] 1
State: 1 "done" {0}
[t] 1
State: 2
[t] 2
--END--
"""
"""a U b, with a state that nothing leads to."""


def language(formula: str, propositions: tuple[str, ...] = ("a", "b")) -> Ldba:
    return translate(parse(formula, propositions).formula, propositions)


def same(ldba: Ldba, formula: str) -> bool:
    """Whether `ldba` accepts the words of `formula`, among all short ones."""
    wanted = language(formula, ldba.propositions)
    letters = range(1 << len(ldba.propositions))
    words = [
        Lasso(stem, (x, y)) for stem in ((), (0,), (1,), (2,)) for x in letters for y in letters
    ]
    return all(accepts(ldba, word) == accepts(wanted, word) for word in words)


def fault(text: str, propositions: tuple[str, ...] | None = None) -> Diagnostic:
    with pytest.raises(CompileError) as caught:
        from_hoa(text, propositions, file="mine.hoa", max_states=100)
    (diagnostic,) = caught.value.diagnostics
    return diagnostic


def body(lines: str, header: str = "") -> str:
    return f'HOA: v1\nStart: 0\nAP: 2 "a" "b"\n{header}--BODY--\n{lines}\n--END--\n'


def buchi(lines: str) -> str:
    return body(lines, "Acceptance: 1 Inf(0)\n")


def test_states_keep_their_order_and_names_and_what_is_not_reached_goes() -> None:
    ldba = from_hoa(UNTIL)
    assert ldba.names == ("wait", "done", "false")
    assert (ldba.accepting, ldba.sink, ldba.jumps) == (frozenset({1}), 2, ())
    assert same(ldba, "a U b")


def test_a_state_without_a_name_is_called_by_its_number() -> None:
    assert from_hoa(UNTIL.replace(' "wait"', "")).names[0] == "state 0"


def test_control_characters_in_names_do_not_reach_a_terminal() -> None:
    named = read_hoa(UNTIL.replace("wait", "w\x1b[31m").replace("AP", 'name: "x\x07"\nAP'))
    assert named.ldba.names[0] == "w\\x1b[31m"
    assert named.name == "x\\x07"


def test_propositions_are_matched_by_name_whatever_their_order() -> None:
    ldba = from_hoa(UNTIL, ("b", "c", "a"))
    assert ldba.propositions == ("b", "c", "a")
    assert same(ldba, "a U b")
    assert ldba.run([ldba.letter("a"), ldba.letter("b")]) == [0, 1]


def test_the_automatons_name_is_kept() -> None:
    assert read_hoa(UNTIL.replace("AP", 'name: "a \\"U\\" b" AP')).name == 'a "U" b'
    assert read_hoa(UNTIL).name == ""


@pytest.mark.parametrize(
    "text",
    [
        UNTIL.replace("States: 3", "/* three /* states */ */ States: 3 /**/"),
        UNTIL.replace("States: 3\n", ""),
        UNTIL.replace("\n", "\r\n"),
        "\N{ZERO WIDTH NO-BREAK SPACE}" + UNTIL,
        UNTIL.replace("\n", " "),
        UNTIL.replace("acc-name", 'tool: "x" "1"\nremark: 1 t "x" y\nacc-name'),
        UNTIL.replace("AP", "properties: deterministic unheard-of\nproperties: state-acc\nAP"),
        UNTIL.replace("[0 & !1]", "[!(!0|1)]"),
        UNTIL.replace("[0 & !1]", "[!!0&(((!1)))]"),
        UNTIL.replace("[0 & !1]", "[0 & !0 | f | !1 & @a]").replace("AP", "Alias: @a 0\nAP"),
        UNTIL.replace("[1]", "[@ab & @1-b]").replace("AP", "Alias: @1-b 1 Alias: @ab t | @1-b AP"),
        UNTIL.replace('"wait"\n[0 & !1] 0\n[1] 1', '"wait"\n2 0 1 1').replace("[t] 2", "2 2 2 2"),
        UNTIL.replace('"done" {0}\n[t] 1', '"done"\n[t] 1 {0}'),
        UNTIL.replace('State: 1 "done" {0}\n[t] 1', 'State: [t] 1 "done" {0 0}\n1'),
        UNTIL.replace("1 Inf(0)", "2 Inf(0)").replace("acc-name: Buchi", ""),
        UNTIL.replace("1 Inf(0)", "1 Inf(0) & (Inf(0) | t)").replace("acc-name: Buchi", ""),
        UNTIL.replace("1 Inf(0)", "2 Inf(0) | Inf(1)").replace("acc-name: Buchi", ""),
        UNTIL.replace("1 Inf(0)", "2 Inf(0) & Inf(!1)").replace("acc-name: Buchi", ""),
        UNTIL.replace("1 Inf(0)", "2 Inf(0) & (Inf(1) | Inf(!1))").replace("acc-name: Buchi", ""),
        UNTIL.replace("Buchi", "generalized-Buchi 1"),
        UNTIL.replace("Buchi", "unheard-of 7"),
    ],
)  # fmt: skip
def test_a_until_b_can_be_written_in_many_ways(text: str) -> None:
    ldba = from_hoa(text)
    assert same(ldba, "a U b")
    assert len(ldba.names) == 3


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        (body("State: 0\n[0] 0\n", "Acceptance: 0 t\nacc-name: all\n"), "G a"),
        (body("State: 0\n[0] 0\n", "Acceptance: 0 t\nacc-name: generalized-Buchi 0\n"), "G a"),
        (body("State: 0\n[0] 0\n", "Acceptance: 0 f\nacc-name: none\n"), "false"),
        (body("State: 0\n[0] 0\n", "Acceptance: 1 Inf(0) & f\n"), "false"),
        (buchi("State: 0 {0}\nState: 1\n[t] 1"), "false"),
        (buchi("State: 0\n[!0]0\n[0]0 {0}"), "G F a"),
        (
            body("State: 0\n[!0&!1]0 [0&!1]0{0} [!0&1]0{1} [0&1]0{0 1}", TWO),
            "G F a & G F b",
        ),
        (body("State: 0\n[!0]0 [0]0{0}", "Acceptance: 1 Inf(0)&Inf(!0)"), "G F a & G F !a"),
        (buchi("State: 0\n[t]0 [0]1\nState: 1 {0}\n[0]1"), "F G a"),
        (
            body(
                "State: 0\n[t]0 [0]1 [1]2\nState: 1\n[!1]1 [1]1{0}\nState: 2\n[!0]2 [0]2{0 1}",
                "Acceptance: 2 Inf(0)",
            ),
            "F a & G F b | F b & G F a",
        ),
    ],
)  # fmt: skip
def test_acceptance_of_all_kinds_means_what_it_says(text: str, formula: str) -> None:
    for acceptance in ("state", "edge"):
        ldba = from_hoa(text, acceptance=acceptance)  # type: ignore[arg-type]
        assert same(ldba, formula), acceptance
        assert not ldba.accepting or acceptance == "state"


def test_no_beginning_is_the_empty_language_and_two_are_a_choice() -> None:
    assert is_empty(from_hoa(UNTIL.replace("Start: 0\n", "")))
    both = from_hoa(UNTIL.replace("Start: 0", "Start: 0 Start: 1"))
    assert same(both, "true")
    assert same(from_hoa(UNTIL.replace("Start: 0", "Start: 0 Start: 0")), "a U b")


def test_an_empty_automaton_has_no_states() -> None:
    text = 'HOA: v1 States: 0 AP: 1 "a" Acceptance: 0 t --BODY-- --END--'
    ldba = from_hoa(text)
    assert (ldba.names, ldba.sink) == (("false",), 0)
    assert from_hoa("HOA: v1 Acceptance: 0 t --BODY-- --END--").propositions == ()


def test_an_edge_into_the_deterministic_part_is_a_jump_to_a_state_that_has_it() -> None:
    ldba = from_hoa(buchi("State: 0\n[t]0\n[0]1\nState: 1 {0}\n[0]1"))
    assert ldba.jumps == ((0, 1),)
    assert ldba.names == ("state 0", "state 1", "false")


def test_an_edge_that_no_state_has_becomes_a_jump_to_a_new_state() -> None:
    ldba = from_hoa(buchi("State: 0\n[t]0\n[0]1\nState: 1 {0}\n[0&1]1"))
    assert same(ldba, "F (a & X G (a & b))")
    assert ldba.jumps == ((0, 1), (0, 2))
    assert ldba.names == ("state 0", "state 1", "jump 0", "false")


def test_a_free_part_that_chooses_itself_becomes_sets_of_states() -> None:
    ldba = from_hoa(
        buchi('State: 0\n[t]0 [0]1\nState: 1 "a was"\n[1]2 [t]1\nState: 2 "ok" {0}\n[1]2')
    )
    assert same(ldba, "F (a & X F G b)")
    assert "a was" in " ".join(ldba.names)


def test_the_text_written_from_a_read_automaton_is_read_to_the_same() -> None:
    ldba = from_hoa(buchi("State: 0\n[t]0\n[0&1]1\nState: 1 {0}\n[0]1"))
    assert from_hoa(to_hoa(ldba)) == ldba


FAULTS = [
    ("HOA: v1", "", "2:1", "does not begin with `HOA: v1`"),
    ("HOA: v1", "HOA: v2", "1:6", "version `v2`"),
    ("HOA: v1", "HOA: v1 HOA: v1", "1:9", "`HOA:` stands there twice"),
    ("States: 3", "States: 3 States: 3", "2:11", "`States:` stands there twice"),
    ("States: 3", "States: 03", "2:9", "begins with a useless 0"),
    ("States: 3", "States: 2147483648", "2:9", "greater than 2147483647"),
    ("States: 3", f"States: {'9' * 9999}", "2:9", "greater than"),
    ("States: 3", "States: 1000000000", "15:", "no `State: 3`"),
    ("States: 3", "States: 2", "13:8", "there is no state 2"),
    ("States: 3", "States: three", "2:9", "expected the number of states, found `three`"),
    ("Start: 0", "Start: 7", "3:8", "there is no `State: 7`"),
    ("Start: 0", "Start:", "4:1", "expected a state's number, found `AP:`"),
    ("AP: 2", "AP: 3", "4:5", "3 propositions, but only 2"),
    ("AP: 2", "AP: 1", "4:5", "1 propositions, but more"),
    ("AP: 2", "AP: 1000000", "4:5", "at most 62"),
    ('"b"', '"a"', "4:11", "`a` stands there twice"),
    ('"b"', '""', "4:11", "cannot name a proposition"),
    ('"b"', '"b', "4:11", "cannot name a proposition"),
    ("--END--", '"--END--', "15:1", "the quoted text never ends"),
    ("acc-name: Buchi\n", "Alias: @a @a\n", "5:11", "`@a` is not defined before its use"),
    ("acc-name: Buchi\n", "Alias: @a 0 Alias: @a 1\n", "5:20", "alias `@a` is defined twice"),
    ("acc-name: Buchi\n", "Alias: @a 0 &\n", "6:1", "expected the number of a proposition"),
    ("acc-name: Buchi\n", "Alias: @a 5\n", "5:11", "there is no proposition 5"),
    ("acc-name: Buchi\n", "Fair: 1\n", "5:1", "`Fair:` is not known"),
    ("acc-name: Buchi\n", "start: 1 [\n", "5:10", "expected a header such as `Start:`"),
    ("acc-name: Buchi", "acc-name: all", "5:11", "contradicts `Acceptance: 1 Inf(0)`"),
    ("acc-name: Buchi", "acc-name: generalized-Buchi 2", "5:11", "contradicts"),
    ("1 Inf(0)", "1000000000 Inf(0)", "5:11", "contradicts `Acceptance: 1000000000 Inf(0)`"),
    ("acc-name: Buchi", "properties: trans-acc", "5:13", "says `trans-acc`, which is not so"),
    ("acc-name: Buchi", "properties: complete", "5:13", "says `complete`, which is not so"),
    ("Acceptance: 1 Inf(0)\n", "", "7:1", "there is no `Acceptance:`"),
    ("1 Inf(0)", "1 Inf(1)", "6:19", "there is no acceptance set 1"),
    ("1 Inf(0)", "1 Inf 0", "6:19", "expected `(` after `Inf`"),
    ("1 Inf(0)", "1 (Inf(0)", "7:1", "expected `&`, `|` or `)`"),
    ("1 Inf(0)", "1 !Inf(0)", "6:15", "expected `Inf(…)`"),
    ("--BODY--", "--END--", "7:1", "expected a header such as `Start:`"),
    ("State: 0", "State: [t] 0", "9:1", "its edges must not"),
    ("[1] 1", "1", "10:1", "either all edges of state 0 have labels, or none"),
    ("[0 & !1] 0\n[1] 1", "0 1", "8:8", "so 4 edges, but 2 are listed"),
    ("[0 & !1] 0\n[1] 1", "0 1 1 1 1", "9:9", "so 4 edges, but more"),
    ("[1] 1", "[2] 1", "10:2", "there is no proposition 2"),
    ("[1] 1", "[@x] 1", "10:2", "alias `@x` is not defined"),
    ("[1] 1", "[1 1", "10:4", "expected `&`, `|` or `]`"),
    ("[1] 1", "[(1] 1", "10:4", "expected `&`, `|` or `)`"),
    ("[1] 1", "[1)] 1", "10:3", "expected `&`, `|` or `]`"),
    ("[1] 1", "[] 1", "10:2", "expected the number of a proposition"),
    ("[1] 1", "[1] 9", "10:5", "there is no `State: 9`"),
    ("[1] 1", "[1] 1 {1}", "10:8", "there is no acceptance set 1"),
    ("[1] 1", "[1] 1 {0", "11:1", "expected the number of an acceptance set, or `}`"),
    ("State: 2", "State: 1", "13:8", "state 1 is described twice"),
    ("--END--", "", "14:", "expected `State:`, an edge or `--END--`, found the end of the file"),
    ("--END--", "--ABORT--", "15:1", "its writer gave up"),
    ("--END--", "--END-- HOA: v1", "15:9", "a second automaton begins here"),
    ("--END--", "--END-- x", "15:9", "expected the end of the file"),
    ("--END--", "/* --END--", "15:1", "the comment never ends"),
    ("--END--", "$ --END--", "15:1", "`$` does not belong to the format"),
]


@pytest.mark.parametrize(("old", "new", "place", "problem"), FAULTS)
def test_a_fault_is_named_in_its_place(old: str, new: str, place: str, problem: str) -> None:
    assert UNTIL.count(old) >= 1
    found = fault(UNTIL.replace(old, new, 1))
    assert found.code == "AUT302"
    assert found.span is not None
    assert problem in found.message
    assert re.match(place, f"{found.span.line}:{found.span.column}"), found
    assert "\n" not in found.message + found.help


@pytest.mark.parametrize(
    ("old", "new", "code", "problem"),
    [
        ("1 Inf(0)", "1 Fin(0)", "AUT303", "acceptance `Fin`"),
        ("Buchi\nAcceptance: 1 Inf", "Rabin 1\nAcceptance: 2 Inf(1) & Fin", "AUT303", "`Rabin 1`"),
        ("Start: 0", "Start: 0&1", "AUT306", "begins in several states at once"),
        ("[1] 1", "[1] 1&0", "AUT306", "an edge leads to several states at once"),
        ("[t] 1", "[t] 1 [0] 0", "AUT304", "state 1 (`done`) goes to 1 and to 0 on `a`"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_has_its_own_code(old: str, new: str, code: str, problem: str) -> None:
    text = UNTIL.replace("acc-name: Buchi\n", "", 1) if old.startswith("1 Inf") else UNTIL
    found = fault(text.replace(old, new, 1))
    assert (found.code, problem in found.message) == (code, True), found
    assert found.help


def test_all_unknown_propositions_are_named_with_what_may_be_meant() -> None:
    with pytest.raises(CompileError) as caught:
        from_hoa(UNTIL, ("A", "c"))
    first, second = caught.value.diagnostics
    assert (first.code, first.help) == ("AUT307", "did you mean `A`? declared: A, c")
    assert "`b`" in second.message


def test_acceptance_that_chooses_must_be_reachable_to_matter() -> None:
    lines = "State: 0\n[!0]0 [0]0{0}\nState: 1 {0}\n[t]1 [t]0"
    assert same(from_hoa(buchi(lines)), "G F a")


def test_a_choice_between_states_of_which_one_is_dead_is_none() -> None:
    ldba = from_hoa(buchi("State: 0\n[!0]0 [0]0{0} [0]1\nState: 1\n[t]1"))
    assert same(ldba, "G F a")
    assert not ldba.jumps


def test_two_edges_to_one_state_on_one_letter_have_the_marks_of_both() -> None:
    assert same(from_hoa(body("State: 0\n[0]0{0} [0]0{1} [!0]0", TWO)), "G F a")


@pytest.mark.parametrize("depth", [10, 100_000])
def test_labels_may_be_nested_to_any_depth(depth: int) -> None:
    label = "!(" * depth + "1" + ")" * depth
    assert same(from_hoa(UNTIL.replace("[1] 1", f"[{label}] 1")), "a U b")
    condition = "(" * depth + "Inf(0)" + ")" * depth
    assert same(from_hoa(UNTIL.replace("Inf(0)", condition)), "a U b")
    comment = "/*" * depth + "*/" * depth
    assert same(from_hoa(UNTIL.replace("--BODY--", f"{comment}--BODY--")), "a U b")


def test_what_would_not_end_ends_in_a_limit() -> None:
    names = " ".join(f'"p{i}"' for i in range(60))
    pairs = " & ".join(f"({i} & {i + 30} | !{i} & !{i + 30})" for i in range(30))
    state = f"--BODY-- State: 0 {{0}} [{pairs}] 0 --END--"
    assert fault(f"HOA: v1 Start: 0 AP: 60 {names} Acceptance: 1 Inf(0) {state}").code == "AUT305"
    sets = " | ".join(f"(Inf({2 * i}) & Inf({2 * i + 1}))" for i in range(40))
    unnamed = UNTIL.replace("acc-name: Buchi\n", "")
    assert fault(unnamed.replace("1 Inf(0)", f"80 {sets}")).code == "AUT305"
    many = "".join(f"State: {n}\n[t] 0\n" for n in range(200))
    assert fault(buchi(many)).code == "AUT305"
    assert fault(UNTIL + " " * MAX_CHARACTERS).code == "AUT305"


def test_a_free_part_that_explodes_ends_in_a_limit() -> None:
    lines = ["State: 0", "[t] 0", "[0] 1"]
    for n in range(1, 20):
        lines += [f"State: {n}", f"[t] {n + 1}"]
    lines += ["State: 20", "[1] 21", "State: 21 {0}", "[t] 21"]
    found = fault(buchi("\n".join(lines)))
    assert found.code == "AUT305"


def test_letters_left_out_are_in_the_order_of_the_format() -> None:
    text = body("State: 0 {0}\n1 0 1 1\nState: 1 {0}\n1 1 1 0", "Acceptance: 1 Inf(0)\n")
    ldba = from_hoa(text, ("b", "a"))
    assert ldba.run([ldba.letter(["a"]), ldba.letter(["b"]), ldba.letter("ab")]) == [0, 1, 0]


def test_many_beginnings_into_one_part_are_one_jump_each() -> None:
    starts = " ".join(f"Start: {i}" for i in range(30))
    states = "\n".join(f"State: {i} {{0}}\n[{'!' * (i % 2)}0] {i}" for i in range(30))
    ldba = from_hoa(f'HOA: v1 {starts} AP: 1 "a" Acceptance: 1 Inf(0) --BODY-- {states} --END--')
    assert same(ldba, "G a | G !a")


@pytest.mark.parametrize(
    ("states", "starts", "formula"),
    [
        ("State: [0] 0 {0}\n0 1\nState: [!0] 1\n0 1", (0, 1), "G F a"),
        ("State: [0&!1] 0\n0 1\nState: [1] 1\n2\nState: [t] 2 {0}\n2", (0, 1), "a U b"),
        ("State: [t] 0\n0 1\nState: [0] 1 {0}\n1", (0, 1), "F G a"),
        ("State: [0] 0\n0 {0} 1\nState: [!0] 1\n0 1", (0,), "a & F G a | a & G F (a & X a)"),
        ("State: [0] 0 {0}\n0 1\nState: [!0] 1\n0 1\nState: [1] 2 {0}", (0, 1, 2), "G F a"),
    ],
)
def test_labels_on_states_are_read_on_entering_where_that_decides(
    states: str, starts: tuple[int, ...], formula: str
) -> None:
    text = buchi(states).replace("Start: 0", " ".join(f"Start: {n}" for n in starts))
    assert same(from_hoa(text), formula)


def test_three_edges_to_one_state_have_the_marks_of_all_that_read_a_letter() -> None:
    three = "Acceptance: 3 Inf(0) & Inf(1) & Inf(2)\n"
    for order in permutations(("[0]0{0}", "[1]0{0 1}", "[0|1]0{1 2}", "[!0&!1]0")):
        ldba = from_hoa(body(f"State: 0\n{' '.join(order)}", three))
        assert same(ldba, "G F a | G F b & G F a | G F (b & !a)"), order

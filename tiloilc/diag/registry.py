"""Every diagnostic code: its severity, its message template and what it means."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """How grave a finding is; errors end the work, warnings do not."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Rule:
    """One diagnostic code. `message` is a format template; `explanation` is for `explain CODE`."""

    code: str
    severity: Severity
    name: str
    message: str
    explanation: str


def _rules(*rules: Rule) -> dict[str, Rule]:
    return {rule.code: rule for rule in rules}


E, W, N = Severity.ERROR, Severity.WARNING, Severity.NOTE

RULES: dict[str, Rule] = _rules(
    # YAML and schema
    Rule(
        "SPEC100",
        E,
        "yaml-syntax",
        "not valid YAML: {problem}",
        "The task file cannot be read as YAML 1.2. Most often a quote or bracket is not closed, a "
        "line is indented by a tab, or a value that contains `: ` or ` #` is not quoted. "
        "Formulas and predicates are safe inside double quotes.",
    ),
    Rule(
        "SPEC101",
        E,
        "unknown-key",
        "unknown key `{key}`",
        "The task file has a key that tiloilc does not know. Unknown keys are errors, because a "
        "misspelt setting would otherwise be ignored without a word. `tiloilc schema` prints the "
        "JSON Schema of the file, with which editors complete the keys.",
    ),
    Rule(
        "SPEC102",
        E,
        "missing-key",
        "missing key `{key}`",
        "A key without a default is absent. A task file needs `name`, `environment` with `id` and "
        "`horizon`, `propositions`, `formula` or `automaton`, and `train` with `steps`.",
    ),
    Rule(
        "SPEC103",
        E,
        "wrong-value",
        "`{key}` {problem}",
        "The value has the wrong type or lies outside what the key allows. Numbers may be written "
        "as `60000`, `60_000`, `6e4` or, where fractions are allowed, `1/3`.",
    ),
    Rule(
        "SPEC104",
        E,
        "swallowed-formula",
        "YAML swallows this text: {problem}",
        "A YAML value that begins with `!` is a tag, with `&` an anchor, with `*` an alias, with "
        "`|` or `>` a block, with `[` or `{` a collection; YAML never passes these characters on. "
        "Formulas use many of them, so put the whole text in double quotes: "
        'formula: "!a U b".',
    ),
    Rule(
        "SPEC105",
        E,
        "unreadable-file",
        "cannot read `{path}`: {problem}",
        "The file does not exist, may not be read, or is not UTF-8 text. Paths inside a task file "
        "are relative to the folder of the task file.",
    ),
    Rule(
        "SPEC106",
        E,
        "not-a-task-file",
        "a task file is a mapping of keys to values, not {kind}",
        "The file is valid YAML, but its top level is a list, a single value or empty. "
        "`tiloilc init NAME` writes a task file to begin with.",
    ),
    Rule(
        "SPEC107",
        E,
        "duplicate-key",
        "duplicate key `{key}`",
        "The same key stands twice in one mapping. YAML readers silently keep one of the two; "
        "which one was meant cannot be known, so this is an error.",
    ),
    Rule(
        "SPEC108",
        E,
        "conflicting-keys",
        "{problem}",
        "Two keys exclude each other, or exactly one of several is needed: `formula` or "
        "`automaton`; `source` or `file` under `demonstrations`.",
    ),
    Rule(
        "SPEC109",
        E,
        "yaml-too-large",
        "the YAML is too large: {problem}",
        "Aliases and merges can make a short file expand to billions of nodes, and deep nesting "
        "exhausts any reader. A task file needs neither; the limits are far above honest use.",
    ),
    # Predicates and observation fields
    Rule(
        "SPEC110",
        E,
        "predicate-syntax",
        "cannot read the predicate: {problem}",
        "The text does not belong to the predicate language: numbers, vectors `[x, y]`, fields of "
        "the observation, indexing `pos[0]`, `+ - * / ** %`, comparisons (chained too), `and`, "
        "`or`, `not`, `true`, `false`, and the functions abs min max sqrt sin cos tan atan2 hypot "
        'norm dot dist wrap in_box in_ball. What it cannot say goes to `python: "file.py:name"`.',
    ),
    Rule(
        "SPEC111",
        E,
        "unknown-field",
        "unknown field `{name}`",
        "The predicate uses a name that is no field of the observation. Fields are published by "
        "the environment (`observation_fields`) or named in the task file under `observation:`, "
        "for example `pos: [0, 2]` or `speed: 4`.",
    ),
    Rule(
        "SPEC112",
        E,
        "shape-mismatch",
        "{problem}",
        "A vector meets a vector of another size, a vector stands where a single number is needed, "
        "or a truth value where a number is needed. A number beside a vector is applied to every "
        "component. Comparisons need numbers on both sides: compare `norm(v)`, or `v[0]`.",
    ),
    Rule(
        "SPEC113",
        E,
        "not-a-truth-value",
        "the predicate is {kind}, not true or false",
        "A proposition is true or false in every state, so its predicate must end in a comparison, "
        "a test such as `in_box`, or a combination of these with `and`, `or`, `not`.",
    ),
    Rule(
        "SPEC114",
        E,
        "no-such-component",
        "there is no component {index}: the vector has {size}",
        "An index counts from 0, or backwards from -1, and must lie inside the vector.",
    ),
    Rule(
        "SPEC115",
        E,
        "unknown-function",
        "unknown function `{name}`",
        "The functions of the predicate language are abs min max sqrt sin cos tan atan2 hypot norm "
        'dot dist wrap in_box in_ball. Anything else goes to `python: "file.py:name"`.',
    ),
    Rule(
        "SPEC116",
        E,
        "wrong-argument-count",
        "`{name}` takes {expected}, not {given}",
        "A function of the predicate language has too few or too many arguments.",
    ),
    Rule(
        "SPEC117",
        E,
        "python-predicate",
        "cannot use `{reference}`: {problem}",
        "A Python predicate is written `file.py:function`, the file relative to the task file. The "
        "function takes observations [n, d] and returns one truth value for each, a bool array "
        "[n]; it must depend on nothing but its argument.",
    ),
    Rule(
        "SPEC119",
        E,
        "predicate-too-deep",
        "the predicate is nested too deeply (more than {limit} levels)",
        "The predicate has more levels of brackets and operators than any reader could follow. "
        "Split it into several propositions, or write it in Python.",
    ),
    Rule(
        "SPEC120",
        E,
        "field-outside-observation",
        "field `{name}` is [{start}, {stop}), but the observation has {size} components",
        "A field names components start, start + 1, …, stop - 1 of the flat observation, counted "
        "from 0; a single index names one component.",
    ),
    Rule(
        "SPEC121",
        E,
        "proposition-name",
        "`{name}` cannot name a proposition",
        "`true`, `false`, `0` and `1` are constants of the formula language. A name must not be "
        "empty, nor contain quotes, backslashes or control characters. A name that is not made of "
        'letters, digits and underscores must be quoted in the formula: G "wp-0".',
    ),
    Rule(
        "SPEC122",
        E,
        "too-many-propositions",
        "{count} propositions are declared, at most {limit} are possible",
        "A letter is the set of true propositions, kept as the bits of one 64-bit integer.",
    ),
    # Formula
    Rule(
        "LTL201",
        E,
        "formula-syntax",
        "cannot read the formula: {problem}",
        "The text is not a formula. The language is that of Spot and Owl: `! & | -> <-> ^ X F G U "
        "R W M`, words for them, `true`, `false`, and declared propositions.",
    ),
    Rule(
        "LTL202",
        E,
        "formula-too-deep",
        "the formula is too large: {problem}",
        "The formula is longer or nested more deeply than the limits allow.",
    ),
    Rule(
        "LTL203",
        E,
        "unknown-proposition",
        "unknown proposition `{name}`",
        "The formula uses a name that is not declared under `propositions`.",
    ),
    Rule(
        "LTL204",
        W,
        "unused-proposition",
        "proposition `{name}` is declared but the formula never uses it",
        "An unused proposition costs time for every label, and often means that the formula "
        "forgets something. Remove it, or use it.",
    ),
    Rule(
        "LTL205",
        W,
        "ambiguous-word",
        "`{word}` is read as {reading}",
        "Operators need no space around them, so a word can be a proposition or operators followed "
        "by one: `GFa` is `G F a`. Declared propositions win. Where a word can be read both ways, "
        "this warning says how it was read; put spaces or quotes to make it certain.",
    ),
    Rule(
        "LTL210",
        E,
        "unsatisfiable",
        "no behaviour satisfies the formula",
        "The formula contradicts itself: whatever the agent does, it is violated. Nothing can be "
        "learned from it.",
    ),
    Rule(
        "LTL211",
        W,
        "always-true",
        "every behaviour satisfies the formula",
        "The formula is a tautology: whatever the agent does, it is satisfied. There is nothing to "
        "learn.",
    ),
    Rule(
        "LTL212",
        W,
        "vacuous",
        "`{part}` does not matter: the formula means the same without it",
        "The sub-formula can be replaced by true or by false without changing the meaning of the "
        "formula, which mostly means that the formula does not say what was intended.",
    ),
    Rule(
        "LTL214",
        W,
        "precedence-surprise",
        "`{text}` is read as `{reading}`",
        "Precedence is Spot's: unary operators bind tightest, then U R W M, then &, then |, then "
        "-> and <->. The formula is read differently from what its layout suggests; brackets make "
        "it certain.",
    ),
    Rule(
        "LTL215",
        N,
        "chain-order",
        "the order in `{part}` is not part of its language",
        "`G F (a & X F b)` is true exactly when a and b both come infinitely often, in whatever "
        "order. The automaton keeps the written order, because a fixed order is easier to learn "
        "and the demonstrations follow one; it accepts the same words.",
    ),
    # Automaton
    Rule(
        "AUT301",
        N,
        "needs-jumps",
        "the automaton needs ε-jumps: {problem}",
        "No deterministic Büchi automaton exists, or none was found, for this formula. The agent "
        "itself decides when to jump to the part of the automaton that accepts: it guesses that "
        "from now on the rest of the formula holds.",
    ),
    Rule(
        "AUT302",
        E,
        "automaton-syntax",
        "cannot read the automaton: {problem}",
        "The file is not an automaton in the Hanoi format (HOA v1).",
    ),
    Rule(
        "AUT303",
        E,
        "unsupported-acceptance",
        "acceptance `{acceptance}` is not supported",
        "Only Büchi acceptance is read, on states or on edges: `acc-name: Buchi`. Other tools "
        "convert to it, for example Owl's `ltl2ldba` or Spot's `autfilt --ba`.",
    ),
    Rule(
        "AUT304",
        E,
        "not-limit-deterministic",
        "the automaton is not limit-deterministic: {problem}",
        "After an accepting state every letter must lead to one state only, otherwise the agent "
        "could guess its way to acceptance.",
    ),
    Rule(
        "AUT305",
        E,
        "state-cap",
        "the automaton is too large: {problem}",
        "The translation reached its limit of states or of time and was stopped. The number of "
        "states can grow doubly exponentially with the formula. Split the task, or raise the limit "
        "if the machine bears it.",
    ),
    # Stages
    Rule(
        "PLAN401",
        E,
        "stale-plan",
        "`{path}` {change} after the plan was compiled",
        "A plan carries digests of everything it was compiled from. Training on changed inputs "
        "would not be what the plan says; compile again.",
    ),
    Rule(
        "PLAN402",
        E,
        "no-accepting-state",
        "no accepting state can be reached",
        "The automaton has no accepting state that a word can reach and visit infinitely often, so "
        "there are no stages and no goal.",
    ),
    Rule(
        "PLAN403",
        N,
        "max-stage-ambiguous",
        "states {states} are equally close to acceptance: {tie_break}",
        "The best stage of a segment (Eq. 7 of the paper) is not always unique. The state with the "
        "least distance to acceptance wins, then the larger stage index, then the one visited "
        "last.",
    ),
    Rule(
        "PLAN404",
        E,
        "beta-too-large",
        "β = {beta} breaks the stage order: it must be below 1/2",
        "The reward of a state is (SIDX(b) + β tanh f) / N(b) (Eq. 8 of the paper). With β below "
        "1/2 a later stage always pays more than an earlier one; with more, a good state of an "
        "early stage can pay more than a poor one of a later stage, and the agent stays behind.",
    ),
    Rule(
        "PLAN405",
        N,
        "absorbing-acceptance",
        "acceptance is absorbing: once reached, it only has to be kept",
        "Every accepting state is left only to accepting states. The number of accepting visits "
        "then counts the steps after success, so it says how early the task was done, not how "
        "often.",
    ),
    Rule(
        "PLAN406",
        W,
        "approximate-stages",
        "the automaton has {states} states: stage indices are approximate",
        "The longest acyclic path is searched exactly up to a bound. Beyond it the components are "
        "ordered instead, which keeps the order of stages but may count some of them together.",
    ),
    Rule(
        "PLAN407",
        E,
        "unreadable-plan",
        "cannot read the plan: {problem}",
        "The file is not a plan of this version of tiloilc. `tiloilc compile` writes one.",
    ),
    # Demonstrations
    Rule(
        "DEMO500",
        E,
        "unreadable-demonstrations",
        "cannot read `{path}`: {problem}",
        "Demonstrations are an .npz with `observations` [T+1, d] per episode and a JSON beside it; "
        "`tiloilc demos record` writes both. Pickled arrays are refused.",
    ),
    Rule(
        "DEMO501",
        W,
        "never-demonstrated",
        "no demonstration makes `{name}` true",
        "The formula asks for the proposition, but no state of any demonstration satisfies it: "
        "either the predicate is wrong, or the demonstrations are of another task.",
    ),
    Rule(
        "DEMO502",
        W,
        "stage-never-left",
        "no demonstration leaves stage {stage}",
        "Run through the automaton, all demonstrations end in this stage or before. The "
        "discriminator of this stage has nothing to imitate.",
    ),
    Rule(
        "DEMO503",
        W,
        "violating-demonstration",
        "demonstration {index} violates the formula at step {step}",
        "The demonstration enters a sink of the automaton: from this step on, the formula cannot "
        "be satisfied any more.",
    ),
    Rule(
        "DEMO504",
        E,
        "demonstration-shape",
        "demonstrations have {given} components, the environment's observations {expected}",
        "Demonstrated states and observed states must have the same layout.",
    ),
    Rule(
        "DEMO505",
        E,
        "no-actions",
        "the demonstrations carry no actions",
        "`actions: recorded` and algorithms that clone or replay actions need demonstrations with "
        "an `actions` array. `actions: inferred` estimates them from states alone.",
    ),
    Rule(
        "DEMO506",
        E,
        "no-expert",
        "there is no scripted expert for `{environment}`",
        "`source: expert` works for the environments that come with tiloilc. For others, give "
        "demonstrations with `file:`.",
    ),
    Rule(
        "DEMO507",
        E,
        "outside-the-spaces",
        "demonstration {index} does not fit the environment: {problem}",
        "Recorded actions must be actions of the environment, in its own units, and where a table "
        "is learned, every demonstrated state must be a cell of it.",
    ),
    # Environment and settings
    Rule(
        "JOB600",
        E,
        "environment",
        "cannot make `{environment}`: {problem}",
        "Gymnasium could not make the environment. Its id may be misspelt, its package missing, or "
        "its arguments wrong. `module:Id-v0` imports the module first.",
    ),
    Rule(
        "JOB601",
        W,
        "irreproducible-reset",
        "`{environment}` does not reset reproducibly",
        "Two resets with the same seed gave different observations. Results will not be "
        "reproducible; environments must draw all randomness from `self.np_random`.",
    ),
    Rule(
        "JOB602",
        E,
        "unsupported-space",
        "`{environment}` has {problem}",
        "Observations must be flat numbers (Box, Discrete, MultiDiscrete, or a Dict of them), "
        "actions a bounded Box or Discrete.",
    ),
    Rule(
        "JOB603",
        E,
        "broken-version",
        "{package} {version} is known to break this task",
        "This combination of versions was tried and does not work. `tiloilc doctor` lists what is "
        "installed and what works.",
    ),
    Rule(
        "JOB604",
        E,
        "bad-setting",
        "setting `{setting}`: {problem}",
        "A training setting does not fit the algorithm, the preset or the environment.",
    ),
    # Training
    Rule(
        "JOB606",
        E,
        "propositions-in-training",
        "training works with at most {limit} propositions, not {count}",
        "The product of environment and automaton is a table with a column for each set of "
        "propositions. Translating and inspecting formulas has no such limit.",
    ),
    Rule(
        "JOB607",
        E,
        "resets-by-itself",
        "the batched form of `{id}` resets its episodes by itself",
        "A vector environment must declare autoreset mode DISABLED in its metadata and take a "
        "reset mask: the last state of an episode would be lost otherwise.",
    ),
    Rule(
        "JOB608",
        E,
        "unsuitable-spaces",
        "the {backbone} backbone cannot learn observations {seen} with actions {actions}",
        "SAC needs a Box of actions; tabular Q-learning needs finitely many observations and "
        "discrete actions. `train.backbone: auto` picks what fits.",
    ),
    Rule(
        "JOB609",
        W,
        "nothing-learned",
        "nothing is learned in {steps} steps: the first {random} are random",
        "Learning begins after `learning_starts` environment steps, which are taken at random to "
        "fill the buffers. A run that is not longer than that leaves an untrained policy.",
    ),
    Rule(
        "RUN701",
        E,
        "unreadable-run",
        "cannot read the run `{path}`: {problem}",
        "The folder is no run of this version of tiloilc, or it was cut short before its first "
        "checkpoint.",
    ),
    Rule(
        "RUN702",
        E,
        "training-diverged",
        "training diverged at step {step}: {problem}",
        "A loss or weight became infinite or undefined. A smaller learning rate, a larger batch or "
        "the default preset mostly helps.",
    ),
    Rule(
        "RUN703",
        E,
        "run-not-written",
        "cannot write in `{path}`: {problem}",
        "The disk is full or not writable. The last checkpoint is intact.",
    ),
    Rule(
        "RUN704",
        E,
        "other-plan",
        "the run `{path}` was trained with another plan",
        "A checkpoint can only be resumed with the plan and settings that it was made with.",
    ),
    Rule(
        "RUN705",
        E,
        "not-reproducible",
        "the environment does not repeat itself, so the run cannot be resumed exactly",
        "To resume, unfinished episodes are played again from their seeds and actions. This "
        "environment then arrived in other states than before.",
    ),
    Rule(
        "RUN706",
        E,
        "nothing-to-evaluate",
        "the run `{path}` has no finished policy",
        "Policies are written when training ends. An interrupted run goes on with --resume.",
    ),
    Rule(
        "RUN707",
        E,
        "environment-failed",
        "the environment `{id}` failed: {problem}",
        "The environment raised an exception while it was used, or returned something that is no "
        "observation of its own space. The last checkpoint is intact; correct the environment.",
    ),
)
"""All rules by code, in the order of their codes."""

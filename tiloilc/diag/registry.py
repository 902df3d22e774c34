"""Every diagnostic code: its severity, its name and its message template."""

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
    """One diagnostic code. `message` is a format template; `pages.page(code)` explains it."""

    code: str
    severity: Severity
    name: str
    message: str


def _rules(*rules: Rule) -> dict[str, Rule]:
    return {rule.code: rule for rule in rules}


E, W, N = Severity.ERROR, Severity.WARNING, Severity.NOTE

RULES: dict[str, Rule] = _rules(
    # YAML and schema
    Rule("SPEC100", E, "yaml-syntax", "not valid YAML: {problem}"),
    Rule("SPEC101", E, "unknown-key", "unknown key `{key}`"),
    Rule("SPEC102", E, "missing-key", "missing key `{key}`"),
    Rule("SPEC103", E, "wrong-value", "`{key}` {problem}"),
    Rule("SPEC104", E, "swallowed-formula", "YAML swallows this text: {problem}"),
    Rule("SPEC105", E, "unreadable-file", "cannot read `{path}`: {problem}"),
    Rule("SPEC106", E, "not-a-task-file", "{form} is a mapping of keys to values, not {kind}"),
    Rule("SPEC107", E, "duplicate-key", "duplicate key `{key}`"),
    Rule("SPEC108", E, "conflicting-keys", "{problem}"),
    Rule("SPEC109", E, "yaml-too-large", "the YAML is too large: {problem}"),
    # Predicates and observation fields
    Rule("SPEC110", E, "predicate-syntax", "cannot read the predicate: {problem}"),
    Rule("SPEC111", E, "unknown-field", "unknown field `{name}`"),
    Rule("SPEC112", E, "shape-mismatch", "{problem}"),
    Rule("SPEC113", E, "not-a-truth-value", "the predicate is {kind}, not true or false"),
    Rule("SPEC114", E, "no-such-component", "there is no component {index}: the vector has {size}"),
    Rule("SPEC115", E, "unknown-function", "unknown function `{name}`"),
    Rule("SPEC116", E, "wrong-argument-count", "`{name}` takes {expected}, not {given}"),
    Rule("SPEC117", E, "python-predicate", "cannot use `{reference}`: {problem}"),
    Rule(
        "SPEC119",
        E,
        "predicate-too-deep",
        "the predicate is nested too deeply (more than {limit} levels)",
    ),
    Rule(
        "SPEC120",
        E,
        "field-outside-observation",
        "field `{name}` is [{start}, {stop}), but the observation has {size}",
    ),
    Rule("SPEC121", E, "proposition-name", "`{name}` cannot name a proposition"),
    Rule(
        "SPEC122",
        E,
        "too-many-propositions",
        "{count} propositions are declared, at most {limit} are possible",
    ),
    # Formula
    Rule("LTL201", E, "formula-syntax", "cannot read the formula: {problem}"),
    Rule("LTL202", E, "formula-too-deep", "the formula is too large: {problem}"),
    Rule("LTL203", E, "unknown-proposition", "unknown proposition `{name}`"),
    Rule(
        "LTL204",
        W,
        "unused-proposition",
        "proposition `{name}` is declared but the formula never uses it",
    ),
    Rule("LTL205", W, "ambiguous-word", "`{word}` is read as {reading}"),
    Rule("LTL206", E, "word-syntax", "cannot read the word: {problem}"),
    Rule("LTL210", E, "unsatisfiable", "no behaviour satisfies the formula"),
    Rule("LTL211", W, "always-true", "every behaviour satisfies the formula"),
    Rule("LTL212", W, "vacuous", "`{part}` does not matter: the formula means the same without it"),
    Rule(
        "LTL213",
        W,
        "irrelevant-proposition",
        "proposition `{name}` never matters: the formula means the same whatever it is",
    ),
    Rule("LTL214", W, "precedence-surprise", "`{text}` is read as `{reading}`"),
    Rule("LTL215", N, "chain-order", "the order in `{part}` is not part of its language"),
    # Automaton
    Rule("AUT301", N, "needs-jumps", "the automaton needs ε-jumps: {problem}"),
    Rule("AUT302", E, "automaton-syntax", "cannot read the automaton: {problem}"),
    Rule("AUT303", E, "unsupported-acceptance", "acceptance `{acceptance}` is not supported"),
    Rule(
        "AUT304",
        E,
        "not-limit-deterministic",
        "the automaton is not limit-deterministic: {problem}",
    ),
    Rule("AUT305", E, "state-cap", "the automaton is too large: {problem}"),
    Rule("AUT306", E, "alternating", "the automaton is alternating: {problem}"),
    Rule(
        "AUT307",
        E,
        "undeclared-proposition",
        "the automaton reads `{name}`, which is not declared",
    ),
    Rule(
        "AUT308",
        W,
        "unread-proposition",
        "proposition `{name}` is declared but the automaton never reads it",
    ),
    Rule("AUT309", W, "accepts-everything", "the automaton accepts every behaviour"),
    Rule("AUT310", E, "no-picture", "cannot draw the automaton: {problem}"),
    # Stages
    Rule("PLAN401", E, "stale-plan", "`{path}` {change} after the plan was compiled"),
    Rule("PLAN402", E, "no-accepting-state", "no accepting state can be reached"),
    Rule(
        "PLAN403",
        N,
        "max-stage-ambiguous",
        "states {states} are equally close to acceptance: {tie_break}",
    ),
    Rule("PLAN404", E, "beta-too-large", "β = {beta} breaks the stage order: it must be below 1/2"),
    Rule(
        "PLAN405",
        N,
        "absorbing-acceptance",
        "acceptance is absorbing: once reached, it only has to be kept",
    ),
    Rule(
        "PLAN406",
        W,
        "approximate-stages",
        "the automaton has {states} states: stage indices are approximate",
    ),
    Rule("PLAN407", E, "unreadable-plan", "cannot read the plan: {problem}"),
    # Demonstrations
    Rule("DEMO500", E, "unreadable-demonstrations", "cannot read `{path}`: {problem}"),
    Rule("DEMO501", W, "never-demonstrated", "no demonstration makes `{name}` true"),
    Rule("DEMO502", W, "stage-never-left", "no demonstration leaves stage {stage}"),
    Rule(
        "DEMO503",
        W,
        "violating-demonstration",
        "demonstration {index} violates the formula at step {step}",
    ),
    Rule(
        "DEMO504",
        E,
        "demonstration-shape",
        "demonstrations have {given}, the environment's observations {expected}",
    ),
    Rule("DEMO505", E, "no-actions", "{carrier} no actions"),
    Rule("DEMO506", E, "no-expert", "there is no scripted expert{named} for `{environment}`"),
    Rule(
        "DEMO507",
        E,
        "outside-the-spaces",
        "demonstration {index} does not fit the environment: {problem}",
    ),
    Rule(
        "DEMO508",
        W,
        "demonstrations-of-another-environment",
        "the demonstrations were recorded in {recorded}, not in {environment}",
    ),
    Rule("DEMO509", E, "unusable-expert", "cannot use the expert `{reference}`: {problem}"),
    Rule("DEMO510", E, "dataset-not-written", "cannot write the dataset `{name}`: {problem}"),
    Rule("DEMO511", E, "too-few-demonstrations", "`{path}` has {given}, not {wanted}"),
    # Environment and settings
    Rule("JOB600", E, "environment", "cannot make `{environment}`: {problem}"),
    Rule("JOB601", W, "irreproducible-reset", "`{environment}` does not reset reproducibly"),
    Rule("JOB602", E, "unsupported-space", "`{environment}` has {problem}"),
    Rule("JOB603", E, "broken-version", "{package} {version} is known to break this task"),
    Rule("JOB604", E, "bad-setting", "setting `{setting}`: {problem}"),
    Rule("JOB605", W, "doubtful-setting", "setting `{setting}`: {problem}"),
    # Training
    Rule(
        "JOB606",
        E,
        "propositions-in-training",
        "training works with at most {limit} propositions, not {count}",
    ),
    Rule(
        "JOB607", E, "resets-by-itself", "the batched form of `{id}` resets its episodes by itself"
    ),
    Rule(
        "JOB608",
        E,
        "unsuitable-spaces",
        "the {backbone} backbone cannot learn observations {seen} with actions {actions}",
    ),
    Rule(
        "JOB609",
        W,
        "nothing-learned",
        "nothing is learned in {steps} steps: the first {random} are random",
    ),
    Rule("JOB610", E, "unusable-algorithm", "algorithm `{name}`: {problem}"),
    Rule("JOB611", E, "nothing-to-draw", "cannot draw `{environment}`: {problem}"),
    Rule("RUN701", E, "unreadable-run", "cannot read the run `{path}`: {problem}"),
    Rule("RUN702", E, "training-diverged", "training diverged at step {step}: {problem}"),
    Rule("RUN703", E, "run-not-written", "cannot write in `{path}`: {problem}"),
    Rule("RUN704", E, "other-plan", "the run `{path}` was trained with {other}"),
    Rule(
        "RUN705",
        E,
        "not-reproducible",
        "the environment does not repeat itself, so the run cannot be resumed exactly",
    ),
    Rule("RUN706", E, "nothing-to-evaluate", "the run `{path}` has no finished policy"),
    Rule("RUN707", E, "environment-failed", "the environment `{id}` failed: {problem}"),
    Rule("RUN708", E, "policy-not-available", "no such policy in the run `{path}`: {problem}"),
    Rule("RUN709", E, "too-little-memory", "the run needs {needed}, and {available} are available"),
    Rule("RUN710", E, "no-such-device", "cannot learn on `cuda`: {problem}"),
    Rule("RUN711", E, "no-film", "cannot film `{subject}`: {problem}"),
    Rule(
        "RUN712",
        E,
        "other-version",
        "another version of tiloilc trained the run `{path}`, and kept other things of it",
    ),
    Rule("RUN713", E, "not-exactly-verified", "cannot verify `{subject}` exactly: {problem}"),
    Rule(
        "RUN714", E, "false-model", "the model that `{id}` publishes of itself is wrong: {problem}"
    ),
    Rule("RUN715", E, "no-such-engine", "cannot use the engine `{engine}`: {problem}"),
)
"""All rules by code, in the order of their codes."""

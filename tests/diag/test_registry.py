"""The registry of codes keeps its own rules."""

from __future__ import annotations

import re

import pytest

from tiloilc.diag import RULES, Rule, did_you_mean, nearest

CONTRACT = [
    "SPEC101",
    "SPEC104",
    "SPEC107",
    "LTL201",
    "LTL203",
    "LTL204",
    "LTL210",
    "LTL211",
    "LTL212",
    "LTL214",
    "LTL215",
    "AUT301",
    "AUT305",
    "PLAN402",
    "PLAN403",
    "PLAN404",
    "PLAN405",
    "DEMO501",
    "DEMO502",
    "DEMO503",
    "DEMO504",
    "JOB601",
    "JOB603",
]
RANGES = {"SPEC": "1", "LTL": "2", "AUT": "3", "PLAN": "4", "DEMO": "5", "JOB": "6", "RUN": "7"}


def test_every_code_of_the_contract_is_registered() -> None:
    assert set(CONTRACT) <= RULES.keys()


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda rule: rule.code)
def test_a_rule_is_complete(rule: Rule) -> None:
    match = re.fullmatch(r"([A-Z]+)([0-9])[0-9]{2}", rule.code)
    assert match is not None
    assert RANGES[match[1]] == match[2]
    assert re.fullmatch(r"[a-z]+(-[a-z]+)*", rule.name)
    assert "\n" not in rule.message
    assert not rule.message.endswith(".")


def test_codes_are_in_order_and_names_are_unique() -> None:
    order = list(RANGES)
    codes = [(order.index(re.sub(r"\d", "", code)), code) for code in RULES]
    assert codes == sorted(codes)
    assert len({rule.name for rule in RULES.values()}) == len(RULES)


def test_did_you_mean_names_the_nearest_and_lists_what_is_known() -> None:
    expected = "did you mean `c`? declared: a, b, c"
    assert did_you_mean("cc", ["a", "b", "c"], listed="declared") == expected
    assert did_you_mean("zebra", ["a"]) == "known: a"
    assert did_you_mean("zebra", []) == ""


def test_the_nearest_name_ignores_case_first() -> None:
    assert nearest("POS", ["post", "pos"]) == "pos"
    assert nearest("xyz", ["pos"]) is None

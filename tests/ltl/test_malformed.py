"""Malformed formulas, each with what is printed about it."""

import pytest

from tests.ltl.malformed import FILE, Case, cases, rewritten, said

TEXT = FILE.read_text(encoding="utf-8")
CASES = list(cases(TEXT))


def test_there_are_many() -> None:
    assert len(CASES) >= 100
    assert len({(case.text, case.declared) for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: ascii(case.text))
def test_a_malformed_formula_gets_its_text(case: Case) -> None:
    assert case.printed.strip(), "it can be read"
    assert said(case) == case.printed


def test_the_file_is_written_as_it_is_read() -> None:
    assert rewritten(TEXT) == TEXT


def test_every_finding_names_what_was_expected_or_is_not_known() -> None:
    lines = [line for line in TEXT.splitlines() if line.startswith("error[")]
    assert all("expected " in line or "unknown proposition" in line for line in lines)
    assert {line[:14] for line in lines} == {"error[LTL201]:", "error[LTL203]:"}

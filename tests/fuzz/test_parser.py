"""The parser under random and mutated texts."""

import pytest

from tests.fuzz.parser import CODES, fuzz
from tiloilc.ltl import parser


def test_random_texts_end_in_formulas_or_findings() -> None:
    seen = fuzz(12_000, seed=7)
    assert not seen.faults, "\n".join(seen.faults[:5])
    assert seen.formulas > 1_500
    assert set(seen.codes) >= CODES


@pytest.mark.slow
def test_many_random_texts_end_in_formulas_or_findings() -> None:
    seen = fuzz(100_000, seed=8)
    assert not seen.faults, "\n".join(seen.faults[:5])


def test_a_crash_and_a_wrong_reading_would_be_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    real = parser.tokenize

    def broken(text: str, declared: object) -> object:
        if "\x00" in text:
            raise IndexError("string index out of range")
        return real(text, declared)  # type: ignore[arg-type]

    monkeypatch.setattr(parser, "tokenize", broken)
    seen = fuzz(2_000, seed=9)
    assert seen.faults
    assert all(fault.startswith("IndexError: string index") for fault in seen.faults)

"""Storm in a program of its own: it answers as it does here, and can be stopped."""

import os
import signal
import threading
from fractions import Fraction

import numpy as np
import pytest

from tiloilc.evaluate.verify.storm import Process, Storm, Unanswered, probabilities

COIN = Process(
    (({1: Fraction(1, 3), 2: Fraction(2, 3)},), ({1: Fraction(1)},), ({0: Fraction(1)},)),
    {"p0": np.array([False, True, False]), "p1": np.array([False, False, True])},
)
"""Heads, a third, is for ever; after tails one tosses again."""

EASY = 'F "p1"'


def hard(conjuncts: int) -> str:
    """A property whose automaton Storm works on for longer than anybody waits."""
    ahead = ['"p0"']
    for _ in range(conjuncts):
        ahead.append(f'X ({ahead[-1]} | "p1")')
    return " & ".join(f'G F ("p1" & X F ("p0" & {text}))' for text in ahead[1:])


def test_a_program_of_its_own_answers_as_storm_does_here() -> None:
    with Storm(60) as storm:
        for asked in (EASY, 'G !"p1"', 'G F "p1"'):
            assert storm.probabilities(COIN, asked, [0, 2]) == probabilities(COIN, asked, [0, 2])
        assert storm.probabilities(COIN, EASY, [0, 1]) == {0: Fraction(2, 3), 1: 0}


def test_what_takes_longer_than_the_limit_is_not_waited_for_and_the_next_question_is() -> None:
    with Storm(60) as storm:
        storm.probabilities(COIN, EASY, [0])  # it has begun
        storm.limit = 1
        with pytest.raises(Unanswered, match="takes longer than 1 s"):
            storm.probabilities(COIN, hard(14), [0])
        storm.limit = 60
        assert storm.probabilities(COIN, EASY, [0]) == {0: Fraction(2, 3)}


def test_a_program_that_ends_is_no_answer_and_is_begun_again() -> None:
    with Storm(60) as storm:
        storm.probabilities(COIN, EASY, [0])
        assert storm.program is not None
        storm.program.kill()
        storm.program.wait()
        with pytest.raises(Unanswered, match=r"without an answer \(status -9\)"):
            storm.probabilities(COIN, EASY, [0])
        assert storm.probabilities(COIN, EASY, [0]) == {0: Fraction(2, 3)}


def interrupted(storm: Storm) -> None:
    with storm:
        threading.Timer(1, os.kill, (os.getpid(), signal.SIGINT)).start()
        storm.probabilities(COIN, hard(14), [0])


def test_an_interrupt_ends_the_program_as_well() -> None:
    storm = Storm(60)
    storm.probabilities(COIN, EASY, [0])
    program = storm.program
    assert program is not None
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background
    try:
        with pytest.raises(KeyboardInterrupt):
            interrupted(storm)
    finally:
        signal.signal(signal.SIGINT, before)
    assert storm.program is None
    assert program.returncode == -signal.SIGKILL

"""How likely a policy satisfies its formula: exactly on finite tasks, with bounds elsewhere."""

from tiloilc.evaluate.verify.recorded import records_of
from tiloilc.evaluate.verify.results import VERIFY, Counterexample, Verification
from tiloilc.evaluate.verify.task import Wanted, verify_run, verify_task

__all__ = [
    "VERIFY",
    "Counterexample",
    "Verification",
    "Wanted",
    "records_of",
    "verify_run",
    "verify_task",
]

"""Many runs: specs × settings × seeds, on this machine or on many, each recorded once."""

from tiloilc.sweep.drive import Sweep, carry_out, collect
from tiloilc.sweep.engine import Engine, Event, Started
from tiloilc.sweep.experiments import Experiment, Job, check, jobs_of
from tiloilc.sweep.local import Local
from tiloilc.sweep.model import Changes, given, record_pattern, sweep_schema
from tiloilc.sweep.ray import Ray
from tiloilc.sweep.recorded import Same, merge, recorded
from tiloilc.sweep.request import RECORDS, Options, Request, requests
from tiloilc.sweep.slurm import Slurm
from tiloilc.sweep.table import table
from tiloilc.sweep.work import Outcome

__all__ = [
    "RECORDS",
    "Changes",
    "Engine",
    "Event",
    "Experiment",
    "Job",
    "Local",
    "Options",
    "Outcome",
    "Ray",
    "Request",
    "Same",
    "Slurm",
    "Started",
    "Sweep",
    "carry_out",
    "check",
    "collect",
    "given",
    "jobs_of",
    "merge",
    "record_pattern",
    "recorded",
    "requests",
    "sweep_schema",
    "table",
]

"""Calls the stages of the compiler in order and gathers what they find."""

from tiloilc.driver.analysis import Analysis, analyse
from tiloilc.driver.build import (
    Compiled,
    compile_spec,
    labeller,
    lint,
    load_plan,
    plan_file,
    read_plan,
    write_build,
    write_file,
    write_plan,
)
from tiloilc.driver.settings import doubtful_findings, settings_findings

__all__ = [
    "Analysis",
    "Compiled",
    "analyse",
    "compile_spec",
    "doubtful_findings",
    "labeller",
    "lint",
    "load_plan",
    "plan_file",
    "read_plan",
    "settings_findings",
    "write_build",
    "write_file",
    "write_plan",
]

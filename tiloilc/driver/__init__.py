"""Calls the stages of the compiler in order and gathers what they find."""

from tiloilc.driver.analysis import Analysis, analyse
from tiloilc.driver.build import (
    Compiled,
    compile_spec,
    compiled,
    labeller,
    lint,
    load_plan,
    plan_file,
    read_plan,
    write_build,
    write_plan,
)
from tiloilc.driver.settings import (
    backbone,
    backbone_findings,
    doubtful_findings,
    settings_findings,
)

__all__ = [
    "Analysis",
    "Compiled",
    "analyse",
    "backbone",
    "backbone_findings",
    "compile_spec",
    "compiled",
    "doubtful_findings",
    "labeller",
    "lint",
    "load_plan",
    "plan_file",
    "read_plan",
    "settings_findings",
    "write_build",
    "write_plan",
]

"""Stages of an automaton, and the plan: all that a training job needs, as canonical JSON."""

from tiloilc.plan.canonical import automaton_json, digest, from_json, ldba_from_json, to_json
from tiloilc.plan.model import SCHEMA_VERSION, Plan, Predicate, Stages
from tiloilc.plan.options import Option, options
from tiloilc.plan.roots import importable
from tiloilc.plan.stages import is_absorbing, max_stage, stage_findings, stage_plan

__all__ = [
    "SCHEMA_VERSION",
    "Option",
    "Plan",
    "Predicate",
    "Stages",
    "automaton_json",
    "digest",
    "from_json",
    "importable",
    "is_absorbing",
    "ldba_from_json",
    "max_stage",
    "options",
    "stage_findings",
    "stage_plan",
    "to_json",
]

"""YAML text to a typed, frozen task with the place of every node."""

from tiloilc.spec.model import (
    MAX_NAME,
    NAME_SIGNS,
    Demonstrations,
    Environment,
    Evaluate,
    PythonPredicate,
    Spec,
)
from tiloilc.spec.page import settings_page
from tiloilc.spec.problems import refusal
from tiloilc.spec.read import Document, SpecFile, examine_spec, examine_text, read_spec
from tiloilc.spec.schema import json_schema
from tiloilc.spec.settings import Settings, Train

__all__ = [
    "MAX_NAME",
    "NAME_SIGNS",
    "Demonstrations",
    "Document",
    "Environment",
    "Evaluate",
    "PythonPredicate",
    "Settings",
    "Spec",
    "SpecFile",
    "Train",
    "examine_spec",
    "examine_text",
    "json_schema",
    "read_spec",
    "refusal",
    "settings_page",
]

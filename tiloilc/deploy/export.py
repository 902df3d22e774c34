"""A policy for other programs: an ONNX model, its automaton, and what ties them together.

The model is a function of s and b; whoever runs it reads labels and steps the automaton, by the
tables in `policy.json`. Nothing of it needs tiloilc.
"""

from __future__ import annotations

from pathlib import Path

from tiloilc import __version__
from tiloilc.automaton import to_hoa
from tiloilc.deploy.actor import Networks
from tiloilc.deploy.policy import Policy
from tiloilc.plan import automaton_json, digest
from tiloilc.plan.canonical import Json, canonical
from tiloilc.writing import write_file

MODEL, AUTOMATON, ABOUT = "policy.onnx", "automaton.hoa", "policy.json"
EXPORTED = (MODEL, AUTOMATON, ABOUT)
"""The files of an export."""

SCHEMA_VERSION = 1

HOW = (
    "Begin in `initial`. For every observation, the first one included, compute its letter: bit i "
    "says whether proposition i holds. If an entry of `options` is of the state you are in and one "
    "of its cubes [mask, value] has letter & mask == value, go to the one of its targets that the "
    "model gives the greatest `value`; else along the edge of your state with such a cube. Then "
    "run the model on the observation and the state you are in now: `action` is what to do."
)


def export(policy: Policy, folder: Path) -> None:
    """Write the files of EXPORTED; the same policy gives the same bytes.

    Raises ImportError without the package onnx.
    """
    from tiloilc.deploy.onnx import model_of

    plan, actor = policy.plan, policy.actor
    size = actor.middle.size if isinstance(actor, Networks) else actor.low.size
    shape = list(actor.low.shape) if isinstance(actor, Networks) else []
    outputs: dict[str, Json] = {"action": ["batch", *shape]}
    if policy.walk.chooses:
        outputs["value"] = ["batch"]
    about: dict[str, Json] = {
        "schema_version": SCHEMA_VERSION,
        "version": __version__,
        "name": plan.name,
        "description": plan.description,
        "formula": plan.formula,
        "plan_digest": digest(plan),
        "seed": policy.seed,
        "environment": plan.environment.model_dump(mode="json"),
        "fields": {name: list(span) for name, span in plan.fields.items()},
        "propositions": [
            {"name": p.name, "python": p.python} if p.python else {"name": p.name, "text": p.text}
            for p in plan.predicates
        ],
        "automaton": automaton_json(plan.ldba),
        "model": {
            "file": MODEL,
            "inputs": {"observation": ["batch", size], "state": ["batch"]},
            "outputs": outputs,
        },
        "how": HOW,
    }
    model = model_of(actor, size, plan.name, values=policy.walk.chooses)
    folder.mkdir(parents=True, exist_ok=True)
    write_file(folder / MODEL, model)
    write_file(folder / AUTOMATON, to_hoa(plan.ldba, name=plan.goal))
    write_file(folder / ABOUT, canonical(about) + "\n")

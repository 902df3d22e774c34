"""What a verification found, as records beside those of the run (`results/verified/`)."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from tiloilc.evaluate.records import IDENTITY, SCHEMA_VERSION, Json, Record, records_of_run
from tiloilc.evaluate.verify.results import Verification

RUN = (*IDENTITY, "demonstrations", "git_time", "interrupted", "steps")
"""The fields by which a run's record says what was run: these say whose policy it is."""


def records_of(found: Verification, run: Path) -> list[Record]:
    """One record an agent that was verified, of the run in the folder `run`.

    Raises CompileError RUN701 if the run was not evaluated.
    """
    told = cast("dict[str, Json]", found.to_json())
    shared = {key: told[key] for key in ("goal", "policy", "method", "maximum", "walked")}
    trials = told["simulated"]
    if isinstance(trials, dict):
        shared["trials"] = {key: trials[key] for key in ("confidence", "horizon", "visits")}
    reasons = {c.seed: c.reason for c in found.counterexamples}
    agents = cast("list[dict[str, Json]]", told["agents"])
    by_seed = {agent["seed"]: agent for agent in agents}
    records = []
    for record in records_of_run(run):
        fields = record.fields
        agent = by_seed.get(fields["seed"])
        if agent is not None:
            named = {key: fields.get(key) for key in RUN}
            reason = reasons.get(cast("int", fields["seed"]))
            about = {**shared, "verified": agent, "reason": reason}
            records.append(Record.of({**named, **about, "schema_version": SCHEMA_VERSION}))
    return records

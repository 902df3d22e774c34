"""Demonstrations: read, write, record, and replay through the automaton."""

from tiloilc.demos.checks import check_replays, check_shape, is_needed
from tiloilc.demos.files import foreign_sidecar, load, save
from tiloilc.demos.model import Demo, DemoSet
from tiloilc.demos.recording import expert_names, play, record
from tiloilc.demos.replay import Labels, Replay, best_run, replay, replay_all
from tiloilc.demos.sources import as_wanted, bundled, demonstrations_for, record_best

__all__ = [
    "Demo",
    "DemoSet",
    "Labels",
    "Replay",
    "as_wanted",
    "best_run",
    "bundled",
    "check_replays",
    "check_shape",
    "demonstrations_for",
    "expert_names",
    "foreign_sidecar",
    "is_needed",
    "load",
    "play",
    "record",
    "record_best",
    "replay",
    "replay_all",
    "save",
]

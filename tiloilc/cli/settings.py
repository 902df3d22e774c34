"""Settings of the command line: `--set NAME=VALUE`, of training and of demonstrations."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from tiloilc.cli.console import fail, report, say

if TYPE_CHECKING:
    from tiloilc.plan import Plan
    from tiloilc.spec.laid import Laid
    from tiloilc.spec.settings import Settings


def settings_given(
    pairs: Sequence[str],
    steps: str | None,
    seeds: int | None,
    device: str | None = None,
    option: str = "--set",
) -> dict[str, object]:
    """The settings of the command line: `--set K=V` and those that have options of their own.

    Raises Exit 2 for what is no pair, and for a setting that is given both ways.
    """
    changes: dict[str, object] = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals:
            raise fail(f"{option} needs NAME=VALUE, not `{pair}`")
        changes[key.strip()] = _value(text.strip())
    options: dict[str, object] = {"steps": steps, "seeds": seeds, "device": device}
    for name, value in options.items():
        if value is None:
            continue
        if name in changes:
            raise fail(f"`{name}` is given twice: by {option} and by --{name}")
        changes[name] = value
    return changes


def checked(changes: Mapping[str, object]) -> Mapping[str, object]:
    """Settings of training and of demonstrations as they take them, without the seeds.

    Raises Exit 2 for names and values that no setting takes, and for those that exclude each other.
    """
    from pydantic import ValidationError

    from tiloilc.spec import refusal
    from tiloilc.spec.laid import exclusive
    from tiloilc.sweep import Changes, given

    known_settings(changes)
    names = list(changes)
    for one, other in exclusive(names):
        raise fail(f"`{names[one]}` and `{names[other]}` exclude each other")
    try:
        return given(Changes.model_validate(changes))
    except ValidationError as error:
        raise fail(f"setting {refusal(error)}") from None


def demonstrations_given(settings: dict[str, object]) -> Laid:
    """Those of demonstrations, which are taken out of `settings`. Raises Exit 2 as `checked`."""
    from tiloilc.spec.laid import PREFIX, Laid

    known_settings(settings)
    names = [name for name in settings if name.startswith(PREFIX)]
    values = checked({name: settings.pop(name) for name in names})
    return Laid(values, dict.fromkeys(names))


def known_settings(changes: Iterable[str], compiled: bool = False) -> None:
    """Raises Exit 2 for a name that is no setting, or none of a plan that is compiled."""
    from tiloilc.diag import did_you_mean
    from tiloilc.spec.laid import DEMO_FIELDS, PREFIX
    from tiloilc.spec.settings import Settings

    known = sorted({**Settings.model_fields, **DEMO_FIELDS})
    for name in changes:
        if compiled and name.startswith(PREFIX):
            hint = f"compile them anew: tiloilc run SPEC --set {name}=…"
            raise fail(f"`{name}`: a compiled plan has its demonstrations already; {hint}")
        if name not in known:
            hint = did_you_mean(name, known)
            raise fail(f"no setting `{name}`" + (f"; {hint}" if hint else ""))


def _value(text: str) -> object:
    """What a value means in YAML: lists, booleans, numbers; else the text itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def changed(plan: Plan, changes: Mapping[str, object], quiet: bool) -> Settings:
    """The settings of a plan with changes; says what is strange about them, unless `quiet`.

    Raises CompileError with what is wrong with them, and Exit 2 for names and values that no
    setting of training takes.
    """
    from pydantic import ValidationError

    from tiloilc.diag import CompileError, Severity
    from tiloilc.driver import doubtful_findings, settings_findings
    from tiloilc.spec import refusal

    known_settings(changes, compiled=True)
    try:
        settings = plan.train.override(changes)
    except ValidationError as error:
        raise fail(f"setting {refusal(error)}") from None
    found = [
        *settings_findings(settings, plan.demonstrations),
        *doubtful_findings(settings, plan.ldba, plan.stages),
    ]
    if any(diagnostic.severity is Severity.ERROR for diagnostic in found):
        raise CompileError(*found)
    if not quiet:
        report(found)
    if settings.preset != plan.train.preset and (kept := _kept(settings, changes)):
        say(f"preset {settings.preset}, but as the task file sets them: {kept}", quiet)
    return settings


def _kept(settings: Settings, changes: Mapping[str, object]) -> str:
    """What the task file sets otherwise than the preset, in words, without `changes`."""
    from tiloilc.sweep.model import OWN

    kept = {k: v for k, v in settings.overrides().items() if k not in (*changes, *OWN)}
    return ", ".join(f"{name} {json.dumps(value)}" for name, value in kept.items())

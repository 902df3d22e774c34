"""`tiloilc init`: a new task folder that lints clean and trains."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Annotated

import typer

from tiloilc.cli.console import Quiet, fail, say

if TYPE_CHECKING:
    from tiloilc.spec import SpecFile

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the task and of its folder.")],
    source: Annotated[
        str | None,
        typer.Option("--from", metavar="SPEC", help="A task file, or the name of a bundled one."),
    ] = None,
    env: Annotated[
        str | None,
        typer.Option("--env", metavar="ID", help="A Gymnasium environment: Id-v0, module:Id-v0."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write a new task folder, ready to be trained.

    It holds a task file, an environment to be replaced by your own, and a README. With --env, the
    task is in an environment that exists: its fields are named, and there is a place for an expert.
    With --from, the task file is a copy of another one, together with the files that it names.
    """
    from tiloilc.spec import MAX_NAME, NAME_SIGNS

    if source is not None and env is not None:
        raise fail("give --from or --env, not both")
    folder = Path(name)
    if not NAME.fullmatch(folder.name) or len(folder.name) > MAX_NAME:
        can = f"at most {MAX_NAME} {NAME_SIGNS}"
        raise fail(f"`{folder.name}` cannot name a task: {can}")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise fail(f"`{folder.as_posix()}` is there already")
    if env is not None:
        from tiloilc.cli.wrapping import wrapped

        written = wrapped(folder.name, env)
    else:
        written = _fresh(folder.name) if source is None else _copied(folder.name, source)
    for path, content in written.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        say(f"wrote {target.as_posix()}", quiet)
    say(f"next: tiloilc run {(folder / f'{folder.name}.yaml').as_posix()}", quiet)


def _fresh(name: str) -> dict[str, bytes]:
    """The files of a task of our own, by name."""
    words = re.sub(r"\W", "_", name)
    about = {
        "name": name,
        "module": f"{'_' if words[0].isdigit() else ''}{words}_environment",
        "env_id": f"{''.join(word.capitalize() for word in re.split('[-_.]+', name))}-v0",
        "spec": f"{name}.yaml",
    }
    about["environment"] = f"`{about['module']}.py` is\nthe environment: replace it by your own."
    return {
        about["spec"]: _template("task.yaml.in", about),
        f"{about['module']}.py": _template("environment.py.in", about),
        "README.md": _template("README.md.in", about),
    }


def _copied(name: str, source: str) -> dict[str, bytes]:
    """The files of a copy of the task file `source`, by name."""
    from tiloilc.spec import read_spec

    path = Path(source)
    if not path.is_file():
        path = Path(str(files("tiloilc.specs"))) / f"{source}.yaml"
    if not path.is_file():
        raise fail(f"there is no task file `{source}`, and none of this name is bundled")
    spec_file = read_spec(path)
    place = spec_file.span("name")
    lines = spec_file.text.split("\n")
    line = lines[place.line - 1]
    lines[place.line - 1] = line[: place.column - 1] + name + line[place.end_column - 1 :]
    spec = f"{name}.yaml"
    environment = "The environment is that of the task it was copied from."
    about = {"name": name, "spec": spec, "environment": environment}
    return {
        spec: "\n".join(lines).encode(),
        "README.md": _template("README.md.in", about),
        **_named(spec_file),
    }


def _named(spec_file: SpecFile) -> dict[str, bytes]:
    """The files that a task file names, as far as they are in its folder."""
    from tiloilc.driver.environment import source_of
    from tiloilc.spec import PythonPredicate

    spec, root = spec_file.spec, spec_file.path.parent
    names = [
        p.python.rpartition(":")[0]
        for p in spec.propositions.values()
        if isinstance(p, PythonPredicate)
    ]
    if spec.demonstrations is not None and spec.demonstrations.file is not None:
        demos = Path(spec.demonstrations.file)
        names += [demos.as_posix(), demos.with_suffix(".json").as_posix()]
    names += [spec.automaton] if spec.automaton is not None else []
    names += re.findall(r"^# yaml-language-server: \$schema=(\S+)$", spec_file.text, re.MULTILINE)
    own = source_of(spec.environment, root)
    names += [own.relative_to(root).as_posix()] if own is not None else []
    inside = [n for n in sorted(set(names)) if not Path(n).is_absolute() and ".." not in n]
    return {n: (root / n).read_bytes() for n in inside if (root / n).is_file()}


def _template(file: str, about: dict[str, str]) -> bytes:
    text = (files("tiloilc.cli") / "templates" / file).read_text(encoding="utf-8")
    return Template(text).substitute(about).encode()

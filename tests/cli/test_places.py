"""`viz --env` and `eval --video`, from the command line to the file."""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import pytest
from PIL import Image

from tests.cli.running import Run, runner

SILENT = """\
import gymnasium
import numpy as np
from gymnasium.spaces import Box
{imports}

class {name}(gymnasium.Env):
    metadata = {{"render_modes": ["rgb_array"], "render_fps": 20}}
    observation_space = Box(-2.0, 2.0, (3,))
    action_space = Box(-1.0, 1.0, (2,))

    def __init__(self, render_mode=None):
        self.render_mode = render_mode

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at = np.zeros(3, np.float32)
        return self.at.copy(), {{}}

    def step(self, action):
        self.at[:2] = np.clip(self.at[:2] + 0.2 * np.asarray(action), -2, 2)
        return self.at.copy(), 0.0, False, False, {{}}
{methods}

gymnasium.register("{name}-v0", entry_point={name})
"""

RENDER = """
    def render(self):
        {body}
"""

SCENE = """
    def scene(self):
        return Scene((-2.0, -2.0, 2.0, 2.0), (Circle("a", "#4caf6d", (1.5, 0.0), 0.5),))
"""

TASK = """\
name: go
environment:
  id: {module}:{name}-v0
  horizon: 12
observation:
  pos: [0, 2]
propositions:
  a: pos[0] > 0.9
formula: "F a"
demonstrations:
  file: go.npz
train:
  steps: 60
  seeds: 1
  learning_starts: 40
"""

GO = "def go(generator):\n    return lambda observation: [1.0, 0.3]\n"


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(capsys)


def world(name: str, body: str = "", scene: bool = False) -> str:
    """A task in a world of one's own, in this folder, with demonstrations; its file."""
    methods = (RENDER.format(body=body) if body else "") + (SCENE if scene else "")
    imports = "from tiloilc.tasks import Circle, Scene\n" if scene else ""
    module = f"{name.lower()}_world"
    text = SILENT.format(name=name, imports=imports, methods=methods)
    Path(f"{module}.py").write_text(text, encoding="utf-8")
    Path("go.yaml").write_text(TASK.format(module=module, name=name), encoding="utf-8")
    Path("go.py").write_text(GO, encoding="utf-8")
    return "go.yaml"


GREY = "return np.full((40, 90, 3), 90, np.uint8)"
FAILS = "raise RuntimeError('no screen')"


def test_an_environment_is_printed_as_svg_or_written_by_its_suffix(
    run: Run, root: Path, workdir: Path
) -> None:
    spec = root / "specs" / "flatworld_cycle.yaml"
    status, out, err = run("viz", "--env", spec)
    assert (status, err) == (0, "")
    assert ElementTree.fromstring(out).tag.endswith("svg")
    assert run("viz", "--env", spec, "-o", "a/flat.png")[::2] == (0, "wrote a/flat.png\n")
    assert Image.open(BytesIO(Path("a/flat.png").read_bytes())).size[0] == 1440
    status, other, _ = run("viz", "--env", spec, "--demo", 3)
    assert status == 0
    assert other != out
    assert run("viz", "--env", spec, "--demo", 5)[0] == 2
    assert run("viz", "--env", spec, "-o", "flat.dot")[0] == 2


def test_several_tasks_make_a_sheet(run: Run, root: Path, workdir: Path) -> None:
    names = ["flatworld_cycle", "grid_circular_easy"]
    specs = [root / "specs" / f"{name}.yaml" for name in names]
    status, out, _ = run("viz", "--env", *specs)
    assert status == 0
    assert all(f">{name}</text>" in out for name in names)
    assert run("viz", *specs)[0] == 2, "automata are drawn one at a time"


def test_an_automaton_has_no_environment(run: Run) -> None:
    assert run("viz", "--env", "F a")[0] == 2


def test_an_environment_with_frames_alone_is_shown_by_them(run: Run, workdir: Path) -> None:
    spec = world("Framed", GREY)
    assert run("demos", "record", spec, "--expert", "go.py:go")[0] == 0
    status, out, err = run("viz", "--env", spec)
    assert status == 0, err
    root = ElementTree.fromstring(out)
    assert len([e for e in root.iter() if e.tag.endswith("image")]) == 3
    assert "demonstration 0 by `go.py:go`: 12 steps, 8 accepting visits" in out


def test_an_environment_that_cannot_show_itself_is_a_finding(run: Run, workdir: Path) -> None:
    spec = world("Silent", FAILS)
    run("demos", "record", spec, "--expert", "go.py:go")
    status, out, err = run("viz", "--env", spec)
    assert (status, out) == (1, "")
    assert err.startswith("error[JOB611]: cannot draw `silent_world:Silent-v0`")
    assert "no screen" in err


def test_a_map_is_drawn_where_frames_fail(run: Run, workdir: Path) -> None:
    spec = world("Mapped", FAILS, scene=True)
    run("demos", "record", spec, "--expert", "go.py:go")
    status, out, err = run("viz", "--env", spec)
    assert status == 0, err
    assert "polyline" in out


@pytest.mark.parametrize(
    ("name", "body", "scene", "said"),
    [
        ("FilmedFrames", GREY, False, ""),
        ("FilmedMap", FAILS, True, "its map is drawn: no screen"),
        ("FilmedNothing", FAILS, False, "error[RUN711]: cannot film"),
    ],
)
def test_a_policy_is_filmed_with_what_there_is(
    name: str, body: str, scene: bool, said: str, run: Run, workdir: Path
) -> None:
    spec = world(name, body, scene)
    assert run("demos", "record", spec, "--expert", "go.py:go")[0] == 0
    assert run("compile", spec, "-q")[0] == 0
    assert run("train", "build/go", "-q")[0] == 0
    status, out, err = run("eval", "runs/go/0001", "--episodes", 1, "--video")
    assert "best by validation, greedy" in out
    assert said in err
    assert "Traceback" not in err
    film = Path("runs/go/0001/video.gif")
    if name == "FilmedNothing":
        assert status == 1
        assert not film.exists()
        return
    assert status == 0
    assert Image.open(BytesIO(film.read_bytes())).n_frames == 13  # type: ignore[attr-defined]
    if body == GREY:
        assert run("eval", "runs/go/0001", "--episodes", 1, "--video", "-o", "a.mp4")[0] == 0
        import imageio_ffmpeg

        frames = imageio_ffmpeg.read_frames("a.mp4")
        assert next(frames)["fps"] == 20
        frames.close()


def test_what_cannot_be_filmed_is_said_before_evaluating(
    run: Run, workdir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (workdir / "run").mkdir()
    assert run("eval", "run", "--video", "-o", "film.avi")[0] == 2
    assert run("eval", "run", "-o", "film.gif")[0] == 2
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    status, _, err = run("eval", "run", "--video", "-o", "film.mp4")
    assert status == 1
    assert "pip install 'tiloilc[video]', or write a .gif" in err


def test_two_numbers_are_drawn_as_a_plane_where_there_is_no_map(run: Run, workdir: Path) -> None:
    spec = world("Plane", FAILS)
    code = Path("plane_world.py").read_text(encoding="utf-8")
    Path("plane_world.py").write_text(code.replace("(3,)", "(2,)").replace("zeros(3", "zeros(2"))
    assert run("demos", "record", spec, "--expert", "go.py:go")[0] == 0
    status, out, err = run("viz", "--env", spec)
    assert status == 0, err
    assert "pos[0] →" in out
    assert "pos[1] ↑" in out
    assert ">a</text>" in out
    assert "polyline" in out

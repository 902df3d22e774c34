import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.driver.specs import ENVIRONMENT, spec
from tiloilc.diag import Diagnostic, Severity
from tiloilc.driver import lint


def codes(found: list[Diagnostic]) -> list[str]:
    return [d.code for d in found]


def excerpt(path: Path, finding: Diagnostic) -> str:
    """The characters that a finding on one line points at."""
    assert finding.span is not None
    line = path.read_text(encoding="utf-8").split("\n")[finding.span.line - 1]
    return line[finding.span.column - 1 : finding.span.end_column - 1]


def test_a_good_task_file_has_no_findings(tmp_path: Path) -> None:
    assert lint(spec(tmp_path)) == []


def test_every_bundled_task_file_is_without_errors_and_warnings(root: Path) -> None:
    specs = sorted((root / "specs").glob("*.yaml"))
    assert len(specs) >= 12
    found = {path.name: lint(path) for path in specs}
    assert not {n: f for n, f in found.items() if any(d.severity is not Severity.NOTE for d in f)}


FORMULA = '"G F r & G !y & G !b"'


@pytest.mark.parametrize(
    ("old", "new", "code", "at"),
    [
        (FORMULA, '"G F r & G !yy & G !b"', "LTL203", "yy"),
        (FORMULA, '"G F r & G & G !b"', "LTL201", None),
        (FORMULA, '"G F r & G !b"', "LTL204", "y"),
        (FORMULA, '"F r & G !r & F (y & b)"', "LTL210", '"F r & G !r & F (y & b)"'),
        (FORMULA, '"F r | G !r | y | b"', "LTL211", '"F r | G !r | y | b"'),
        (FORMULA, '"G F r & F (r | y) & G !b"', "LTL212", "F (r | y)"),
        (FORMULA, '"G F (r & X F y) & G !b"', "LTL215", "G F (r & X F y)"),
        (FORMULA, '"F G y & G !b & F r"', "AUT301", '"F G y & G !b & F r"'),
        (FORMULA, '"F r & F y & G !b"', "PLAN405", '"F r & F y & G !b"'),
        ("steps: 10_000", "steps: 10_000\n  beta: 1/2", "PLAN404", "1/2"),
        ("steps: 10_000", "steps: 10_000\n  backbone: tabular", "JOB604", "tabular"),
        ("steps: 10_000", "steps: 10_000\n  first_seed: 2147483647", "JOB604", "2147483647"),
        ("steps: 10_000", "steps: 2_000", "JOB609", "2_000"),
        ("steps: 10_000", "steps: 10_000\n  sink_reward: -0.1", "JOB605", "-0.1"),
        ("steps: 10_000", "steps: 10_000\n  entropy: 1.5", "JOB605", "1.5"),
        ("steps: 10_000", "steps: 10_000\n  tau: 1e-5", "JOB605", "1e-5"),
        ("FlatWorld-v0", "FlatWrld-v0", "JOB600", "tiloilc/FlatWrld-v0"),
        ("  horizon: 50", "  horizon: 50\n  kwargs: {dt: 1, x: 2}", "JOB600", "kwargs"),
        ("norm(pos)", "norm(posi)", "SPEC111", "posi"),
        ("norm(pos)", "pos", "SPEC112", None),
        ("propositions:", "observation: {pos: [0, 9]}\npropositions:", "SPEC120", None),
        ("train:", "demonstrations: {file: none.npz}\ntrain:", "DEMO500", None),
        ("name: task", "nam: task", "SPEC101", "nam"),
    ],
)
def test_a_fault_is_found_and_placed(
    tmp_path: Path, old: str, new: str, code: str, at: str | None
) -> None:
    path = spec(tmp_path, (old, new))
    found = [d for d in lint(path) if d.code == code]
    assert found, codes(lint(path))
    if at is not None:
        assert excerpt(path, found[0]).strip() == at


SHOWN = "demonstrations: {source: expert, count: 2, actions: inferred}\ntrain:"
NETWORKS = ("train:", SHOWN)
ON_A_GRID = [
    ("tiloilc/FlatWorld-v0", "tiloilc/GridSequential-v0"),
    ("dist(pos, [0.45, -0.75]) < 0.3", "x > 3"),
    ("norm(pos) < 0.8", "y > 3"),
    ("dist(pos, [-0.85, 0.15]) < 0.3", "x < 1"),
]


@pytest.mark.parametrize(
    ("changes", "settings", "code", "at"),
    [
        ([], ["exact_entry: false", "end_on_sink: false"], "JOB604", None),
        ([], ["accepting_target: segment", "preset: paper"], "JOB604", "segment"),
        ([NETWORKS], ["algorithm: gail", "end_on_sink: true"], "JOB604", "true"),
        ([NETWORKS], ["algorithm: sqil", "demo_replay: 0"], "JOB604", "0"),
        ([], ["algorithm: drl2", "epsilon: step"], "JOB604", "step"),
        ([], ["algorithm: cycler", "epsilon: step"], "JOB604", "step"),
        ([], ["algorithm: cloning"], "JOB604", "cloning"),
        ([("train:", SHOWN.replace("inferred", "none"))], ["algorithm: cloning"], "JOB604", None),
        ([*ON_A_GRID, NETWORKS], ["algorithm: cloning"], "JOB604", "cloning"),
        ([NETWORKS], ["learning_starts: 0"], "JOB604", "0"),
        ([NETWORKS], ["demo_replay: 0", "warm_start_steps: 7"], "JOB605", "7"),
    ],
)
def test_settings_that_teach_nothing_of_something_are_found(
    tmp_path: Path, changes: list[tuple[str, str]], settings: list[str], code: str, at: str | None
) -> None:
    lines = "\n  ".join(["steps: 10_000", *settings])
    path = spec(tmp_path, *changes, ("steps: 10_000", lines))
    found = [d for d in lint(path) if d.code in ("JOB604", "JOB605")]
    assert codes(found) == [code], found
    if at is not None:
        assert excerpt(path, found[0]).strip() == at


@pytest.mark.parametrize(
    ("changes", "settings"),
    [
        ([], ["preset: paper"]),
        ([], ["segment: false", "exact_entry: false", "end_on_sink: false"]),
        ([], ["algorithm: lcer", "epsilon: step", "exact_entry: false", "end_on_sink: false"]),
        ([NETWORKS], ["algorithm: cloning"]),
        ([NETWORKS], ["algorithm: cloning", "demo_replay: 0"]),
        ([NETWORKS], ["demo_replay: 0", "warm_start_steps: 0"]),
        ([NETWORKS], ["demo_replay: 0", "warm_start: none", "learning_starts: 0"]),
        ([*ON_A_GRID, NETWORKS], ["learning_starts: 0"]),
    ],
)
def test_settings_that_differ_but_can_be_learned_by_are_not_found_fault_with(
    tmp_path: Path, changes: list[tuple[str, str]], settings: list[str]
) -> None:
    path = spec(tmp_path, *changes, ("steps: 10_000", "\n  ".join(["steps: 10_000", *settings])))
    assert not {"JOB604", "JOB600", "SPEC101", "SPEC111"} & set(codes(lint(path)))


STEPS = "steps: 10_000\n  epsilon: step\n  accepting_target: "
STAY = (FORMULA, '"F G r & G !y & G !b"')


@pytest.mark.parametrize(("kind", "said"), [("constant", True), ("live", False)])
def test_jumping_at_once_is_named_where_it_would_be_best(
    tmp_path: Path, kind: str, said: bool
) -> None:
    path = spec(tmp_path, STAY, ("steps: 10_000", STEPS + kind))
    found = [d for d in lint(path) if d.code == "JOB605"]
    assert [excerpt(path, d).strip() for d in found] == ["step"] * said


def test_settings_are_doubted_only_where_they_matter(tmp_path: Path) -> None:
    """No sink, no temperature on a table's maxima, no target network on a table."""
    without_sink = (FORMULA, '"G F (r & X F y) & G F b"')
    changes = ("steps: 10_000", "steps: 10_000\n  sink_reward: 0")
    assert "JOB605" not in codes(lint(spec(tmp_path, without_sink, changes)))
    changes = ("steps: 10_000", "steps: 10_000\n  tau: 1e-5")
    found = codes(lint(spec(tmp_path, changes, *ON_A_GRID)))
    assert not {"JOB605", "JOB600", "SPEC111"} & set(found)


def test_independent_faults_are_found_in_one_run_sorted_by_place(tmp_path: Path) -> None:
    path = spec(
        tmp_path,
        ("FlatWorld-v0", "FlatWrld-v0"),
        ("norm(pos) < 0.8", "norm(pos < 0.8"),
        ('"G F r', '"G F q'),
        ("steps: 10_000", "steps: 10_000\n  beta: 0.7\n  sead: 3"),
    )
    found = lint(path)
    assert {"JOB600", "SPEC110", "LTL203", "SPEC101"} <= set(codes(found))
    assert found == sorted(found, key=Diagnostic.sort_key)


def test_a_misspelt_environment_is_guessed(tmp_path: Path) -> None:
    (finding,) = lint(spec(tmp_path, ("FlatWorld-v0", "FlatWrld-v0")))
    assert "tiloilc/FlatWorld-v0" in finding.help


def test_unknown_fields_are_not_blamed_when_the_environment_is_at_fault(tmp_path: Path) -> None:
    assert codes(lint(spec(tmp_path, ("FlatWorld-v0", "FlatWrld-v0")))) == ["JOB600"]


def test_a_module_that_cannot_be_imported_says_so(tmp_path: Path) -> None:
    (finding,) = lint(spec(tmp_path, ("tiloilc/FlatWorld-v0", "no_such_module:X-v0")))
    assert finding.code == "JOB600"
    assert "import no_such_module" in finding.message


def test_a_robot_without_its_package_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tiloilc.tasks.robots.fetch import tray

    tray._with_tray.cache_clear()
    monkeypatch.setattr("tiloilc.tasks.robots.fetch.arm.find_spec", lambda name: None)
    (finding,) = lint(spec(tmp_path, ("FlatWorld-v0", "FetchPlaceTray-v0")))
    assert finding.code == "JOB600"
    assert finding.message.endswith("gymnasium-robotics is not installed")
    assert finding.help == "pip install 'tiloilc[mujoco]'"


def test_without_mujoco_a_robot_says_what_to_install(tmp_path: Path) -> None:
    task = spec(tmp_path, ("FlatWorld-v0", "FetchPlaceTray-v0"))
    code = (
        "import sys; sys.modules['mujoco'] = None\n"
        "from pathlib import Path; from tiloilc.driver import lint\n"
        "print(*((d.message, d.help) for d in lint(Path(sys.argv[1]))))"
    )
    done = subprocess.run([sys.executable, "-c", code, task], capture_output=True, text=True)
    assert "mujoco is not installed" in done.stdout
    assert "pip install 'tiloilc[mujoco]'" in done.stdout


def test_an_environment_beside_the_task_file_publishes_fields_and_keys(tmp_path: Path) -> None:
    (tmp_path / "own_place.py").write_text(ENVIRONMENT, encoding="utf-8")
    path = spec(
        tmp_path,
        ("tiloilc/FlatWorld-v0", "own_place:Own-v0"),
        ("dist(pos, [0.45, -0.75]) < 0.3", "norm(place) < 0.3 and speed > 0"),
        ("dist(pos, [-0.85, 0.15]) < 0.3", "second[0] < 0"),
        ("norm(pos) < 0.8", "late < 1"),
        ("propositions:", "observation: {late: 2}\npropositions:"),
    )
    assert codes(lint(path)) == ["JOB601"]


def test_a_formula_bomb_ends_in_a_diagnostic(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tiloilc.driver import formula

    real = formula.translate
    monkeypatch.setattr(formula, "translate", lambda f, p, **_: real(f, p, max_states=2))
    found = lint(spec(tmp_path, (FORMULA, '"G F r & G F y & F b"')))
    assert "AUT305" in codes(found)
    assert all(d.span is not None for d in found)


def test_no_names_are_unknown_where_no_propositions_could_be_read(tmp_path: Path) -> None:
    path = tmp_path / "task.yaml"
    path.write_text("name: x\npropositions: []\nformula: F a\n", encoding="utf-8")
    assert not {"LTL203", "LTL204"} & set(codes(lint(path)))


def test_a_missing_file_is_a_finding(tmp_path: Path) -> None:
    assert codes(lint(tmp_path / "none.yaml")) == ["SPEC105"]


def test_demonstrations_are_replayed(tmp_path: Path) -> None:
    change = ("train:", "demonstrations: {source: expert, count: 2}\ntrain:")
    found = lint(spec(tmp_path, change, ("[0.45, -0.75]", "[1.9, 1.9]")))
    assert "DEMO501" in codes(found)


def test_python_predicates_are_found_beside_the_task_file(tmp_path: Path) -> None:
    (tmp_path / "labels.py").write_text(
        "def near(seen):\n    return (seen**2).sum(-1) < 0.64\n", encoding="utf-8"
    )
    good = spec(tmp_path, ("norm(pos) < 0.8", '{python: "labels.py:near"}'))
    assert lint(good) == []
    bad = spec(tmp_path, ("norm(pos) < 0.8", '{python: "labels.py:neat"}'))
    (finding,) = lint(bad)
    assert finding.code == "SPEC117"
    assert excerpt(bad, finding) == "labels.py:neat"


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        (FORMULA, "[a]", "SPEC1"),
        (FORMULA, "{a: b}", "SPEC1"),
        (FORMULA, '""', "SPEC103"),
        ("norm(pos) < 0.8", "{python: [1]}", "SPEC103"),
        ("b: norm(pos) < 0.8", "b:", "SPEC103"),
    ],
)
def test_a_value_of_the_wrong_kind_is_one_finding(
    tmp_path: Path, old: str, new: str, code: str
) -> None:
    found = [d for d in lint(spec(tmp_path, (old, new))) if d.severity is Severity.ERROR]
    assert [d.code[: len(code)] for d in found] == [code]


TROUBLE = """\
import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete

class Base(gymnasium.Env):
    observation_space = Box(-1, 1, (2,))
    action_space = Box(-1, 1, (1,))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(2, np.float32), {}

    def step(self, action):
        return np.zeros(2, np.float32), 0.0, False, False, {}

class Raises(Base):
    def step(self, action):
        raise KeyError("missing")

class Old(Base):
    def step(self, action):
        return np.zeros(2, np.float32), 0.0, False, {}

class Wide(Base):
    def step(self, action):
        return np.zeros(3, np.float32), 0.0, False, False, {}

class Exits(Base):
    def __init__(self):
        raise SystemExit(3)

class Fields(Base):
    observation_fields = {"far": 7}

class Listed(Base):
    observation_fields = ["far"]

class Fixed(Base):
    action_space = Box(np.array([0, 1], np.float32), np.array([1, 1], np.float32))

class Numbered(Base):
    action_space = Discrete(2)

class Picture(Numbered):
    observation_space = Box(0, 255, (8, 8, 3), np.uint8)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros((8, 8, 3), np.uint8), {}

    def step(self, action):
        return np.zeros((8, 8, 3), np.uint8), 0.0, False, False, {}

for kind in (Raises, Old, Wide, Exits, Fields, Listed, Fixed, Numbered, Picture):
    gymnasium.register(kind.__name__ + "-v0", entry_point=kind)
"""


@pytest.mark.parametrize(
    ("name", "code", "said"),
    [
        ("Raises", "JOB600", "`step()` fails: KeyError: 'missing'"),
        ("Old", "JOB600", "`step()` fails"),
        ("Wide", "JOB600", "an observation of 3 numbers, not 2"),
        ("Exits", "JOB600", "it ends the program"),
        ("Fields", "JOB600", "`far` is outside the 2 components"),
        ("Listed", "JOB600", "observation_fields"),
        ("Fixed", "JOB602", "actions that cannot vary"),
        ("Numbered", "JOB608", "Discrete(2)"),
        ("Picture", "JOB608", "uint8"),
    ],
)
def test_what_training_would_stumble_over_is_found_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, code: str, said: str
) -> None:
    monkeypatch.delitem(sys.modules, "trouble", raising=False)
    (tmp_path / "trouble.py").write_text(TROUBLE, encoding="utf-8")
    path = spec(
        tmp_path,
        ("tiloilc/FlatWorld-v0", f"trouble:{name}-v0"),
        ("propositions:", "observation: {pos: [0, 2]}\npropositions:"),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # each test registers them anew
        (finding,) = [d for d in lint(path) if d.severity is Severity.ERROR]
    assert finding.code == code
    assert said in finding.message
    assert excerpt(path, finding) == f"trouble:{name}-v0"


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("raise ValueError('bad')", "it raised ValueError: bad"),
        ("return observations[:, 0]", "it returned float64 [4] for observations [4, 2]"),
        ("return True", "it returned bool []"),
        ("observations[:] = 0", "read-only"),
        ("raise SystemExit(5)", "it raised SystemExit"),
    ],
)
def test_a_python_predicate_is_tried(tmp_path: Path, body: str, said: str) -> None:
    text = f"def near(observations):\n    {body}\n"
    (tmp_path / "near.py").write_text(text, encoding="utf-8")
    path = spec(tmp_path, ("norm(pos) < 0.8", '{python: "near.py:near"}'))
    (finding,) = lint(path)
    assert finding.code == "SPEC117"
    assert said in finding.message
    assert excerpt(path, finding) == "near.py:near"


ARM = """\
import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete

class Arm(gymnasium.Env):
    def __init__(self, table=False):
        self.observation_space = MultiDiscrete([3, 3]) if table else Box(-9, 9, (2,))
        self.action_space = Discrete(4) if table else Box(-1, 1, (2,))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.ones(2, self.observation_space.dtype), {}

    def step(self, action):
        return np.ones(2, self.observation_space.dtype), 0.0, False, False, {}

gymnasium.register("Arm-v0", entry_point=Arm)
"""


@pytest.mark.parametrize(
    ("table", "states", "actions", "said"),
    [
        (False, 0.5, np.zeros((4, 2)), ""),
        (False, 0.5, np.full((4, 2), 1.0005), ""),
        (False, 0.5, np.zeros((4, 5)), "its actions have shape [5], not [2]"),
        (False, 0.5, np.zeros(4), "its actions have shape [], not [2]"),
        (False, 0.5, np.full((4, 2), 1.5), "within the bounds"),
        (True, 2.0, np.full(4, 3), ""),
        (True, 2.0, np.full(4, 4), "among 0 to 3"),
        (True, 2.0, np.full(4, 0.5), "among 0 to 3"),
        (True, 3.0, np.full(4, 3), "its states"),
        (True, 0.5, np.full(4, 3), "its states"),
    ],
)
def test_demonstrations_lie_in_the_spaces_of_the_environment(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    table: bool,
    states: float,
    actions: np.ndarray,
    said: str,
) -> None:
    monkeypatch.delitem(sys.modules, "arm", raising=False)
    (tmp_path / "arm.py").write_text(ARM, encoding="utf-8")
    np.savez(tmp_path / "d.npz", observations_0=np.full((5, 2), states), actions_0=actions)
    path = spec(
        tmp_path,
        ("tiloilc/FlatWorld-v0", f"arm:Arm-v0\n  kwargs: {{table: {str(table).lower()}}}"),
        ("propositions:", "observation: {pos: [0, 2]}\npropositions:"),
        ("train:", "demonstrations: {file: d.npz, actions: recorded}\ntrain:"),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # each test registers it anew
        found = [d for d in lint(path) if d.severity is Severity.ERROR]
    assert [d.code for d in found] == (["DEMO507"] if said else [])
    assert all(said in d.message and excerpt(path, d) == "d.npz" for d in found)

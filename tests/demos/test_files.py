import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tiloilc.demos import Demo, DemoSet, load, save
from tiloilc.diag import CompileError


def demo(steps: int, d: int = 3, actions: bool = True, seed: int = 0) -> Demo:
    generator = np.random.default_rng(seed)
    observations = generator.normal(size=(steps + 1, d)).astype(np.float32)
    taken = generator.normal(size=(steps, 2)).astype(np.float32) if actions else None
    return Demo(observations, taken)


def some() -> DemoSet:
    meta = {
        "environment": {"id": "x/Y-v0", "kwargs": {}},
        "seeds": [4, 5],
        "fields": {"pos": [0, 2]},
    }
    return DemoSet((demo(5), demo(7, seed=1)), meta)


def problem(path: Path) -> str:
    with pytest.raises(CompileError) as raised:
        load(path)
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.code == "DEMO500"
    assert path.as_posix() in diagnostic.message
    return diagnostic.message


def test_what_is_saved_is_loaded(workdir: Path) -> None:
    save("d.npz", some())
    loaded = load("d.npz")
    assert len(loaded) == 2
    for ours, theirs in zip(some().episodes, loaded.episodes, strict=True):
        np.testing.assert_array_equal(ours.observations, theirs.observations, strict=True)
        assert ours.actions is not None
        assert theirs.actions is not None
        np.testing.assert_array_equal(ours.actions, theirs.actions, strict=True)
    assert loaded.meta == {**some().meta, "schema_version": 1, "steps": [5, 7]}


def test_equal_values_give_equal_bytes(workdir: Path) -> None:
    save("a.npz", some())
    save("b.npz", load("a.npz"))
    assert Path("a.npz").read_bytes() == Path("b.npz").read_bytes()
    assert Path("a.json").read_bytes() == Path("b.json").read_bytes()
    assert sorted(p.name for p in workdir.iterdir()) == ["a.json", "a.npz", "b.json", "b.npz"]


def test_an_archive_does_not_take_the_name_of_its_sidecar(workdir: Path) -> None:
    with pytest.raises(AssertionError, match="sidecar"):
        save("d.json", some())
    assert not list(workdir.iterdir())


def test_numpy_reads_the_archive_without_pickles(workdir: Path) -> None:
    save("d.npz", some())
    with np.load("d.npz", allow_pickle=False) as archive:
        assert sorted(archive) == ["actions_0", "actions_1", "observations_0", "observations_1"]
        assert archive["observations_1"].dtype == np.float32


def test_states_alone_are_enough(workdir: Path) -> None:
    save("d.npz", some().without_actions())
    assert not load("d.npz").has_actions
    assert some().has_actions


@pytest.mark.parametrize("compressed", [False, True])
def test_an_archive_written_by_hand_is_read(workdir: Path, compressed: bool) -> None:
    write = np.savez_compressed if compressed else np.savez
    write("many.npz", observations=np.zeros((4, 11, 2)), actions=np.zeros((4, 10, 1)))
    loaded = load("many.npz")
    assert [d.steps for d in loaded.episodes] == [10] * 4
    assert loaded.episodes[0].observations.dtype == np.float32
    assert loaded.meta == {"schema_version": 1}
    write("one.npz", observations=np.asfortranarray(np.arange(12.0).reshape(6, 2)))
    np.testing.assert_array_equal(load("one.npz").episodes[0].observations[1], [2, 3])


def test_taking_some_takes_their_seeds_too() -> None:
    first = some().take(1)
    assert len(first) == 1
    assert first.meta["seeds"] == [4]


def test_a_head_keeps_the_first_steps_with_their_actions() -> None:
    head = demo(5).head(2)
    assert head.observations.shape == (3, 3)
    assert head.actions is not None
    assert head.actions.shape == (2, 2)
    assert demo(5).head(9).steps == 5


def test_a_missing_file_is_a_finding(workdir: Path) -> None:
    assert "No such file" in problem(Path("gone.npz"))


def test_a_file_that_is_no_archive_is_a_finding(workdir: Path) -> None:
    Path("d.npz").write_bytes(b"hello")
    assert "not a whole .npz archive" in problem(Path("d.npz"))


def test_a_folder_is_a_finding(workdir: Path) -> None:
    Path("d.npz").mkdir()
    assert "directory" in problem(Path("d.npz"))


@pytest.mark.parametrize(
    ("arrays", "says"),
    [
        ({"x": np.zeros(3)}, "no `observations_0`"),
        ({"observations_1": np.zeros((3, 2))}, "no `observations_0`"),
        ({"observations_0": np.zeros(3)}, "shape [3], not [T+1, d]"),
        ({"observations_0": np.zeros((0, 2))}, "shape [0, 2]"),
        ({"observations_0": np.array([[np.nan, 1.0]])}, "not finite"),
        ({"observations_0": np.array([[1e300, 1.0]])}, "not finite"),
        ({"observations_0": np.array([["a", "b"]])}, "does not hold numbers"),
        (
            {"observations_0": np.zeros((3, 2)), "observations_1": np.zeros((3, 4))},
            "different numbers of components: [2, 4]",
        ),
        (
            {"observations_0": np.zeros((3, 2)), "actions_0": np.zeros((3, 1))},
            "3 actions for 2 steps",
        ),
        (
            {"observations_0": np.zeros((2, 2)), "actions_0": np.array([[np.inf]])},
            "`actions_0` has entries that are not finite",
        ),
        ({"observations": np.zeros(())}, "single number"),
    ],
)
def test_arrays_that_do_not_fit_are_a_finding(
    workdir: Path, arrays: dict[str, np.ndarray], says: str
) -> None:
    np.savez("d.npz", **arrays)
    assert says in problem(Path("d.npz"))


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (["states", "actions"], "it has `states`, `actions`: call"),
        (["observations_1"], "it has `observations_1`: call"),
        (list("abcdef"), "it has `a`, `b`, `c`, `d`, …: call"),
        ([], "it has no arrays: call"),
    ],
)
def test_arrays_of_other_names_are_told_how_they_are_called(
    workdir: Path, names: list[str], found: str
) -> None:
    np.savez("d.npz", **{name: np.zeros((3, 2)) for name in names})
    with pytest.raises(CompileError) as raised:
        load("d.npz")
    help = raised.value.diagnostics[0].help
    assert help.startswith(found)
    assert "`observations_0`, `observations_1`, … (and `actions_0`, …)" in help


def test_pickled_arrays_are_refused(workdir: Path) -> None:
    np.savez("d.npz", observations_0=np.array([[{"a": 1}]], dtype=object))
    assert "does not hold numbers" in problem(Path("d.npz"))


def test_a_header_that_promises_too_much_is_not_believed(workdir: Path) -> None:
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000, 1000000), }"
    header += b" " * (118 - len(header)) + b"\n"
    with zipfile.ZipFile("d.npz", "w") as bundle:
        bundle.writestr(
            "observations_0.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
        )
    assert "cut off" in problem(Path("d.npz"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "not JSON"),
        ("[]", "not a JSON object"),
        ('{"schema_version": 7}', "schema version 7, not 1"),
        ('{"schema_version": 1, "steps": [1]}', "of 1 episodes, the archive has 2"),
    ],
)
def test_a_damaged_sidecar_is_a_finding(workdir: Path, text: str, says: str) -> None:
    save("d.npz", some())
    json.loads(Path("d.json").read_text())
    Path("d.json").write_text(text)
    assert says in problem(Path("d.npz"))


@given(data=st.data())
def test_a_damaged_archive_is_a_finding_or_harmless_but_never_a_traceback(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("damage") / "d.npz"
    save(path, some())
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at] = data.draw(st.integers(0, 255))
    path.write_bytes(bytes(content[: data.draw(st.integers(0, len(content)))]))
    try:
        loaded = load(path)
    except CompileError as error:
        codes = [d.code for d in error.diagnostics]
    else:
        codes = ["DEMO500"]
        assert all(np.isfinite(d.observations).all() for d in loaded.episodes)
    assert codes == ["DEMO500"]

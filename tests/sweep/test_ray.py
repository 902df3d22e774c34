"""The engine on a Ray cluster of several nodes: one of them is killed, and nothing is lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.sweep.made import task
from tiloilc.diag import CompileError
from tiloilc.evaluate import read
from tiloilc.sweep import Ray


@pytest.fixture
def nodes(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[str, list[int]]]:
    """A cluster on loopback, its head without processors: its address, the workers' raylets."""
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    soon = {"health_check_period_ms": 500, "health_check_failure_threshold": 3}
    head = {"num_cpus": 0, "include_dashboard": False, "_system_config": soon}
    cluster = Cluster(initialize_head=True, head_node_args=head, shutdown_at_exit=False)
    workers = [cluster.add_node(num_cpus=1, include_dashboard=False) for _ in range(2)]
    try:
        yield cluster.address, [w.all_processes["raylet"][0].process.pid for w in workers]
    finally:
        cluster.shutdown()


@pytest.mark.parametrize("options", [{"num_cpus": "x"}, {"no_such": 1}])
def test_an_option_that_ray_has_not_is_a_finding(options: dict[str, object]) -> None:
    (name,) = options
    with pytest.raises(CompileError, match=r"RUN715.*" + name):
        list(Ray(options).results([]))


def raylet_of(folder: Path) -> int:
    """The raylet above the program that works in a job's folder."""
    said = subprocess.run(["ps", "-ewwo", "pid=,ppid=,args="], capture_output=True, text=True)
    rows = [line.split(None, 2) for line in said.stdout.splitlines()]
    parents = {int(pid): int(parent) for pid, parent, _ in rows}
    child = next(
        int(p) for p, _, line in rows if "tiloilc.sweep.child" in line and str(folder) in line
    )
    return parents[parents[child]]


@pytest.mark.slow
def test_a_sweep_outlives_a_node_and_counts_nothing_twice(
    tmp_path: Path, nodes: tuple[str, list[int]]
) -> None:
    address, raylets = nodes
    path = task(
        tmp_path,
        train="train: {steps: 4_000, seeds: 2, learning_starts: 20, checkpoint_every: 200}",
        evaluate="evaluate: {episodes: 2, every: 4_000}",
    )
    sweep = subprocess.Popen(
        [sys.executable, "-m", "tiloilc", "sweep", path.name, "--engine", "ray",
         "--engine-set", f"address={address}", "--algorithms", "tiloil",
         "--seeds", "3", "--seeds-per-job", "1"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    begun: list[Path] = []
    while not begun:  # a checkpoint: the job is in the middle of it
        assert sweep.poll() is None, sweep.communicate()
        time.sleep(0.01)
        begun = list(tmp_path.glob("runs/sweep/jobs/*/runs/*/*/checkpoints/*.json"))
    job = begun[0].parents[4]
    raylet = raylet_of(job)
    assert raylet in raylets
    os.kill(raylet, signal.SIGKILL)
    out, err = sweep.communicate(timeout=1800)
    assert sweep.returncode == 0, err
    records = [record.fields for record in read(tmp_path / "results/corridor.jsonl.gz")]
    assert [record["seed"] for record in records] == [0, 1, 2]
    assert out.splitlines()[1].split()[3] == "3"
    assert (job / "records.jsonl.gz").exists()  # the job of the lost node was done on the other
    log = (job / "log.txt").read_text()
    assert log.count("training corridor: ") == 2, log  # on one node, then on the other

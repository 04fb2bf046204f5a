"""Whoever does the work, here, in processes or on a cluster, dying or not: the same bytes, and no orphans."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import psutil
import pytest

from orthospec.errors import (
    Mistake,
    OrthospecError,
    PluginFault,
    SpecError,
    UnbuildableDesign,
    UsageError,
    WorkersLost,
)
from orthospec.optimise import fields_of, hired, slabs, solve, workers
from orthospec.optimise.space import DesignSpace
from orthospec.optimise.tasks import Task
from orthospec.result import compose, read_result
from orthospec.spec import Spec
from orthospec.spec.writing import dump

SPEC = """\
orthospec: 1
title: Small
variables: {leg: {min: 250 mm, max: 500 mm}}
manipulator: {use: orthoglide, leg_lengths: [leg, leg, leg]}
workspace: {size: [200 mm, 200 mm, 200 mm], divisions: 5}
measures: {transmission: {use: velocity_transmission, at_least: 0.5, at_most: 2}}
goals: {legs: {minimise: leg, goal: 300 mm}}
sweep: {variable: leg, from: 0.3, to: 0.4, points: 2}
optimise: {starts: 3}
"""

HELPER = """\
import os, time
from orthospec.errors import PluginFault

def die(space, item, progress):
    os._exit(1)

def fail(space, item, progress):
    time.sleep(item)
    raise PluginFault(f"after {item}", "raised", "spec.yaml:1:1")

def whole(space, item, progress):
    return os.environ["OPENBLAS_NUM_THREADS"], os.getpid(), id(space), item
"""


@pytest.fixture(scope="module")
def spec(spec_of: Callable[..., Spec]) -> Spec:
    return spec_of(SPEC)


@pytest.fixture(scope="module")
def undisturbed(spec: Spec) -> str:
    return _result(spec)


def _result(spec: Spec, **options: Any) -> str:
    """A solve as it is told, and its fields."""
    finding = solve(spec, **options).finding
    found = fields_of(spec, finding.design, **options)
    return dump(compose(spec, finding)) + repr({name: sha256(found[name]).hexdigest() for name in found})


@pytest.fixture
def shared_field(monkeypatch: pytest.MonkeyPatch) -> None:
    """A field of 1700 nodes is a large one, in seven slabs."""
    monkeypatch.setattr(slabs, "SLAB", 250)
    monkeypatch.setattr(slabs, "WORTH_SHARING", -1.0)


def _who(space: DesignSpace, _: None, __: Any) -> tuple[int, Any]:
    return os.getpid(), space.helpers


class Killer:
    """Kills one worker in the midst of the coarse designs, and one in the midst of the grid."""

    def __init__(self, kill: Callable[[], None]) -> None:
        self._kill, self.killed = kill, []

    def __call__(self, stage: str, done: int, total: int) -> None:
        stage = stage.partition(" ")[0]
        if stage in {"designs", "grid"} - set(self.killed) and 0 < done < total:
            self.killed.append(stage)
            self._kill()


@pytest.fixture(scope="module")
def helper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Task[Any, Any]]]:
    """Tasks whose functions other processes can import."""
    folder = tmp_path_factory.mktemp("helper")
    (folder / "helper_of_workers.py").write_text(HELPER)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        import helper_of_workers  # type: ignore[import-not-found]

        yield lambda name: Task(name, getattr(helper_of_workers, name), dict)


class TestProcesses:
    @pytest.mark.usefixtures("shared_field")
    def test_two_processes_give_the_same_bytes_though_some_die(self, spec: Spec, undisturbed: str) -> None:
        killer = Killer(lambda: multiprocessing.active_children()[0].kill())
        with hired(jobs=2) as two:
            assert _result(spec, workers=two, progress=killer) == undisturbed
        assert killer.killed == ["designs", "grid"]
        assert not multiprocessing.active_children()

    def test_each_unpacks_the_problem_once_and_has_one_thread(
        self, spec: Spec, helper: Callable[[str], Task[Any, Any]]
    ) -> None:
        with hired(jobs=2) as two:
            found = workers.in_order(two, helper("whole"), DesignSpace(spec), range(12))
        assert [item for *_, item in found] == list(range(12))
        assert {threads for threads, *_ in found} == {"1"}
        by_process = {(pid, space) for _, pid, space, _ in found}
        assert len(by_process) == len({pid for pid, _ in by_process})
        assert os.getpid() not in {pid for pid, _ in by_process}

    def test_a_single_task_that_divides_is_done_here_with_their_help(self, spec: Spec) -> None:
        task = Task("alone", _who, dict, divides=True)
        with hired(jobs=2) as two:
            assert workers.in_order(two, task, DesignSpace(spec), [None]) == [(os.getpid(), two)]
        assert not multiprocessing.active_children()

    def test_a_task_that_kills_every_worker_is_told(
        self, spec: Spec, helper: Callable[[str], Task[Any, Any]]
    ) -> None:
        with (
            hired(jobs=2) as two,
            pytest.raises(WorkersLost, match=r"stopped at 'die': .* died 3 times; .* fewer --jobs"),
        ):
            workers.in_order(two, helper("die"), DesignSpace(spec), [1, 2])

    def test_of_several_errors_that_of_the_first_item_is_told(
        self, spec: Spec, helper: Callable[[str], Task[Any, Any]]
    ) -> None:
        with hired(jobs=2) as two, pytest.raises(PluginFault) as caught:
            workers.in_order(two, helper("fail"), DesignSpace(spec), [0.4, 0.0])
        assert str(caught.value) == "spec.yaml:1:1: plugin after 0.4: raised"


@pytest.mark.parametrize(
    "error",
    [
        UsageError("no"),
        SpecError([Mistake("a.yaml", 1, 2, "wrong")]),
        UnbuildableDesign({"leg": 0.3}, "too short"),
        PluginFault("bad", "raised", "a.yaml:1:2"),
        WorkersLost("sweep", "gone"),
    ],
)
def test_errors_cross_from_one_process_to_another_unharmed(error: OrthospecError) -> None:
    there = pickle.loads(pickle.dumps(error))
    assert (type(there), str(there), vars(there)) == (type(error), str(error), vars(error))


class TestCluster:
    @pytest.mark.usefixtures("shared_field")
    def test_a_cluster_that_loses_workers_gives_the_same_bytes(self, spec: Spec, undisturbed: str) -> None:
        from distributed import LocalCluster

        quiet = {"dashboard_address": None, "silence_logs": 60, "threads_per_worker": 1}
        with LocalCluster(n_workers=2, **quiet) as cluster:

            def kill_one() -> None:
                victim = next(worker.pid for worker in cluster.workers.values() if worker.pid)
                os.kill(victim, signal.SIGKILL)

            killer = Killer(kill_one)
            with hired(on=cluster.scheduler_address) as there:
                assert _result(spec, workers=there, progress=killer) == undisturbed
        assert killer.killed == ["designs", "grid"]

    def test_other_versions_on_the_cluster_are_refused(
        self, spec: Spec, helper: Callable[[str], Task[Any, Any]], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        work = workers._Checked(helper("whole").work, "those of here")
        monkeypatch.setattr(workers, "fingerprint", lambda _: "others")
        with pytest.raises(UsageError, match="other versions of orthospec"):
            work(DesignSpace(spec), 1, None)

    def test_no_scheduler_is_told(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(workers, "PATIENCE", 1)
        with pytest.raises(UsageError, match="no Dask scheduler answers"), hired(on="tcp://127.0.0.1:9"):
            pass

    @pytest.mark.parametrize("url", ["foo", "tcp://host", "http://host:8786", "tcp://:x", ""])
    def test_what_is_no_schedulers_address_is_refused_without_asking_for_it(
        self, url: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("distributed.Client", lambda *_, **__: pytest.fail("asked"))
        with pytest.raises(UsageError, match="the address of a scheduler was expected"), hired(on=url):
            pass

    def test_without_dask_it_is_told_how_to_get_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "distributed", None)
        with pytest.raises(UsageError, match=r"pip install 'orthospec\[dask\]'"), hired(on="tcp://any:1"):
            pass


TALKATIVE = """
import signal, sys
from orthospec.show import progress
signal.signal(signal.SIGINT, signal.default_int_handler)
progress.PLAIN = 0.0
from orthospec.cli import main
main()
"""


@pytest.fixture
def running(tmp_path: Path) -> Iterator[SimpleNamespace]:
    """A long run with two processes, at work on its starts."""
    (tmp_path / "long.yaml").write_text(SPEC.replace("starts: 3", "starts: 4000"))
    command = [sys.executable, "-P", "-c", TALKATIVE, "run", "long.yaml", "--jobs", "2", "--cache", "cache"]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=tmp_path, start_new_session=True, **pipes) as process:
        while "designs on the coarse grid 0 %" in (line := process.stderr.readline()):
            pass
        assert "designs on the coarse grid" in line
        family = psutil.Process(process.pid).children(recursive=True)
        assert len(family) >= 2
        yield SimpleNamespace(process=process, family=family, folder=tmp_path)
        process.kill()


def _gone(family: list[psutil.Process]) -> bool:
    return not psutil.wait_procs(family, timeout=10)[1]


def test_ctrl_c_ends_all_processes_without_a_trace_and_keeps_what_was_found(running: SimpleNamespace) -> None:
    os.killpg(running.process.pid, signal.SIGINT)
    _, error = running.process.communicate(timeout=60)
    assert running.process.returncode == 4, error
    assert "Traceback" not in error
    assert read_result(running.folder / "runs" / "long")["status"] == "unfinished"
    assert _gone(running.family)


def test_processes_do_not_outlive_a_run_that_is_killed(running: SimpleNamespace) -> None:
    running.process.kill()
    assert _gone(running.family)

"""What several test files share: specs as text, expensive solves once, and 50-digit references."""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import signal
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import settings

from orthospec.composite.subproblem import Block, HalfLines, Rows
from orthospec.composite.subproblem import solve as solve_subproblem
from orthospec.composite.template import Template
from orthospec.optimise import Outcome, evaluate_spec, solve
from orthospec.spec import Spec, load_spec

SPECS = Path(__file__).parents[1] / "specs"

mpmath.mp.dps = 50
settings.register_profile("loaded", deadline=None)
settings.load_profile("loaded")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Nothing is kept in the user's own cache folder, or found there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def spec_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Spec]:
    """A spec from its text; ``settings`` are KEY=VALUE overrides. Proofs are made where the text says so."""
    folder = tmp_path_factory.mktemp("specs")

    def load(text: str, *settings: str) -> Spec:
        path = folder / "spec.yaml"
        path.write_text(text, encoding="utf-8")
        return load_spec(path, settings if "proof:" in text else _unproved(settings))

    return load


def _unproved(settings: tuple[str, ...]) -> tuple[str, ...]:
    return settings if any(one.startswith("proof") for one in settings) else (*settings, "proof=false")


@pytest.fixture(scope="session")
def outcome_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Outcome]:
    """The outcome of a spec in ``specs/``, solved once a session; proved only where a setting says how.

    Workers side by side hand each other what they have solved, in files.
    """
    known: dict[tuple[str, ...], Outcome] = {}
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent

    def find(name: str, *settings: str) -> Outcome:
        key = (name, *settings)
        if key not in known:
            file = folder / f"{hashlib.sha256(repr(key).encode()).hexdigest()}.outcome"
            if not file.exists():
                spec = load_spec(SPECS / f"{name}.yaml", _unproved(settings))
                outcome = solve(spec) if spec.variables else evaluate_spec(spec)
                whole = file.with_suffix(f".{os.getpid()}")
                whole.write_bytes(pickle.dumps(outcome))
                whole.replace(file)
            known[key] = pickle.loads(file.read_bytes())
        return known[key]

    return find


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A real Chromium without a screen, with WebGL; where none is installed the test is skipped.

    With ORTHOSPEC_BROWSER=required it fails instead.
    """
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        if os.environ.get("ORTHOSPEC_BROWSER") == "required":
            pytest.fail("no Chromium is installed")
        pytest.skip("no Chromium is installed")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        chromium = playwright.chromium.launch(executable_path=path, args=options)
        yield chromium
        chromium.close()


@pytest.fixture(scope="session")
def least_slack() -> Callable[[Template, Any, float], float]:
    """The slack that the compiled rows of a form need to hold this inside and bound."""

    def find(template: Template, inside: Any, bound: float) -> float:
        w = np.concatenate([[0.0], np.ravel(inside), [bound, np.log(bound)]])
        rows = Rows((Block(template, 1, 1),), HalfLines(0, np.ones(1), np.zeros(1)))
        none, one = np.zeros((len(w), 1)), np.ones(1)
        step = solve_subproblem(rows, w, none, np.eye(1), -one, one, penalty=1.0)
        assert step is not None
        return step.slack

    return find


@pytest.fixture(scope="session")
def exact() -> SimpleNamespace:
    """The Orthoglide in 50 digits, written from its loop equations and not from the code under test."""
    return SimpleNamespace(sliders=_sliders, inverse_jacobian=_inverse_jacobian, stretch=_stretch)


def _sliders(lengths: Sequence[Any], pose: Sequence[Any], branch: Sequence[int] = (1, 1, 1)) -> list[Any]:
    """Slider i on axis i at the distance L_i from the pose."""
    found = []
    for i in range(3):
        across = sum(mpmath.mpf(pose[k]) ** 2 for k in range(3) if k != i)
        found.append(mpmath.mpf(pose[i]) + branch[i] * mpmath.sqrt(mpmath.mpf(lengths[i]) ** 2 - across))
    return found


def _inverse_jacobian(
    lengths: Sequence[Any], pose: Sequence[Any], branch: Sequence[int] = (1, 1, 1)
) -> mpmath.matrix:
    """Central differences of the sliders: steps of 1e-16 in 50 digits leave some 1e-32."""
    h = mpmath.mpf(10) ** -16
    found = mpmath.matrix(3, 3)
    for k in range(3):
        ends = []
        for step in (h, -h):
            moved = [mpmath.mpf(p) for p in pose]
            moved[k] += step
            ends.append(_sliders(lengths, moved, branch))
        for i in range(3):
            found[i, k] = (ends[0][i] - ends[1][i]) / (2 * h)
    return found


def _stretch(inverse_jacobian: mpmath.matrix) -> mpmath.matrix:
    """−½ ln(J⁻ᵀJ⁻¹)."""
    eigenvalues, vectors = mpmath.eigsy(inverse_jacobian.T * inverse_jacobian)
    return vectors * mpmath.diag([-mpmath.log(e) / 2 for e in eigenvalues]) * vectors.T


@pytest.fixture
def hears_ctrl_c() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt: a process begun in the background by a shell may ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)

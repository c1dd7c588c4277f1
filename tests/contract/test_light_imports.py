"""Who only compares logs needs the small set of libraries, and is told what the other verbs need."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from locks import COMPARING, ROOT, link

LIGHT = (
    *("cli", "comparison", "diagnosis", "effects", "html", "measurements", "notebook", "physics", "plants", "proposal"),
    *("recorders", "sources", "summaries"),
)
VERBS = ("add", "benchmark", "close", "compare", "diagnose", "fit", "init", "record", "summarize", "view")
CODE = """
import importlib, pkgutil, sys

for name in sys.argv[1:]:
    package = importlib.import_module(f"dr_lab.{name}")
    for module in pkgutil.walk_packages(getattr(package, "__path__", []), package.__name__ + "."):
        importlib.import_module(module.name)
"""
SEARCH = ("hydra/sweeper=study", "hydra.sweeper.objective=[x]", "hydra.sweeper.directions=[minimize]", "seed=range(9)")


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return link(COMPARING, tmp_path_factory.mktemp("small") / "libraries")


def run(libraries: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Python without this environment's libraries (-S), where those given and the checkout are all there is."""
    path = os.pathsep.join(map(str, (libraries, ROOT, ROOT / "launchers")))
    return subprocess.run(
        [sys.executable, "-S", *arguments],
        env={**os.environ, "PYTHONPATH": path},
        cwd=libraries.parent,
        capture_output=True,
        text=True,
        check=False,
    )


def test_packages_import_with_the_small_set(small_set: Path) -> None:
    done = run(small_set, "-c", CODE, *LIGHT, *(f"workflows.{verb}" for verb in VERBS))
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("train", "env=furuta"), "dr-lab train: train needs torch, "),
        (("evaluate", "run=."), "dr-lab evaluate: evaluate needs torch, "),
        (("record", "-m", *SEARCH), "hydra.sweeper.sampler=optuna.samplers.TPESampler needs optuna, "),
    ],
)
def test_what_needs_more_says_how_to_install_it(small_set: Path, arguments: tuple[str, ...], message: str) -> None:
    done = run(small_set, "-m", "dr_lab", *arguments)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert f"{message}which is not installed. Install it: " in done.stderr

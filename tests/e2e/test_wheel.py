"""The built wheel, installed into an environment of its own with the small set of libraries, away from the checkout."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from locks import COMPARING, link

from dr_lab import __version__
from dr_lab.cli.folders import PACKAGE
from dr_lab.cli.verbs import verbs


def finished(*command: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """A command that sees nothing of a checkout, though this process may."""
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(list(map(str, command)), cwd=cwd, env=env, capture_output=True, text=True, check=False)


def run(*command: str | Path, cwd: Path) -> str:
    done = finished(*command, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`dr-lab` from the wheel; the libraries that comparing takes are this environment's, dr_lab itself is not."""
    folder = tmp_path_factory.mktemp("wheel")
    # The wheel is built from the sdist, so that what the sdist lacks shows too.
    run(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", folder, cwd=PACKAGE.parent)
    (archive,) = folder.glob("*.tar.gz")
    run("tar", "xzf", archive, cwd=folder)
    source = folder / archive.name.removesuffix(".tar.gz")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=source)
    (wheel,) = folder.glob("*.whl")
    run(sys.executable, "-m", "venv", folder / "env", cwd=folder)
    python = folder / "env/bin/python"
    run(python, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", wheel, cwd=folder)
    purelib = run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=folder).strip()
    Path(purelib, "libraries.pth").write_text(f"{link(COMPARING, folder / 'libraries')}\n")
    return folder / "env/bin/dr-lab"


@pytest.mark.slow
def test_wheel_lists_its_verbs(program: Path, tmp_path: Path) -> None:
    assert run(program, "--version", cwd=tmp_path) == f"dr_lab {__version__}\n"
    text = run(program, "--help", cwd=tmp_path)
    assert all(f"  {verb} " in text for verb in verbs())


@pytest.mark.slow
def test_wheel_composes_from_its_own_configuration(program: Path, tmp_path: Path) -> None:
    text = run(program, "record", "--cfg", "job", cwd=tmp_path)
    assert "_target_" in yaml.safe_load(text)["source"]
    printed = run(program, "compare", "--cfg", "job", "-p", "model", "--resolve", "measurements.logs=[]", cwd=tmp_path)
    mjcf = Path(yaml.safe_load(printed)["mjcf"])
    assert mjcf.is_file()
    assert program.parents[1] in mjcf.parents


@pytest.mark.slow
def test_wheel_names_the_effect_of_its_own_logs(program: Path, tmp_path: Path) -> None:
    run(program, "close", "model=furuta", "measurements=furuta", "hydra.run.dir=closed", cwd=tmp_path)
    report = json.loads((tmp_path / "closed/report.json").read_text(encoding="utf-8"))
    assert report["verdict"] == "named"
    assert report["ladder"][-1]["effects"] == ["coulomb_friction@arm"]


@pytest.mark.slow
def test_wheel_says_what_training_needs(program: Path, tmp_path: Path) -> None:
    done = finished(program, "train", "env=furuta", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == (
        "dr-lab train: train needs torch, which is not installed. Install it: pip install 'dr_lab[train]'\n"
    )


@pytest.mark.slow
def test_wheel_sweeps_with_its_own_plugins(program: Path, tmp_path: Path) -> None:
    where = "import hydra_plugins.dr_lab_ray_launcher as plugin; print(plugin.__file__)"
    plugin = Path(run(program.with_name("python"), "-c", where, cwd=tmp_path).strip())
    assert program.parents[1] in plugin.parents
    jobs = ["hydra/launcher=cores", "hydra.sweep.dir=sweep", "plant.duration=1", "plant.peaks=[8]", "seed=0,1"]
    run(program, "record", "-m", *jobs, cwd=tmp_path)
    assert len(list(tmp_path.glob("sweep/*/log_1.mcap"))) == 2

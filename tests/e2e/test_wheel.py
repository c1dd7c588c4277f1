"""The built wheel, installed into an environment of its own, away from the checkout."""

import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
import yaml

from dr_lab import __version__
from dr_lab.cli.folders import PACKAGE
from dr_lab.cli.verbs import verbs


def run(*command: str | Path, cwd: Path) -> str:
    done = subprocess.run(list(map(str, command)), cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`dr-lab` from the wheel; the libraries are this environment's, dr_lab itself is not."""
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
    # A plain path entry: this environment's own .pth files, the editable install among them, stay unread.
    Path(purelib, "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n")
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
def test_wheel_says_where_examples_are(program: Path, tmp_path: Path) -> None:
    command = [program, "compare", "--cfg", "job", "--resolve"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "not part of an installed dr_lab. Run inside a clone" in done.stderr


@pytest.mark.slow
def test_wheel_sweeps_with_its_own_plugins(program: Path, tmp_path: Path) -> None:
    where = "import hydra_plugins.dr_lab_ray_launcher as plugin; print(plugin.__file__)"
    plugin = Path(run(program.with_name("python"), "-c", where, cwd=tmp_path).strip())
    assert program.parents[1] in plugin.parents
    jobs = ["hydra/launcher=cores", "hydra.sweep.dir=sweep", "plant.duration=1", "plant.peaks=[8]", "seed=0,1"]
    run(program, "record", "-m", *jobs, cwd=tmp_path)
    assert len(list(tmp_path.glob("sweep/*/log_1.mcap"))) == 2

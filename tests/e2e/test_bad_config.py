"""A wrong configuration: one clear message, exit code 2, nothing left behind."""

import subprocess
import sys
from pathlib import Path

import pytest

from dr_lab.__main__ import main

PROGRAM = Path(sys.executable).with_name("dr-lab")
SAYS = {
    ("clsoe",): "no verb 'clsoe' in dr-lab. Did you mean 'close'?",
    ("compare", "model=fruta"): "There is no model 'fruta' in the configuration. Did you mean 'furuta'?",
    ("fit", "mesurements=furuta"): "Did you mean 'measurements'?",
    ("close", "sed=3"): "Did you mean 'seed'?",
    ("diagnose", "effect=[coulomb_fricton]"): "Did you mean 'coulomb_friction'?",
    ("add",): "effect",
    ("compare", "seed=one"): "seed is 'one'; expected a whole number.",
    ("compare", "model._target_=os.system"): "outside the trusted packages (dr_lab, ",
    ("compare", "model.parameters.arm.mass.lo=1"): "Did you mean 'model.parameters.arm.mass'?",
    ("train", "device=cuda:99"): "device is cuda:99, with which torch cannot compute here; available are cpu",
    ("record", "plant/hidden=nothing"): "There is no plant/hidden 'nothing'",
}


@pytest.mark.parametrize("arguments", SAYS, ids=" ".join)
def test_one_clear_message(
    arguments: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(list(arguments)) == 2
    told = capsys.readouterr()
    require_one_message(told.out, told.err, SAYS[arguments], tmp_path)


@pytest.mark.parametrize(
    "arguments",
    [("compare", "model=fruta"), pytest.param(("compare", "seed=one"), marks=pytest.mark.slow)],
    ids=" ".join,
)
def test_the_same_at_the_real_command(arguments: tuple[str, ...], tmp_path: Path) -> None:
    done = subprocess.run([PROGRAM, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    require_one_message(done.stdout, done.stderr, SAYS[arguments], tmp_path)


def require_one_message(out: str, error: str, said: str, folder: Path) -> None:
    assert said in error
    assert "Traceback" not in error
    assert out == ""
    assert [path for path in folder.rglob("*") if path.is_file()] == []

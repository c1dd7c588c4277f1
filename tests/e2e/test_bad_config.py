"""A wrong configuration, typed at the real command: one clear message, exit code 2, nothing left behind."""

import subprocess
import sys
from pathlib import Path

import pytest

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
    ("record", "plant/hidden=nothing"): "There is no plant/hidden 'nothing'",
}


@pytest.mark.parametrize("arguments", SAYS, ids=" ".join)
def test_one_clear_message(arguments: tuple[str, ...], tmp_path: Path) -> None:
    done = subprocess.run([PROGRAM, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert SAYS[arguments] in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []

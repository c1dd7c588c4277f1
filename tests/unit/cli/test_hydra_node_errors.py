"""What may be wrong with sweeps and with Hydra's own node: one message, an exit code, nothing called, no folder."""

from pathlib import Path

import pytest
from cli_machine import CommandLine, write

Capture = pytest.CaptureFixture[str]

SWEEP_SAYS = {
    "hydra.sweeper.refresh=abc": ["hydra.sweeper.refresh is 'abc'; expected a number"],
    "hydra.sweeper.fail_fast=nope": ["hydra.sweeper.fail_fast is 'nope'; expected true or false"],
    "+hydra.sweeper.fial_fast=true": ["no key 'hydra.sweeper.fial_fast'", "Did you mean 'hydra.sweeper.fail_fast'?"],
    "hydra/launcher=cores hydra.launcher.n_jobs=abc": ["hydra.launcher.n_jobs: Value 'abc'", "Integer"],
    "hydra/launcher=cores +hydra.launcher.n_job=2": ["hydra.launcher.n_job: Key 'n_job' not in 'JobLibLauncherConf'"],
    "hydra/launcher=ray hydra.launcher.grace=long": ["hydra.launcher.grace is 'long'; expected a number"],
    "hydra.launcher._target_=shutil.copy": ["'shutil.copy' is outside the trusted packages"],
    "hydra.sweeper._target_=shutil.copy": ["'shutil.copy' is outside the trusted packages"],
    "study hydra.sweeper.objective=score": ["hydra.sweeper.objective is 'score'; expected [a text, …]"],
    "study hydra.sweeper.n_trials=abc": ["hydra.sweeper.n_trials is 'abc'; expected a whole number"],
    "study hydra.sweeper.seed=-1": ["hydra.sweeper.seed is -1; expected at least 0"],
    "study hydra.sweeper.n_trials=0": ["hydra.sweeper.n_trials is 0; expected at least 1"],
    "study hydra.sweeper.at_once=0": ["hydra.sweeper.at_once is 0; expected at least 1"],
    "hydra.sweeper.refresh=0": ["hydra.sweeper.refresh is 0; expected a number above 0"],
    "study hydra.sweeper.sampler._target_=optuna.samplers.TPESampeler": ["Did you mean 'TPESampler'?"],
    "study hydra.sweeper.sampler._target_=optuna.samplers._base.warnings.warn": ["cannot be imported"],
    "study hydra.sweeper.pruner={_target_: shutil.copy}": ["hydra.sweeper.pruner: _target_ 'shutil.copy' is outside"],
    "study hydra.sweeper.objective=???": ["objective", "no value"],
}
STUDY = ("hydra/sweeper=study", "hydra.sweeper.objective=[score]", "hydra.sweeper.directions=[minimize]")


@pytest.mark.parametrize("typed", SWEEP_SAYS)
def test_says_what_is_wrong_with_a_sweep(dr_lab: CommandLine, capsys: Capture, typed: str) -> None:
    arguments = typed.replace("{_target_: ", "{_target_:").split()
    study = STUDY if arguments[0] == "study" else ()
    assert dr_lab("compare", "-m", "seed=1,2", *study, *(word for word in arguments if word != "study")) == 2
    error = capsys.readouterr().err
    for words in SWEEP_SAYS[typed]:
        assert words in error
    assert "Traceback" not in error
    assert dr_lab.calls == []
    assert list(Path.cwd().iterdir()) == []


CALLS_BY_HYDRA = {
    "callbacks: {mine: {_target_: shutil.copy, src: secret, dst: copied}}": "hydra.callbacks.mine",
    "callbacks: {mine: {_target_: '${name}', src: secret, dst: copied}}": "hydra.callbacks.mine",
    "job_logging: {version: 1, handlers: {mine: {class: shutil.copy, src: secret}}}": "hydra.job_logging.handlers",
    "hydra_logging: {version: 1, formatters: {mine: {(): shutil.copy, a: secret}}}": "hydra_logging.formatters.mine",
    "job_logging: {version: 1, handlers: {mine: {class: logging.basicConfig}}}": "no handler, formatter or filter",
}


@pytest.mark.parametrize("flag", ["--run", "--multirun"])
@pytest.mark.parametrize("node", CALLS_BY_HYDRA)
def test_an_experiment_makes_hydra_call_nothing(
    dr_lab: CommandLine, capsys: Capture, tmp_path: Path, node: str, flag: str
) -> None:
    text = f"# @package _global_\nname: shutil.copy\nhydra:\n  {node}\n"
    write(tmp_path / "conf/experiment/theirs.yaml", text)
    Path("secret").touch()
    assert dr_lab("compare", flag, "experiment=theirs") == 2
    assert CALLS_BY_HYDRA[node] in capsys.readouterr().err
    assert [path.name for path in Path.cwd().iterdir()] == ["secret"]


def test_an_experiment_among_jobs_makes_hydra_call_nothing(
    dr_lab: CommandLine, capsys: Capture, tmp_path: Path
) -> None:
    theirs = "# @package _global_\nhydra: {callbacks: {mine: {_target_: shutil.copy}}}\n"
    write(tmp_path / "conf/experiment/theirs.yaml", theirs)
    assert dr_lab("compare", "-m", "experiment=night,theirs") == 2
    assert "'shutil.copy' is outside the trusted packages" in capsys.readouterr().err
    assert dr_lab.calls == []
    assert dr_lab("compare", "--cfg", "hydra", "experiment=theirs") == 0  # to look at it calls nothing
    assert dr_lab("compare", "hydra/job_logging=default", "experiment=night") == 0


def test_search_that_is_no_sweep(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    text = "# @package _global_\nhydra:\n  sweeper:\n    params:\n      seed: 1,2\n"
    write(tmp_path / "conf/experiment/search.yaml", text)
    assert dr_lab("compare", "experiment=search", "horizon=1") == 2
    told = capsys.readouterr().err
    assert "several values of seed" in told
    assert "dr-lab compare -m experiment=search horizon=1" in told
    assert [path for path in Path.cwd().rglob("*") if path.name != "outputs"] == []
    assert dr_lab("compare", "-m", "experiment=search") == 0
    assert [call["seed"] for call in dr_lab.calls] == [1, 2]

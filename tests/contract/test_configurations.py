"""Every yaml of every group composes, and every key fits what it configures."""

import inspect
from collections.abc import Iterator
from pathlib import Path

import pytest
from omegaconf import OmegaConf
from omegaconf.errors import InterpolationResolutionError

from dr_lab.cli.arguments import SUPPLIED, not_passed, workflow_of
from dr_lab.cli.check import check
from dr_lab.cli.compose import choices, compose, compose_with_hydra
from dr_lab.cli.experiments import experiments as experiments_of
from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import options
from dr_lab.cli.verbs import verbs
from dr_lab.errors import ConfigError

FOLDERS = (shipped(),)
NEEDS_RUN = {"from_run": "model.run", "sim2real_furuta": "run", "didor_real": "evaluator.target.model.run"}
EXPERT = {
    "lunar_lander_adr_plus": "distribution_learner.expert.path",
    "lunar_lander_gail": "algorithm.expert.path",
}
NEEDED = {
    "add": ["effect=coulomb_friction", "effect.joint=arm"],
    "init": ["robot=robot.xml", "logs=[log.csv]"],
    "summarize": ["sweep=outputs"],
}


def experiments() -> Iterator[tuple[str, str]]:
    """Each experiment with the verb that its comment's command names."""
    for name, path in options("experiment", FOLDERS).items():
        words = path.read_text(encoding="utf-8").split("dr-lab ")
        assert len(words) > 1, f"{path}: the comment shows no command"
        yield words[1].split()[0], name


def check_verb(verb: str, overrides: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DR_LAB_DATA", str(Path(__file__).parent))
    cfg = compose(verb, [*NEEDED.get(verb, []), *overrides])
    # Whether example files are there is not what is tested here.
    OmegaConf.register_new_resolver("examples", lambda path: path, replace=True)
    workflow = workflow_of(verb)
    unused = not_passed(cfg, inspect.signature(workflow).parameters)
    check(cfg, workflow, verb, supplied=SUPPLIED, unused=unused)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a run of ``dr-lab close`` was configured with, in its folder."""
    folder = tmp_path_factory.mktemp("run")
    OmegaConf.save(compose("close"), folder / "config.yaml")
    return folder


def run_given(option: str, run: Path) -> list[str]:
    return [f"{NEEDS_RUN[option]}={run}"] if option in NEEDS_RUN else []


@pytest.mark.parametrize("verb", verbs())
def test_verb_fits_its_workflow(verb: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check_verb(verb, [], monkeypatch)


def one_effect(verb: str, experiment: str) -> list[str]:
    """Of the whole catalogue, which is that of ``dr-lab close`` itself, unless the experiment chooses its effects."""
    chooses = "effect" in options("experiment", FOLDERS)[experiment].read_text(encoding="utf-8")
    return [] if chooses or verb not in {"close", "diagnose"} else ["effect=spring"]


@pytest.mark.parametrize(("verb", "experiment"), list(experiments()))
def test_experiment_composes(verb: str, experiment: str, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = [f"{EXPERT[experiment]}=episodes.mcap"] if experiment in EXPERT else one_effect(verb, experiment)
    check_verb(verb, [f"experiment={experiment}", *run_given(experiment, run), *given], monkeypatch)


def options_of(group: str) -> list[str]:
    return list(options(group, FOLDERS))


@pytest.mark.parametrize("model", options_of("model"))
def test_model_composes(model: str, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check_verb("compare", [f"model={model}", *run_given(model, run)], monkeypatch)


def test_the_model_of_a_run_asks_for_the_run_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match=r"^No value for model\.run\. Give one"):
        check_verb("compare", ["model=from_run"], monkeypatch)
    with pytest.raises(InterpolationResolutionError, match=r"There is no folder /nowhere\. Give the"):
        check_verb("compare", ["model=from_run", "model.run=/nowhere"], monkeypatch)


def test_what_a_run_recorded_is_checked_like_the_rest(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = OmegaConf.load(run / "config.yaml")
    OmegaConf.update(config, "model._target_", "os.system")
    OmegaConf.save(config, tmp_path / "config.yaml")
    with pytest.raises(ConfigError, match=r"'os\.system' is outside the trusted packages"):
        check_verb("compare", ["model=from_run", f"model.run={tmp_path}"], monkeypatch)


@pytest.mark.parametrize("measurements", options_of("measurements"))
def test_measurements_compose(measurements: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check_verb("compare", [f"measurements={measurements}"], monkeypatch)


@pytest.mark.slow
def test_help_shows_the_experiments_of_the_verb() -> None:
    groups = {verb: choices(compose_with_hydra(verb, [], FOLDERS)) for verb in verbs()}
    shown = {verb: set(experiments_of(groups[verb], FOLDERS)) for verb in verbs()}
    named = {verb: {name for own, name in experiments() if own == verb} for verb in verbs()}
    for verb in ("close", "evaluate", "record", "train"):
        assert shown[verb] == named[verb]
    assert "emps" in shown["compare"] < shown["close"]  # one that chooses effects is none of dr-lab compare


def test_whole_catalogue_holds_every_effect_that_asks_the_user_for_nothing() -> None:
    assert sorted({*compose("close").effects, "formula", "residual_force", "all"}) == options_of("effect")
    assert not {"formula", "residual_force"} & compose("close").effects.keys()


@pytest.mark.parametrize("value", ["0.3", "learned", "null"])
def test_what_is_called_takes_no_plain_value(value: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        ConfigError, match=r"algorithm.adaptation.rate is .*expects a section.*algorithm.adaptation.rate.KEY"
    ):
        check_verb("train", ["experiment=maml_nav2d", f"algorithm.adaptation.rate={value}"], monkeypatch)

"""A search that the same command continues, with the trials that one without a stop would have tried."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra_plugins._dr_lab_search_space import corners, search_space
from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution
from optuna.samplers import RandomSampler
from probe_sweeps import Sweeps, completed, table

from dr_lab.cli.compose import compose_with_hydra
from dr_lab.cli.folders import shipped
from dr_lab.cli.hydra_node import check_hydra
from dr_lab.errors import ConfigError, DataError, UnknownNameError
from dr_lab.sweeps.objective import objectives
from dr_lab.sweeps.study import SweepStudy
from dr_lab.sweeps.sweep import JOURNAL_FILE, SweepJob, add_jobs

Sweep = Callable[..., int]
STUDY = ("hydra/sweeper=study", "hydra.sweeper.objective=[score]", "hydra.sweeper.directions=[minimize]")


def test_total_of_trials_over_two_commands(sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    swept = tmp_path / "swept"
    wrong = (STUDY[0], "hydra.sweeper.objective=[scor]", STUDY[2])
    assert sweep(*wrong, "value=interval(0,6)", "hydra.sweeper.n_trials=2", "hydra.sweeper.at_once=2") == 2
    assert "no figure 'scor'" in capsys.readouterr().err
    done = completed(swept)
    assert set(done) == {"0", "1"}
    assert sweep(*STUDY, "value=interval(0,6)", "hydra.sweeper.n_trials=3") == 0
    assert "Study in swept: 3 trials in all, 2 begun before" in capsys.readouterr().out
    assert {number: completed(swept)[number] for number in done} == done
    rows = table(swept)
    scores = [(float(row["value"]) - 3.0) ** 2 for row in rows]
    assert [float(row["score"]) for row in rows] == pytest.approx(scores, abs=0)
    [best] = yaml.safe_load((swept / "best.yaml").read_text(encoding="utf-8"))
    assert best["objective"] == {"score": min(scores)}
    assert best["folder"] == str(scores.index(min(scores)))


def test_proposals_do_not_depend_on_interruptions(tmp_path: Path) -> None:
    space = {"x": FloatDistribution(0.0, 1.0), "y": CategoricalDistribution(["a", "b"])}
    (tmp_path / "whole").mkdir()
    (tmp_path / "parts").mkdir()

    def search(folder: str, *, anew: bool) -> list[object]:
        study = SweepStudy(tmp_path / folder, ["x"], ["minimize"], space, RandomSampler, seed=3)
        for _ in range(5):
            if anew:
                study = SweepStudy(tmp_path / folder, ["x"], ["minimize"], space, RandomSampler, seed=3)
            proposal = study.propose()
            if anew:  # killed before anything came of it
                study = SweepStudy(tmp_path / folder, ["x"], ["minimize"], space, RandomSampler, seed=3)
                assert study.unfinished() == [proposal]
            study.tell(proposal.number, [float(str(proposal.values["x"]))])
        return [study.best(), len(study)]

    assert search("whole", anew=False) == search("parts", anew=True)


BRUTE_FORCE = "hydra.sweeper.sampler._target_=optuna.samplers.BruteForceSampler"


@pytest.mark.filterwarnings("ignore::optuna.exceptions.ExperimentalWarning")
def test_failed_and_pruned_trials_count(sweep: Sweep, sweeps: Sweeps, tmp_path: Path) -> None:
    (sweeps.trouble / "fails_1").touch()
    pruner = (
        "hydra.sweeper.pruner={_target_: optuna.pruners.ThresholdPruner, upper: 30.0}",
        "hydra.sweeper.prune_on=score",
    )
    search = (BRUTE_FORCE, "value=1,3,7,8")
    assert sweep(*STUDY, *search, *pruner, "hydra.sweeper.n_trials=4") == 0
    states = {float(row["value"]): row["status"] for row in table(tmp_path / "swept")}
    # (value − 3)², four times as much at the first step
    assert states == {1: "failed", 3: "completed", 7: "pruned", 8: "pruned"}


@pytest.mark.filterwarnings("ignore::optuna.exceptions.ExperimentalWarning")
def test_a_space_that_was_tried_throughout_stays_so(
    sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for _ in range(2):
        assert sweep(*STUDY, BRUTE_FORCE, "value=1,2", "hydra.sweeper.n_trials=6") == 0
        assert sorted(row["value"] for row in table(tmp_path / "swept")) == ["1", "2"]
    assert "2 trials: swept/sweep.csv" in capsys.readouterr().out


def test_nothing_is_proposed_after_a_failure_where_that_is_wanted(sweep: Sweep, sweeps: Sweeps, tmp_path: Path) -> None:
    (sweeps.trouble / "fails_1").touch()
    assert sweep(*STUDY, "value=choice(1)", "hydra.sweeper.n_trials=3", "hydra.sweeper.fail_fast=true") == 2
    assert [row["status"] for row in table(tmp_path / "swept")] == ["failed"]


def test_trials_without_a_finite_objective_are_told_from_those_that_failed(
    sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sweep(*STUDY, "value=nan,inf", "hydra.sweeper.n_trials=1") == 2
    assert [row["status"] for row in table(tmp_path / "swept")] == ["completed"]
    assert "No trial of the study in swept reached a finite score; sweep.csv" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::optuna.exceptions.ExperimentalWarning")
def test_several_objectives_give_those_that_none_beats(sweep: Sweep, tmp_path: Path) -> None:
    two = (
        "hydra/sweeper=study",
        "hydra.sweeper.objective=[score,other]",
        "hydra.sweeper.directions=[minimize,minimize]",
    )
    assert sweep(*two, BRUTE_FORCE, "value=0,2,3,5", "hydra.sweeper.n_trials=9") == 0
    assert len(table(tmp_path / "swept")) == 4
    best = yaml.safe_load((tmp_path / "swept/best.yaml").read_text(encoding="utf-8"))
    assert {entry["values"]["value"] for entry in best} == {0, 2, 3}


def test_unfit_studies_say_so(sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    says = {
        (*STUDY, "value=1"): "A study needs something to try",
        (*STUDY, "value=interval(0,6)", "size=choice(1,two)"): "size is 'two'; ",
        (*STUDY[:2], "hydra.sweeper.directions=[]", "value=1,2"): "a direction for each objective",
    }
    for arguments, message in says.items():
        assert sweep(*arguments) == 2
        assert message in capsys.readouterr().err
    assert not (tmp_path / "swept").exists()


def test_another_study_in_the_folder_is_refused(tmp_path: Path) -> None:
    space = {"x": CategoricalDistribution(["1", "2"])}
    SweepStudy(tmp_path, ["x"], ["minimize"], space, RandomSampler, seed=0).propose()
    with pytest.raises(ConfigError, match="directions"):
        SweepStudy(tmp_path, ["x"], ["maximize"], space, RandomSampler, seed=0)
    with pytest.raises(ConfigError, match="another search space"):
        SweepStudy(
            tmp_path, ["x"], ["minimize"], {"x": CategoricalDistribution(["3"])}, RandomSampler, seed=0
        ).unfinished()


def test_another_objective_is_refused_once_a_trial_has_succeeded(tmp_path: Path) -> None:
    space = {"x": FloatDistribution(0.0, 1.0)}
    typo = SweepStudy(tmp_path, ["scor"], ["minimize"], space, RandomSampler, seed=0)
    typo.tell(typo.propose().number, None)
    study = SweepStudy(tmp_path, ["score"], ["minimize"], space, RandomSampler, seed=0)
    study.tell(study.propose().number, [1.0])
    SweepStudy(tmp_path, ["score"], ["minimize"], space, RandomSampler, seed=0)
    with pytest.raises(ConfigError, match=r"objective=\['score'\], not \['other'\]"):
        SweepStudy(tmp_path, ["other"], ["minimize"], space, RandomSampler, seed=0)


@pytest.mark.slow
def test_a_study_takes_no_jobs_but_its_own(sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    swept, typed = tmp_path / "swept", (*STUDY, "value=interval(0,6)")
    assert sweep(*typed, "hydra.sweeper.n_trials=1") == 0
    assert sweep("value=1") == 2
    assert "begun with hydra/sweeper=study, not resume" in capsys.readouterr().err
    study = SweepStudy(swept, ["score"], ["minimize"], {"value": FloatDistribution(0.0, 6.0)}, RandomSampler, seed=0)
    assert study.propose().number == 1
    add_jobs(swept, "probe", "study", [SweepJob(1, "another", "1", ("value=9",))])
    assert sweep(*typed, "hydra.sweeper.n_trials=2") == 2
    assert "Trial 1 of the study in swept was begun with another configuration (value=9)" in capsys.readouterr().err
    assert not (swept / "1").exists()


@pytest.mark.slow
def test_a_study_of_before_goes_on_and_stays_one(
    sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sweep(*STUDY, "value=interval(0,6)", "hydra.sweeper.n_trials=1") == 0
    path = tmp_path / "swept/sweep.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content.pop("sweeper") == "study"
    path.write_text(json.dumps(content), encoding="utf-8")
    assert sweep("value=1") == 2
    assert "begun with hydra/sweeper=study" in capsys.readouterr().err
    assert sweep(*STUDY, "value=interval(0,6)", "hydra.sweeper.n_trials=2") == 0


def test_journal_that_a_full_disk_cut(tmp_path: Path) -> None:
    space = {"x": FloatDistribution(0.0, 1.0)}
    study = SweepStudy(tmp_path, ["x"], ["minimize"], space, RandomSampler, seed=0)
    study.tell(study.propose().number, [1.0])
    with (tmp_path / JOURNAL_FILE).open("a", encoding="utf-8") as file:
        file.write('{"op_code":4,"wor')
    study.tell(study.propose().number, [2.0])  # by the same process or by one that ran meanwhile
    with (tmp_path / JOURNAL_FILE).open("a", encoding="utf-8") as file:
        file.write('{"op_code":4,"wor')
    again = SweepStudy(tmp_path, ["x"], ["minimize"], space, RandomSampler, seed=0)
    again.tell(again.propose().number, [0.5])
    found = SweepStudy(tmp_path, ["x"], ["minimize"], space, RandomSampler, seed=0).best()
    assert [best.objectives for best in found] == [(0.5,)]


def test_notation_of_a_search_space() -> None:
    typed = [
        "a=interval(1,2)",
        "b=tag(log,interval(1e-5,1e-2))",
        "c=int(interval(2,9))",
        "d=range(3,10,2)",
        "e=x,y",
        "f=1",
        "g=tag(log,range(1,100))",
    ]
    space = search_space(OverridesParser.create().parse_overrides(typed))
    assert space == {
        "a": FloatDistribution(1.0, 2.0),
        "b": FloatDistribution(1e-5, 1e-2, log=True),
        "c": IntDistribution(2, 9),
        "d": IntDistribution(3, 9, step=2),
        "e": CategoricalDistribution(["x", "y"]),
        "g": IntDistribution(1, 99, log=True),
    }
    assert [corner["d"] for corner in corners(space)] == [3, 9]
    assert [corner["e"] for corner in corners(space)] == ["x", "y"]


@pytest.mark.parametrize(
    "typed",
    [
        "a=interval(6,0)",
        "a=tag(log,interval(0,6))",
        "a=range(3,3)",
        "a=tag(log,range(1,100,2))",
        "a=tag(log,choice(1,10))",
    ],
)
def test_spaces_that_cannot_be_drawn_from_are_named(typed: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(f"A study cannot draw from {typed}: ")):
        search_space(OverridesParser.create().parse_overrides([typed]))


def test_figures_of_a_report(tmp_path: Path) -> None:
    report = {"ladder": [{"chi2": 9.0}, {"chi2": 1.5}], "none": None, "word": "x", "figures": {"uniform.iqm": 3.0}}
    (tmp_path / "report.json").write_text(json.dumps(report), encoding="utf-8")
    assert objectives(tmp_path, ["ladder.-1.chi2", "ladder.0.chi2", "figures.uniform.iqm"]) == (1.5, 9.0, 3.0)
    assert objectives(tmp_path, ["none"])[0] != objectives(tmp_path, ["none"])[0]
    with pytest.raises(UnknownNameError, match="chi2"):
        objectives(tmp_path, ["ladder.0.chi"])
    with pytest.raises(DataError, match="must be a number"):
        objectives(tmp_path, ["word"])


@pytest.mark.parametrize("name", sorted(path.stem for path in (shipped() / "hparams_search").glob("*.yaml")))
def test_shipped_search_spaces(name: str) -> None:
    cfg = compose_with_hydra("train", [f"hparams_search={name}", "hydra.mode=MULTIRUN"], (shipped(),))
    check_hydra(cfg)
    sweeper = cfg.hydra.sweeper
    assert len(sweeper.objective) == len(sweeper.directions)
    space = search_space(OverridesParser.create().parse_overrides([f"{k}={v}" for k, v in sweeper.params.items()]))
    assert len(space) == len(sweeper.params)

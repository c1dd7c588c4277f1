"""Cases side by side: a run that was stopped and resumed ends as one that was not."""

import functools
from math import isnan
from pathlib import Path

import pytest
from pretended_cases import case_of, outcome_of, pretended

from dr_lab.benchmark.case import BenchmarkMachine, CaseSet, expand
from dr_lab.benchmark.outcome import Outcome
from dr_lab.benchmark.pool import finished, keep, run_cases
from dr_lab.errors import ConfigError, UnknownNameError

CRANK = BenchmarkMachine(["plant=crank"], ["model=crank"], ["crank/spring"], [], ["crank/magnet"])
WHEEL = BenchmarkMachine(["plant=wheel"], ["model=wheel"], ["wheel/drag"], ["wheel/two"], [])
MACHINES = {"crank": CRANK, "wheel": WHEEL}


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_resumed_equals_uninterrupted(tmp_path: Path) -> None:
    cases = [case_of("none", seed=seed) for seed in (1, 2, 13, 3)]
    first_asked, asked = (functools.partial(pretended, log=tmp_path / name) for name in ("first", "asked"))
    stopped = run_cases(cases, first_asked, tmp_path / "half" / "cases", 1)
    first, _ = next(stopped)
    stopped.close()
    done = finished(tmp_path / "half" / "cases", cases)
    assert first in done
    keep(tmp_path / "resumed", done)
    left = [case for case in cases if case not in done]
    again = dict(run_cases(left, asked, tmp_path / "resumed", 2))
    assert sorted((tmp_path / "asked").read_text().splitlines()) == sorted(f"{case.name} 1" for case in left)
    whole = dict(run_cases(cases, first_asked, tmp_path / "whole", 1))
    assert {**done, **again} == whole
    assert files(tmp_path / "resumed") == files(tmp_path / "whole")
    assert len(files(tmp_path / "whole")) == 3
    (failed,) = [outcome for outcome in whole.values() if isinstance(outcome, str)]
    assert failed.startswith("DataError: no logs (pretended_cases.py:")


def test_a_number_that_is_not_finite_is_the_same_fresh_and_resumed(tmp_path: Path) -> None:
    case = case_of("none", seed=12)
    asked = functools.partial(pretended, log=tmp_path / "asked")
    fresh = dict(run_cases([case], asked, tmp_path / "cases", 1))[case]
    assert isinstance(fresh, Outcome)
    assert isnan(fresh.chi2)
    assert isnan(finished(tmp_path / "cases", [case])[case].chi2)


def test_files_of_other_settings_are_not_taken_over(tmp_path: Path) -> None:
    case, other = case_of("none"), case_of("single", "spring@arm")
    outcome = outcome_of("none").to_json()
    (tmp_path / f"{other.name}.json").write_text(outcome)
    (tmp_path / f"{case.name}.json").write_text(outcome[: len(outcome) // 2])
    assert finished(tmp_path, [case, other]) == {}


def test_sets_are_products_and_a_case_of_two_sets_comes_once() -> None:
    sets = {
        "none": CaseSet("none", ["encoders", "coarse"], [0, 1]),
        "single": CaseSet("single", ["encoders"], [0, 5]),
        "same": CaseSet("single", ["encoders"], [5], hidden={"crank": ["crank/spring"], "lever": ["x"]}),
        "several": CaseSet("several", ["encoders"], [0]),
        "outside": CaseSet("outside", ["encoders"], [0]),
    }
    cases = expand(sets, MACHINES)
    assert len(cases) == 8 + 4 + 1 + 1
    assert [case.seed for case in cases] == sorted(case.seed for case in cases)
    assert {case.name for case in cases} >= {"crank-spring-encoders-5", "wheel-two-encoders-0", "crank-none-coarse-1"}
    (two,) = [case for case in cases if case.kind == "several"]
    assert two.record == ("plant=wheel",)


def test_a_hidden_effect_that_nobody_knows_is_named() -> None:
    wanted = {"single": CaseSet("single", ["encoders"], [0], hidden={"crank": ["crank/sprig"]})}
    with pytest.raises(UnknownNameError, match=r"(?s)crank/sprig.*machine\.crank\.single.*'crank/spring'"):
        expand(wanted, MACHINES)
    with pytest.raises(ConfigError, match="No case is left"):
        expand({}, MACHINES)

"""Every machine of the benchmark composes as a user would, and hides what its kind says."""

import collections
import functools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import yaml

from dr_lab.benchmark.case import BenchmarkMachine, Case
from dr_lab.benchmark.listed import Entry
from dr_lab.benchmark.redrawn import Redrawn
from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import every
from dr_lab.cli.targets import locate
from dr_lab.errors import ConfigError

MACHINES = every("machine", (shipped(),))
HIDDEN = shipped() / "plant" / "hidden"
NINTHS = 31  # cases of the strangers that are every ninth one


@functools.cache
def phenomena(option: str) -> tuple[str, ...]:
    """Names of what an option of ``plant/hidden`` hides."""
    fields = yaml.safe_load((HIDDEN / f"{option}.yaml").read_text(encoding="utf-8"))
    parts = [part for entry in fields.get("defaults", []) if isinstance(entry, dict) for part in entry.values()]
    kind: Any = locate(fields["_target_"], option)
    return tuple(p for part in parts for p in phenomena(part)) or (kind.name,)


def machine_of(name: str) -> BenchmarkMachine:
    fields = yaml.safe_load((shipped() / "machine" / f"{name}.yaml").read_text(encoding="utf-8"))
    return BenchmarkMachine(**{key: value for key, value in fields.items() if key != "_target_"})


@pytest.mark.parametrize("name", MACHINES)
def test_what_is_hidden_is_of_its_kind(name: str) -> None:
    machine, catalogue = machine_of(name), set(every("effect", (shipped(),)))
    for option in machine.single:
        assert len(phenomena(option)) == 1
        assert set(phenomena(option)) <= catalogue
    for option in machine.several:
        assert len(phenomena(option)) > 1
        assert set(phenomena(option)) <= catalogue
    for option in machine.outside:
        assert catalogue.isdisjoint(phenomena(option))


@pytest.mark.parametrize("name", MACHINES)
def test_logs_and_model_compose(name: str) -> None:
    machine = machine_of(name)
    source = compose("record", [*machine.record, "plant/instruments=exact"]).source
    kind = "plant.PlantSource" if "source=model" not in machine.record else "model.ModelSource"
    assert source["_target_"] == f"dr_lab.sources.{kind}"
    cfg = compose(
        "diagnose", [*machine.diagnose, "++measurements.outputs={a.position:{noise_std:0.1}}", "effect=spring"]
    )
    assert cfg.measurements.outputs["a.position"].noise_std == 0.1


@functools.cache
def cases_of(preset: str) -> tuple[Case, ...]:
    return compose_arguments("benchmark", [f"benchmark={preset}"], (shipped(),))["plan"].chosen()


@pytest.mark.parametrize("preset", [pytest.param("full", marks=pytest.mark.slow), "quick"])
def test_presets_expand(preset: str) -> None:
    cases = cases_of(preset)
    machines = {name for name in MACHINES if machine_of(name).single}
    assert {case.machine for case in cases} == machines
    none = sum(case.kind == "none" for case in cases)
    least, alone = {"full": (25, 17), "quick": (4, 1)}[preset]
    assert len(cases) - none >= (least - alone) * len(machines)
    assert none >= alone * len(machines)


def hidden_in(case: Case) -> list[str]:
    """Names, as the catalogue has them, of what a listed case hides."""
    options = [label.partition("@")[0] for label in case.hidden.split(" + ") if label != "none"]
    return [name for option in options for name in phenomena(f"general/{option}")]


# Of bodies that fly, as no stranger does; tests/recovery/test_recovery_of_viscous_drag.py hides it at three magnitudes.
FLYING = {"viscous_drag"}
# MuJoCo's own dry friction, which no other engine has, and what makes it hard, which no stranger's model has as its
# own; tests/recovery names the first in logs that MuJoCo made, tests/unit/comparison the second.
MUJOCOS = {"soft_friction", "hard_friction"}


@pytest.mark.slow
def test_strangers_hide_the_whole_catalogue_at_three_magnitudes() -> None:
    cases, catalogue = cases_of("strangers"), set(every("effect", (shipped(),)))
    kinds = collections.Counter(case.kind for case in cases)
    assert len(cases) >= 120
    assert kinds["none"] >= 40
    assert len({case.name for case in cases}) == len(cases) == len({case.seed for case in cases})
    singles = collections.Counter(name for case in cases if case.kind == "single" for name in hidden_in(case))
    assert {name for name, count in singles.items() if count >= 3} == catalogue - FLYING - MUJOCOS
    several = [hidden_in(case) for case in cases if case.kind == "several"]
    assert {len(names) for names in several} == {2, 3, 4, 6}
    assert set().union(*several) <= catalogue
    outside = [name for case in cases if case.kind == "outside" for name in hidden_in(case)]
    assert catalogue.isdisjoint(outside)
    assert {case.instruments for case in cases if case.kind == "none"} >= {"correlated", "low_passed", "quantised"}


def test_entries_give_every_number_that_is_asked_for() -> None:
    for preset in ("strangers", "table"):
        fields = yaml.safe_load((shipped() / "benchmark" / f"{preset}.yaml").read_text(encoding="utf-8"))
        for name, entry in ((n, e) for wanted in fields["cases"].values() for n, e in wanted["entries"].items()):
            for label, numbers in entry.get("hide", {}).items():
                option, _, site = label.partition("@")
                asked = yaml.safe_load((HIDDEN / "general" / f"{option}.yaml").read_text(encoding="utf-8"))
                needed = {key for key, value in asked.items() if value == "???"}
                assert needed - {"site"} <= numbers.keys() <= asked.keys(), (name, label)
                assert site, (name, label)
                assert "site" in asked, (name, label)


@pytest.mark.slow
def test_the_table_is_part_of_the_strangers() -> None:
    assert set(cases_of("table")) <= set(cases_of("strangers"))


def drawn(number: int, times: int) -> list[dict[str, Case]]:
    plan = compose_arguments("benchmark", ["benchmark=redrawn", f"draw={number}"], (shipped(),))["plan"]
    return [{case.name.removesuffix(f"_draw_{number}"): case for case in plan.chosen()} for _ in range(times)]


@pytest.mark.slow
def test_a_drawing_has_every_stranger_with_other_seeds_sizes_and_noise() -> None:
    listed = {case.name: case for case in cases_of("strangers")}
    (first, again), (second,) = drawn(1, 2), drawn(2, 1)
    assert first == again
    assert first.keys() == second.keys() == listed.keys()
    for name, case in first.items():
        old, other = listed[name], second[name]
        assert (case.machine, case.kind, case.hidden, case.diagnose) == (
            old.machine,
            old.kind,
            old.hidden,
            old.diagnose,
        )
        assert len({case.seed, old.seed, other.seed}) == 3
        assert case.record != other.record or not hidden_in(case), name
    assert len({case.seed for case in first.values()}) == len(first)
    slide = "lift_cogging_of_a_pitch_of_50_mm"
    assert "plant.hidden.periods=125.7" in first[slide].record  # as the judge's grid has it


def test_drawn_sizes_keep_within_the_spread_and_shares_keep_their_side_of_one() -> None:
    drawn_again = Redrawn("single", {}, 3, 1.4, ["torque_scale.gain"], ["end_stop.loss"], ["white"])
    sizes = [_sized(drawn_again, seed) for seed in range(200)]
    for size in sizes:
        assert 0.1 / 1.4 - 1e-4 <= size["stiffness"] <= 0.1 * 1.4 + 1e-4
        assert size["rest"] / size["stiffness"] == pytest.approx(2.0, rel=1e-3)
        assert 0.8**1.4 - 1e-4 <= size["gain"] <= 0.8 ** (1 / 1.4) + 1e-4
        assert (size["loss"], size["periods"], size["other"]) == (0.5, 9, "shoulder")
    logs = np.log([size["stiffness"] / 0.1 for size in sizes]) / np.log(1.4)
    assert abs(logs.mean()) < 3 / np.sqrt(3 * len(sizes))


def _sized(drawing: Redrawn, seed: int) -> dict[str, Any]:
    hide = {
        "spring@wheel": {"stiffness": 0.1, "rest": 0.2},
        "torque_scale@motor": {"gain": 0.8},
        "end_stop@wheel": {"loss": 0.5},
        "cogging@wheel": {"periods": 9},
        "joint_coupling@wheel": {"other": "shoulder"},
    }
    entry = {"machine": "wheel", "seed": 0, "hide": hide}
    machine = BenchmarkMachine([], [], [], [], [])
    (case,) = replace(drawing, draw=seed, entries={"a": entry}).cases("set", {"wheel": machine})
    pairs = (text.partition("=") for text in case.record if "part_" in text and "general" not in text)
    return {place.rpartition(".")[2]: yaml.safe_load(value) for place, _, value in pairs if "site" not in place}


def test_a_drawing_needs_instruments_and_a_spread() -> None:
    with pytest.raises(ConfigError, match=r"spread is 0\.5"):
        Redrawn("single", {}, 1, 0.5, [], [], ["white"])
    with pytest.raises(ConfigError, match="noises is empty"):
        Redrawn("single", {}, 1, 1.5, [], [], [])


def every_ninth() -> Iterator[object]:
    """Numbers among every ninth case, of which two of three are left to the slow tests."""
    for number in range(NINTHS):
        yield pytest.param(number, marks=[pytest.mark.slow] if number % 3 else [])


@pytest.mark.parametrize("number", list(every_ninth()))
def test_listed_cases_compose(number: int) -> None:
    assert len(cases_of("strangers")[::9]) == NINTHS
    case = cases_of("strangers")[9 * number]
    source = compose("record", case.recording(case.instruments)).source
    named = source.get("plant", {}).get("hidden", {})
    assert len(named.get("effects", {}) or [named]) == max(len(hidden_in(case)), 1), case.name
    compose("diagnose", [*case.diagnose, "effect=spring"])


def test_an_entry_becomes_overrides() -> None:
    one = Entry("wheel", 1, {"spring@wheel": {"stiffness": 0.1}}, instruments="white")
    assert one.overrides() == (
        "plant/hidden=general/spring",
        "plant.hidden.site=wheel",
        "plant.hidden.stiffness=0.1",
        "plant/instruments=white",
    )
    two = Entry("elbow", 1, {"tool@forearm": {"place": [0.0, 0.1, 0.0]}, "tool@upper_arm": {"mass": 1.0}})
    assert two.hidden == "tool@forearm + tool@upper_arm"
    assert two.overrides()[1:4] == (
        "+plant/hidden@plant.hidden.effects.part_1=general/tool",
        "plant.hidden.effects.part_1.site=forearm",
        "plant.hidden.effects.part_1.place=[0.0,0.1,0.0]",
    )


def test_arguments_are_those_of_the_verb() -> None:
    built = compose_arguments("record", ["source=plant", "seed=3"], (shipped(),))
    assert set(built) == {"source", "seed", "output"}

"""Every machine of the benchmark composes as a user would, and hides what its kind says."""

import functools

import pytest
import yaml

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.compose import compose, options
from dr_lab.cli.folders import shipped
from dr_lab.cli.targets import locate
from dr_lab.workflows.benchmark_cases.case import CaseSet, Machine, expand

MACHINES = list(options("machine", (shipped(),)))
HIDDEN = shipped() / "plant" / "hidden"


@functools.cache
def phenomena(option: str) -> tuple[str, ...]:
    """Names of what an option of ``plant/hidden`` hides."""
    fields = yaml.safe_load((HIDDEN / f"{option}.yaml").read_text(encoding="utf-8"))
    parts = [part for entry in fields.get("defaults", []) if isinstance(entry, dict) for part in entry.values()]
    return tuple(p for part in parts for p in phenomena(part)) or (vars(locate(fields["_target_"], option))["name"],)


def machine_of(name: str) -> Machine:
    fields = yaml.safe_load((shipped() / "machine" / f"{name}.yaml").read_text(encoding="utf-8"))
    return Machine(**{key: value for key, value in fields.items() if key != "_target_"})


@pytest.mark.parametrize("name", MACHINES)
def test_what_is_hidden_is_of_its_kind(name: str) -> None:
    machine, catalogue = machine_of(name), set(options("effect", (shipped(),)))
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
    assert source["_target_"] == "dr_lab.workflows.record_plant.PlantSource"
    cfg = compose(
        "diagnose", [*machine.diagnose, "++measurements.outputs={a.position:{noise_std:0.1}}", "effect=spring"]
    )
    assert cfg.measurements.outputs["a.position"].noise_std == 0.1


@pytest.mark.parametrize("preset", options("benchmark", (shipped(),)))
def test_presets_expand(preset: str) -> None:
    fields = yaml.safe_load((shipped() / "benchmark" / f"{preset}.yaml").read_text(encoding="utf-8"))
    sets = {
        name: CaseSet(**{key: value for key, value in wanted.items() if key != "_target_"})
        for name, wanted in fields["cases"].items()
    }
    machines = {name: machine_of(name) for name in MACHINES}
    cases = expand(sets, machines)
    assert {case.machine for case in cases} == set(MACHINES)
    none = sum(case.kind == "none" for case in cases)
    least, alone = {"full": (25, 17), "quick": (4, 1)}[preset]
    assert len(cases) - none >= (least - alone) * len(MACHINES)
    assert none >= alone * len(MACHINES)
    for wanted in sets.values():
        assert set(wanted.hidden or ()) <= set(MACHINES)


def test_arguments_are_those_of_the_verb() -> None:
    built = compose_arguments("record", ["source=plant", "seed=3"], (shipped(),))
    assert set(built) == {"source", "seed", "output"}

"""The judge of the strangers asks about those effects that the diagnosis may answer with, and no others."""

from dataclasses import replace

import pytest
from hydra.utils import instantiate
from strangers import STRANGERS, needs_pinocchio

from dr_lab.cli.compose import compose
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.effect import Scales

SHORT = ["plant.duration=0.3", "plant/hidden=none"]


def judged(machine: str, instruments: str) -> dict[str, int]:
    """Rivals of the judge by label, with their numbers of parameters."""
    overrides = [f"plant=strangers/{machine}", *SHORT, f"plant/instruments={instruments}"]
    bench = instantiate(compose("record", overrides).plant, _convert_="all")
    rule = replace(instantiate(compose("benchmark", ["benchmark=strangers"]).classes.rule), parts=1)
    first = replace(bench, peaks=bench.peaks[:1])
    return {rival.label: rival.parameters for rival in rule.regression(first, seed=1).rivals}


def answered(machine: str, kinds: tuple[str, ...]) -> dict[str, int]:
    """Candidates of the diagnosis by label, with their numbers of parameters, where all joints move alike."""
    config = compose("diagnose", [f"model=strangers/{machine}", f"measurements=strangers/{machine}"])
    model, effects = (instantiate(part, _convert_="all") for part in (config.model, config.effects))
    compiled = model.nominal()
    joints = [compiled.joint(row).name for row in range(compiled.njnt)]
    one = dict.fromkeys(joints, 1.0)
    commands = {compiled.actuator(row).name: 1.0 for row in range(compiled.nu)}
    scales = Scales(dict.fromkeys(joints, -0.5), dict.fromkeys(joints, 0.5), one, one, commands)
    channels = {f"{joint}.{kind}" for joint in joints for kind in kinds}
    placed = candidates(model, effects, scales, compiled, channels).placed
    return {effect.label: len(effect.parameters) for effect in placed}


@needs_pinocchio
@pytest.mark.parametrize(
    "machine",
    [pytest.param(m, marks=[pytest.mark.slow] if m.startswith(("six", "seven")) else []) for m in STRANGERS],
)
def test_the_judges_rivals_are_the_candidates(machine: str) -> None:
    assert judged(machine, "white") == answered(machine, ("position",))


@needs_pinocchio
def test_where_tachometers_measure_their_filters_are_rivals() -> None:
    known = judged("wheel", "tachometers")
    assert known == answered("wheel", ("position", "velocity"))
    assert known["velocity_low_pass@wheel"] == 1

from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.faults.unit_suspicion import UnitSuspicion, suspect_degrees

LOGS = ["measurements.fit=['log_1[0:3]']", "measurements.held_out=['log_5[0:3]']"]


def suspicion(*overrides: str) -> UnitSuspicion | None:
    cfg = compose("compare", [*LOGS, *overrides])
    built = {
        key: instantiate(cfg[key], _convert_="all") for key in ("model", "measurements", "faults", "windows", "solver")
    }
    rules = built["faults"].degrees
    return suspect_degrees(built["model"], built["measurements"], rules, built["windows"], built["solver"], threads=1)


def test_smooth_degrees_without_steps_are_told_by_the_model() -> None:
    scales = [f"measurements.outputs.{joint}.position.scale=57.29577951308232" for joint in ("arm", "pole")]
    limits = ["measurements.contract.unit_quantum=0", "measurements.contract.speed_limit=1.0e9"]
    found = suspicion(*scales, *limits)
    assert found is not None
    assert found.channels == ("arm.position", "pole.position")
    assert found.chi2 > 100 * found.chi2_read_anew


def test_radians_are_not_suspected_whatever_the_model_lacks() -> None:
    assert suspicion() is None
    assert suspicion("measurements.outputs.arm.position.sign=-1") is None

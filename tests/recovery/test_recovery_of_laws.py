"""Laws that hold a poorer one are told from it: what was hidden in a Furuta pendulum is named among its rivals."""

from pathlib import Path

import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.search.climb import Climb, climb
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.workflows.record import record

PLANT = ["plant.duration=3.0", "plant.peaks=[8.0,6.0,7.0,5.0]"]
DATA = ["measurements.fit=[log_1,log_2,log_3]", "measurements.held_out=[log_4]", "windows.seconds=4.8", "threads=1"]
# what is hidden with its numbers, those that it is tried beside, the parameter that tells it and its true value
CREEP = (["creeping_friction", "site=arm", "torque=0.002", "creep=0.5"], "coulomb_friction,stribeck_friction")
WARMING = (["warming", "site=arm", "cold=3e-4", "constant=1.5"], "coulomb_friction,viscous_friction")
THRUST = (["command_power", "site=motor", "full=8.0", "exponent=1.6"], "dead_zone,saturation,torque_scale")


@pytest.mark.parametrize(
    ("hidden", "beside", "parameter", "truth"),
    [
        pytest.param(*CREEP, "smooth_friction@arm.creep", 0.5, marks=pytest.mark.slow),
        pytest.param(*WARMING, "friction_drift@arm.rate", 1 / 1.5, marks=pytest.mark.slow),
        pytest.param(*THRUST, "command_power@motor.exponent", 1.6, marks=pytest.mark.slow),
    ],
)
def test_a_richer_law_is_named_among_poorer_ones(
    hidden: list[str], beside: str, parameter: str, truth: float, tmp_path: Path
) -> None:
    name, *numbers = hidden
    label, _, _ = parameter.rpartition(".")
    overrides = [f"plant/hidden=general/{name}", *(f"plant.hidden.{number}" for number in numbers), *PLANT]
    record(instantiate(compose("record", ["experiment=furuta_demo", *overrides]).source), str(tmp_path), 0, tmp_path)
    logs = f"measurements.logs=[{tmp_path}/*.mcap]"
    cfg = compose("diagnose", [logs, f"effect=[{label.partition('@')[0]},{beside}]", *DATA])
    study = prepare(instantiate(cfg.comparison, _convert_="all"))
    effects = instantiate(cfg.effects, _convert_="all")
    begun = Climb.begun(study.bench, calibrate(study))
    ladder = climb(begun, effects, study.scales, study.compiled, most=0, watch=Silence())
    (rung,) = ladder.rungs
    assert rung.verdict.effects == (label,), rung.verdict.reason
    best = next(c.fitted_model for c in rung.ranking if c.effect.label == label)
    assert best.held_out.chi2 < 1.2
    assert best.values()[parameter] == pytest.approx(truth, rel=0.15)

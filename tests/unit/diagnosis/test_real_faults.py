"""Faults of real logs; needs DR_LAB_DATA, the folder that holds them."""

import os

import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.comparison.comparison import Comparison
from dr_lab.diagnosis.faults.data_faults import Fault
from tests.diagnosis_machines import suspected

pytestmark = pytest.mark.skipif(
    "DR_LAB_DATA" not in os.environ, reason="DR_LAB_DATA is not set: export DR_LAB_DATA=FOLDER of the real data sets"
)


def told(experiment: str, *overrides: str) -> tuple[Fault, ...]:
    cfg = compose("close", [f"experiment={experiment}", "effect=spring", *overrides])
    comparison = instantiate(cfg.comparison, _convert_="all")
    assert isinstance(comparison, Comparison)
    return suspected(comparison.model, comparison.measurements, comparison.settings.faults)


@pytest.mark.slow
def test_the_cart_pole_s_motor_is_off_for_the_first_half_second() -> None:
    """In all 15 logs the cart rolls out by 4 mm at most from 0.2 to 0.5 s, and then moves 23 mm or more in 0.3 s."""
    faults = told("quanser_cartpole", "measurements.fit=[qcp*19-3*]", "measurements.held_out=[qcp*19-4*,qcp*19-2*]")
    assert {fault.kind for fault in faults} == {"off"}
    assert len(faults) >= 10  # every chirp
    for fault in faults:
        assert fault.begin < 0.25
        assert fault.end == pytest.approx(0.5, abs=0.1)
        assert "[0.7:" in fault.remedy


@pytest.mark.slow
@pytest.mark.parametrize("experiment", ["quanser_cartpole", "quanser_qube", "emps"])
def test_sound_logs_are_not_called_faulty(experiment: str) -> None:
    assert told(experiment) == ()

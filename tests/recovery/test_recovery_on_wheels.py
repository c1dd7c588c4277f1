"""A wheel's friction is found on a rover whose place is measured, though its contacts are stiff."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import measured, model_of, solver_settings, windows_settings
from effect_machines import placed, scales_of
from rover import OUTPUTS, drive, rover

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.trajectory import Noise

FRICTION = 0.08  # N·m
PARAMETERS = {
    "chassis.mass": {"target": "body.chassis.mass", "unit": "kg", "low": 3.0, "high": 12.0},
    "left.damping": {"target": "joint.left.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 0.04},
    "right.damping": {"target": "joint.right.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 0.04},
}


@pytest.mark.slow
def test_the_friction_of_a_wheel_is_found_from_none() -> None:
    logs = [drive(rover(FRICTION), 5.0, seed).log(f"log_{seed}", seed) for seed in (1, 2)]
    data = replace(measured(logs), noise={name: Noise(std, "", "given") for name, std in OUTPUTS.items()})
    windows = cut(logs, data, mujoco.MjModel.from_xml_string(rover()), windows_settings(seconds=3.0))
    plain, settings = model_of(rover(), PARAMETERS), solver_settings()
    without = Fitter(Replay(plain, windows, 1), settings).run(plain.space.nominal)
    scales = scales_of(plain, torque=0.2, speed=10.0)
    model = plain.with_effect(placed(plain, "soft_friction", "left", scales))
    replay = Replay(model, windows, 1)
    found = Fitter(replay, settings).run(np.append(without.z, model.space.nominal[len(without.z) :]), without.delta)
    values = model.space.mapping(found.z)
    assert values["soft_friction@left.torque"] == pytest.approx(FRICTION, rel=0.03)
    assert values["soft_friction@left.softness"] == pytest.approx(1.0, abs=0.2)
    assert values["left.damping"] == pytest.approx(0.01, rel=0.1)
    assert found.cost < 1.3 * replay.fitted.sum()
    assert without.cost > 20 * found.cost

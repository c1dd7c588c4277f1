"""Where the model's step moves an output, the study goes on with one that does not, if the logs ask for more."""

from pathlib import Path

import mujoco
import numpy as np

from dr_lab.comparison.export import write_model
from dr_lab.comparison.notes import study_notes
from dr_lab.comparison.study import Study, prepare
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Log
from tests.diagnosis_machines import measured, short_comparison
from tests.element_machines import NOISE, machine, own_log

FREE = {"rod.mass": {"target": "body.rod.mass", "unit": "kg", "low": 0.2, "high": 1.2}}


def study(friction: float) -> tuple[Model, Study]:
    """A servo with a lag at its step of 2 ms, and logs of the same with a step of 0.25 ms and friction."""
    given = machine("position_timeconst")
    true = given.spec.copy()
    true.joint("hinge").frictionloss = friction
    if friction:
        true.option.timestep /= 8
    model = from_spec("servo", given.spec, FREE)
    logs = [own_log(Model("position", true, (), {}), seed, seconds=2.5) for seed in range(2)]
    return model, prepare(short_comparison(model, measured([_thinned(log) for log in logs], noise=NOISE)))


def _thinned(log: Log) -> Log:
    """Samples every 2 ms at most."""
    outputs = {}
    for name, signal in log.outputs.items():
        part = slice(None, None, max(1, round(0.002 / float(np.diff(signal.time[:2])[0]))))
        outputs[name] = type(signal)(name, signal.unit, signal.time[part], signal.value[part])
    return Log(log.name, outputs, log.commands)


def test_logs_of_the_very_model_keep_its_step() -> None:
    model, found = study(friction=0.0)
    assert found.floor.largest > 0.2
    assert found.model is model
    assert found.bench.timing_resolution == 0.002
    (note,) = (note for note in study_notes(found) if note.kind == "time_step")
    assert "leaves no more than noise with it" in note.message


def test_a_gap_is_looked_at_with_a_step_that_does_not_show(tmp_path: Path) -> None:
    model, found = study(friction=0.05)
    assert found.model is not model
    assert found.refinement.left <= 0.2 < found.refinement.share
    assert found.bench.timing_resolution == 0.002
    assert found.bench.fit.step == found.compiled.opt.timestep
    (note,) = (note for note in study_notes(found) if note.kind == "time_step")
    assert "in its place" in note.message
    write_model(tmp_path / "model.xml", found.model, found.model.space.nominal)
    again = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    assert again.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    assert again.actuator_dyntype[0] == mujoco.mjtDyn.mjDYN_FILTER

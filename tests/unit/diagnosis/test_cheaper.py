"""Slopes by cheaper steps: those of the model as given in place of their parts."""

import numpy as np
import pytest
from diagnosis_machines import PENDULUM, PENDULUM_PARAMETERS, model_of, solver_settings, swinging, windows_of

from dr_lab.diagnosis.fit.cheaper import cheaper
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.windows.coarser import coarser
from dr_lab.diagnosis.windows.finer import finer
from dr_lab.physics.divided import in_parts, whole
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator

NOISE = 1e-5  # rad
PARTS = 4


def euler() -> Model:
    return model_of(PENDULUM.replace("RK4", "implicitfast"), PENDULUM_PARAMETERS)


def test_a_step_in_parts_is_whole_again() -> None:
    model = euler()
    fine = in_parts(in_parts(model, 2), 2)
    assert fine.parts == PARTS
    assert whole(fine).spec.to_xml() == model.spec.to_xml()
    assert whole(model) is model


def test_coarser_windows_undo_finer_ones() -> None:
    model = euler()
    windows = windows_of(model, [swinging("a", model.nominal(), 0, noise=NOISE)], noise=NOISE)
    again = coarser(finer(windows, PARTS), PARTS)
    assert again.step == windows.step
    for name in ("controls", "past"):
        np.testing.assert_allclose(getattr(again, name), getattr(windows, name), atol=1e-12)
    for name in ("qpos", "qvel", "controls"):
        np.testing.assert_allclose(getattr(again.before, name), getattr(windows.before, name), atol=1e-12)


def test_steps_that_fill_no_group_are_left_out_before_and_filled_up_behind() -> None:
    model = euler()
    windows = windows_of(model, [swinging("a", model.nominal(), 0, noise=NOISE)], noise=NOISE)
    count, past = windows.controls.shape[1], windows.past.shape[1]
    found = coarser(windows, 3)
    assert found.controls.shape[1] == -(-count // 3)
    assert found.past.shape[1] == past // 3
    np.testing.assert_allclose(found.controls[:, 0], windows.controls[:, :3].mean(1))
    np.testing.assert_allclose(found.past[:, -1], windows.past[:, -3:].mean(1))


def test_a_fit_at_a_finer_step_takes_its_slopes_by_the_step_as_given(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its cost is that of its own steps, so it ends where a fit by slopes of these does."""
    model = euler()
    fine, steps = in_parts(model, PARTS), list[float]()
    windows = windows_of(fine, [swinging("a", fine.nominal(), 0, noise=NOISE)], noise=NOISE)
    replay = Replay(fine, windows, 1)
    assert replay.quick.windows.step == model.spec.option.timestep
    assert cheaper(model, windows, touching=False) == (model, windows)
    assert cheaper(fine, windows, touching=True) == (fine, windows)
    replayed = Simulator.replay

    def counted(self: Simulator, z: np.ndarray, *rest: object) -> object:
        steps.append(self.compiled.opt.timestep)
        return replayed(self, z, *rest)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(Simulator, "replay", counted)
    found = Fitter(replay, solver_settings(tolerance=1e-3)).run(model.space.nominal)
    assert {*steps} == {model.spec.option.timestep, fine.spec.option.timestep}
    exact = Fitter(replay.exact(), solver_settings(tolerance=1e-3)).run(model.space.nominal)
    assert found.cost <= exact.cost * (1 + 1e-3)
    np.testing.assert_allclose(found.z, exact.z, rtol=1e-3)
    np.testing.assert_allclose(found.z, [0.5, 0.05], rtol=2e-3)

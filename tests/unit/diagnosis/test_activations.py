import mujoco
import numpy as np
import pytest
from effect_machines import placed

from dr_lab.diagnosis.experiment import play
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.missing_force.residual_force import residual_forces
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.physics.activations import holders, resting, time_constants
from dr_lab.trajectory import Signal
from tests.diagnosis_machines import NOISE as LARGE
from tests.diagnosis_machines import measured, solver_settings, windows_of, windows_settings
from tests.element_machines import NOISE, machine, own_log


def test_each_type_forgets_in_its_own_time() -> None:
    expected = {
        "motor": [],
        "position_timeconst": [0.05],
        "cylinder_slow": [1.0],
        "muscle": [2 * 0.04],
        "filter": [0.03],
        "integrator": [np.inf],
        "user": [np.inf],
        "pid": [np.inf],
        "dcmotor_inductance": [0.04 / 2],
        "dcmotor_controller": [np.inf, np.inf, 0.02 / 2],
    }
    for name, constants in expected.items():
        compiled = machine(name).nominal()
        np.testing.assert_allclose(time_constants(compiled), constants, err_msg=name)
        assert holders(compiled) == ("drive",) * len(constants)


def test_a_servo_that_integrates_rests_where_it_pushes_with_no_force() -> None:
    compiled = machine("intvelocity").nominal()
    act = resting(compiled, np.array([[0.7], [5.0]]), np.zeros((2, 1)))
    np.testing.assert_allclose(act, [[0.7], [2.0]])  # the second at the end of its range
    data = mujoco.MjData(compiled)
    data.qpos[:], data.act[:] = 0.7, act[0]
    mujoco.mj_forward(compiled, data)
    assert data.actuator_force[0] == pytest.approx(0.0, abs=1e-12)


def test_a_filter_rests_at_its_limited_command() -> None:
    act = resting(machine("muscle").nominal(), np.zeros((2, 1)), np.array([[0.3], [4.0]]))
    np.testing.assert_allclose(act, [[0.3], [1.0]])


def test_an_experiment_begins_where_its_filtered_first_command_has_settled() -> None:
    """A dead zone of 0.3 makes 1.3 the command that 1.0 is without one, and other contexts begin elsewhere."""
    plain = machine("filter")
    zoned = plain.with_effect(placed(plain, "dead_zone", "drive"))
    z = np.array([zoned.space.vector({"dead_zone@drive.width": width}) for width in (0.3, 0.0)])
    sent = [{"drive": Signal("drive", "", np.array([0.0]), np.array([value]))} for value in (1.0, 1.3)]
    own, other = (play(model, at, np.zeros(1), sent, 0.1).tape.qpos for model, at in ((plain, z[:1, :0]), (zoned, z)))
    np.testing.assert_array_equal(other[0, 1], own[0, 0])
    np.testing.assert_array_equal(other[1], own[0])


def test_filters_start_where_the_commands_before_leave_them() -> None:
    """y' = (u − y)/τ, exact for commands that are held through a step: y ← u + (y − u) exp(−h/τ)."""
    model, tau = machine("position_timeconst"), 0.05
    log = own_log(model, 1)
    windows = cut([log], measured([log], noise=NOISE), model.nominal(), windows_settings())
    assert windows.activations is not None
    assert len(windows.activations.unknown) == 0
    assert windows.before.qpos.shape[1] == 250  # ten time constants
    replay = Replay(model, windows, 1)
    tape, _ = replay.simulate(np.zeros((1, 0)), np.zeros((1, len(windows), replay.nstate)))
    command = log.commands["drive"]
    for begin, start in zip(windows.begin, tape.start[0], strict=True):
        level = 0.0
        for k in range(round(begin / windows.step)):
            held = command.value[np.searchsorted(command.time, k * windows.step + 1e-9, side="right") - 1]
            level = held + (level - held) * np.exp(-windows.step / tau)
        data = mujoco.MjData(replay.compiled)
        mujoco.mj_setState(replay.compiled, data, start, mujoco.mjtState.mjSTATE_INTEGRATION)
        assert data.act[0] == pytest.approx(level, abs=2e-4)


def test_activations_that_never_forget_are_unknowns_of_a_window() -> None:
    model = machine("integrator")
    log = own_log(model, 1)
    replay, fit = fit_states(model, np.zeros(0), windows_of(model, [log], noise=NOISE), solver_settings(), 1)
    assert replay.nstate == 3
    assert fit.delta.shape == (12, 3)
    tape, _ = replay.simulate(np.zeros((1, 0)), fit.delta[None])
    command, data = log.commands["drive"], mujoco.MjData(replay.compiled)
    for begin, start in zip(replay.windows.begin, tape.start[0], strict=True):
        lasted = np.diff(np.minimum(np.append(command.time, np.inf), begin))
        mujoco.mj_setState(replay.compiled, data, start, mujoco.mjtState.mjSTATE_INTEGRATION)
        assert data.act[0] == pytest.approx(lasted @ command.value, abs=5e-3)


def test_a_missing_force_is_told_beside_unknown_activations() -> None:
    model = machine("intvelocity")
    windows = windows_of(model, [own_log(model, 1)], windows_settings(length=0.1), noise=LARGE)
    forces = residual_forces(*fit_states(model, np.zeros(0), windows, solver_settings(), 1), solver_settings())
    assert np.isfinite(forces["hinge"].force).all()

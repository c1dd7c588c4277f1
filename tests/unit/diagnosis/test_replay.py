import mujoco
import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    STEP,
    log_of,
    model_of,
    pendulum,
    simulated,
    steps_command,
    swinging,
    true_starts,
    windows_of,
    windows_settings,
)
from effect_machines import placed
from mujoco.batch import Batch

from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.errors import DataError
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log

BALL = f"""<mujoco model="ball">
  <option timestep="{STEP}" integrator="RK4"/>
  <worldbody><body name="rod">
    <joint name="shoulder" type="ball" damping="0.01"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0.1 0 -0.4"/>
    <body name="tip" pos="0.1 0 -0.4"><joint name="hinge" axis="0 1 0"/><geom type="capsule" size="0.02"
      fromto="0 0 0 0 0 -0.3"/></body>
  </body></worldbody>
  <actuator><motor name="idle" joint="hinge"/><motor name="drive" joint="hinge"/></actuator>
  <sensor><framequat name="pose" objtype="body" objname="rod"/></sensor>
</mujoco>"""


def own_log(model: Model, late: float = 0.0) -> tuple[Log, dict[str, Array]]:
    """A noiseless log of a machine by its own model: position at uneven steps, velocity at every fifth."""
    command = steps_command("drive", 1.0, 3.0, seed=0)
    motion = simulated(model.nominal(), command, 3.0, qpos=[0.8])
    keep = np.sort(np.random.default_rng(0).choice(len(motion["time"]), 900, replace=False))
    keep[0], keep[-1] = 0, len(motion["time"]) - 1
    outputs = {
        "hinge.position": (motion["time"][keep] + late, motion["qpos"][keep, 0]),
        "hinge.velocity": (motion["time"][::5] + late, motion["qvel"][::5, 0]),
    }
    return log_of("a", outputs, command), motion


def residuals(replay: Replay, z: Array, motion: dict[str, Array]) -> Array:
    found, infeasible = replay.residuals(z[None], true_starts(replay, z, motion)[None])
    assert not infeasible.any()
    return found[0]


def test_a_model_replays_its_own_log_without_residual() -> None:
    model = pendulum()
    log, motion = own_log(model)
    replay = Replay(model, windows_of(model, [log]), 1)
    found = residuals(replay, model.space.nominal, motion)
    assert replay.scored.sum() > 1000
    np.testing.assert_allclose(found, 0.0, atol=1e-8 / NOISE)


def test_between_steps_the_error_is_that_of_the_interpolation() -> None:
    model = pendulum()
    command = steps_command("drive", 1.0, 3.0, seed=0)
    fine = simulated(model.nominal(), command, 3.0, qpos=[0.8])
    finer = model.nominal()
    finer.opt.timestep = STEP / 7
    odd = simulated(finer, command, 3.0, qpos=[0.8])
    replay = Replay(
        model, windows_of(model, [log_of("a", {"hinge.position": (odd["time"], odd["qpos"][:, 0])}, command)])
    )
    assert np.abs(residuals(replay, model.space.nominal, fine)).max() * NOISE < 1e-6  # rad


def test_several_contexts_at_once_are_the_same_as_one_by_one() -> None:
    model = pendulum()
    log, _ = own_log(model)
    replay = Replay(model, windows_of(model, [log]), 1)
    rng = np.random.default_rng(0)
    z = model.space.from_unit(rng.uniform(0.1, 0.9, (3, 2)))
    delta = 0.01 * rng.normal(size=(3, len(replay.windows), 2))
    together, _ = replay.residuals(z, delta)
    for k in range(3):
        np.testing.assert_allclose(replay.residuals(z[k : k + 1], delta[k : k + 1])[0][0], together[k], atol=1e-9)


def test_a_ball_joint_and_two_actuators_replay_without_residual() -> None:
    model = model_of(BALL)
    compiled = model.nominal()
    rng = np.random.default_rng(1)
    qpos = compiled.qpos0.copy()
    mujoco.mj_integratePos(compiled, qpos, rng.normal(size=4), 0.5)
    command = steps_command("drive", 0.3, 2.0, seed=0)

    def drive(data: mujoco.MjData) -> None:
        data.ctrl[:] = 0.0, data.ctrl[0]

    motion = simulated(compiled, command, 2.0, qpos=qpos.tolist(), force=drive)
    channels = {
        "hinge.position": (motion["time"], motion["qpos"][:, 4]),
        "sensor.pose": (motion["time"], motion["sensordata"]),
    }
    windows = windows_of(model, [log_of("a", channels, command)])
    assert windows.controls.shape[2] == 2
    assert not windows.controls[..., 0].any()
    replay = Replay(model, windows, 1)
    assert replay.nstate == 8
    np.testing.assert_allclose(residuals(replay, np.zeros(0), motion), 0.0, atol=1e-8 / NOISE)


@pytest.mark.parametrize("delay", [0.008, -0.006])
def test_a_late_reading_is_replayed_late(delay: float) -> None:
    model = pendulum()
    log, motion = own_log(model, late=delay)
    late = model.with_effect(placed(model, "sensor_time_offset", "hinge"))
    z = late.space.vector({"sensor_time_offset@hinge.offset": delay})
    windows = windows_of(model, [log])
    # of a log that starts at the delay, the windows do too; they are laid on the motion's steps
    replay = Replay(late, windows, 1)
    np.testing.assert_allclose(residuals(replay, z, motion), 0.0, atol=1e-8 / NOISE)
    assert np.abs(residuals(replay, late.space.nominal, motion)).max() > 1.0


def test_the_start_of_a_late_channel_is_its_state_when_it_happened() -> None:
    model = pendulum()
    motion = simulated(model.nominal(), None, 3.0, qpos=[0.8])
    late = model.with_effect(placed(model, "sensor_time_offset", "hinge"))
    z = late.space.vector({"sensor_time_offset@hinge.offset": 0.012})
    log = log_of("a", {"hinge.position": (motion["time"] + 0.012, motion["qpos"][:, 0])})
    replay = Replay(late, windows_of(model, [log]), 1)
    shift, plain = (np.abs(true_starts(replay, x, motion)).max(0) for x in (z, late.space.nominal))
    np.testing.assert_array_less(shift, [1e-4, 0.01])
    np.testing.assert_array_less([0.03, 0.1], plain)


def test_readings_later_than_the_margin_are_refused() -> None:
    model = pendulum()
    late = model.with_effect(placed(model, "sensor_time_offset", "hinge"))
    windows = windows_of(model, [swinging("a", model.nominal(), 0)], windows_settings(margin=0.01))
    with pytest.raises(DataError, match=r"windows\.margin to at least 0\.02"):
        Replay(late, windows)


def test_delays_longer_than_the_known_commands_are_refused() -> None:
    model = pendulum()
    late = model.with_effect(placed(model, "actuator_delay", "drive"))
    log = swinging("a", model.nominal(), 0)
    Replay(late, windows_of(model, [log]))
    with pytest.raises(DataError, match=r"windows\.kept keeps 0\.02 s"):
        Replay(late, windows_of(model, [log], windows_settings(past=0.02, kept=0.02)))


def test_a_delayed_command_is_replayed_late_from_the_first_sample_on() -> None:
    model = pendulum()
    command = steps_command("drive", 1.0, 3.0, seed=0, period=0.01)
    motion = simulated(model.nominal(), command, 3.0, qpos=[0.8])
    early = command.time - 0.014
    log = log_of("a", {"hinge.position": (motion["time"], motion["qpos"][:, 0])})
    log = type(log)("a", log.outputs, {"drive": type(command)("drive", "N·m", early, command.value)})
    late = model.with_effect(placed(model, "actuator_delay", "drive"))
    replay = Replay(late, windows_of(model, [log]), 1)
    z = late.space.vector({"actuator_delay@drive.delay": 0.014})
    # RK4 reads a delayed command in the middle of a step too, so that edges are blurred over one step
    assert np.abs(residuals(replay, z, motion)).max() * NOISE < 1e-4
    assert np.abs(residuals(replay, late.space.nominal, motion)).max() * NOISE > 1e-3


def test_an_offset_behind_a_low_pass_may_reach_beyond_the_margin() -> None:
    """Each alone fits into it; together they do at all but extreme values."""
    model = pendulum()
    for name in ("sensor_time_offset", "sensor_low_pass"):
        model = model.with_effect(placed(model, name, "hinge"))
    windows = windows_of(model, [swinging("a", pendulum().nominal(), 0)])
    replay = Replay(model, windows, 1)
    residuals, infeasible = replay.residuals(model.space.high[None], np.zeros((1, len(windows), replay.nstate)))
    assert np.isfinite(residuals).all()
    assert not infeasible.any()


@pytest.mark.parametrize("effects", [(), ("sensor_time_offset",), ("sensor_time_offset", "sensor_low_pass")])
@pytest.mark.parametrize("end", ["low", "high"])
def test_residuals_need_no_step_behind_what_is_read(effects: tuple[str, ...], end: str) -> None:
    model = pendulum()
    for name in effects:
        model = model.with_effect(placed(model, name, "hinge"))
    log, _ = own_log(pendulum())
    windows = windows_of(model, [log])
    replay, z, still = Replay(model, windows, 1), getattr(model.space, end)[None], np.zeros((1, len(windows), 2))
    found, _ = replay.residuals(z, still)
    whole, _ = replay.simulate(z, still)
    assert whole.qpos.shape[2] == windows.controls.shape[1] + 1
    for samples, columns in zip(windows.samples, replay.channels, strict=True):
        read = replay.reading(z, whole, samples.channel)(samples.time[None])[0]
        there = np.where(samples.scored[..., None], (samples.value - read) / samples.std, 0.0)
        np.testing.assert_array_equal(found[0][:, columns], there.reshape(len(windows), -1))


def test_steps_that_no_sample_shows_are_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[int] = []
    rollout = Batch.rollout

    def counted(self: Batch, nstep: int, controls: Array, *, record: tuple[str, ...]) -> dict[str, Array]:
        taken.append(nstep)
        return rollout(self, nstep, controls, record=record)

    monkeypatch.setattr(Batch, "rollout", counted)
    model = pendulum()
    late = model.with_effect(placed(model, "sensor_time_offset", "hinge"))
    log, _ = own_log(model)
    windows = windows_of(model, [log])
    for each in (model, late):
        Replay(each, windows, 1).residuals(each.space.nominal[None], np.zeros((1, len(windows), 2)))
    reading, every = round((windows.margin + windows.length) / STEP), windows.controls.shape[1]
    assert reading < taken[0] <= reading + 2
    assert every - 2 <= taken[1] <= every


@pytest.mark.parametrize("value", [np.inf, np.nan, 1e308])
def test_what_diverged_is_infeasible_and_leaves_nothing(value: float) -> None:
    """In one window of several the motion is beyond numbers; warnings are errors in these tests."""
    model = pendulum()
    log, motion = own_log(model)
    replay = Replay(model, windows_of(model, [log]), 1)
    z = model.space.nominal[None]
    tape, infeasible = replay.simulate(z, true_starts(replay, model.space.nominal, motion)[None])
    sound, _ = replay.compared(z, tape, infeasible)
    tape.qpos[:, 0, 5:] = value
    tape.qvel[:, 0, 5:] = -value
    found, lost = replay.compared(z, tape, infeasible)
    assert lost[0].tolist() == [True] + [False] * (lost.shape[1] - 1)
    assert not found[0, 0].any()
    np.testing.assert_array_equal(found[0, 1:], sound[0, 1:])

"""A machine that rolls begins a window on the ground, into which it sinks as its weight presses it."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import measured, model_of, solver_settings, windows_settings
from rover import OUTPUTS, drive, rover

from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.scales import machine_scales
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.free_start import free_bodies
from dr_lab.diagnosis.windows.grounded import grounded
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.diagnosis.windows.windows import Windows, cut
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise

SETTINGS = windows_settings()
MODEL = mujoco.MjModel.from_xml_string(rover())
STD = np.concatenate([np.full(3, 1e-3), np.full(3, 5e-3), np.full(2, 1e-3), np.full(3, 0.03), np.full(5, 0.15)])


def prior_of(qpos: Array, qvel: Array) -> StartPrior:
    return StartPrior(qpos.copy(), qvel.copy(), np.zeros_like(qvel), STD.copy())


def ground(prior: StartPrior, model: mujoco.MjModel = MODEL, settings: WindowSettings = SETTINGS) -> StartPrior:
    return grounded(prior, free_bodies(model, tuple(OUTPUTS)), model, settings)


def settled() -> mujoco.MjData:
    """The rover after two seconds at rest."""
    data = mujoco.MjData(MODEL)
    for _ in range(1000):
        mujoco.mj_step(MODEL, data)
    return data


def around(place: Array, count: int = 4) -> tuple[Array, Array]:
    """States that sensors tell of a place, off by 0.3 mm, 1 mrad and 1 cm/s."""
    rng = np.random.default_rng(3)
    qpos, change = np.tile(place, (count, 1)), rng.normal(size=(count, 8)) * np.repeat([3e-4, 1e-3, 0.0], [3, 3, 2])
    for row, by in zip(qpos, change, strict=True):
        mujoco.mj_integratePos(MODEL, row, by, 1.0)
    return qpos, 0.01 * rng.normal(size=(count, 8))


def test_a_start_sinks_to_where_the_machine_comes_to_rest() -> None:
    data = settled()
    found = ground(prior_of(*around(data.qpos)))
    assert found.grounded
    np.testing.assert_allclose(found.qpos[:, 2], data.qpos[2], atol=2e-7)
    np.testing.assert_allclose(found.qpos[:, 4:6], np.tile(data.qpos[4:6], (4, 1)), atol=2e-6)  # roll and pitch
    np.testing.assert_allclose(found.qvel[:, 2:5], 0.0, atol=5e-4)  # level but for 2 mrad


def test_what_is_along_the_ground_stays_as_it_was_measured() -> None:
    qpos, qvel = around(settled().qpos)
    found = ground(prior_of(qpos, qvel))
    np.testing.assert_allclose(found.qpos[:, [0, 1, 7, 8]], qpos[:, [0, 1, 7, 8]], atol=1e-6)
    np.testing.assert_allclose(found.qvel[:, [0, 1, 5, 6, 7]], qvel[:, [0, 1, 5, 6, 7]], atol=1e-4)


def test_no_unknown_lifts_a_wheel() -> None:
    found = ground(prior_of(*around(settled().qpos)))
    np.testing.assert_array_equal(found.std, 1.0)
    assert found.nstate == len(found.std) == 2 * (8 - 3)
    change = found.change(np.random.default_rng(1).normal(size=(4, 10)), np.zeros((4, 16)))
    assert (np.abs(change).max(0) > STD / 10)[[0, 1, 5, 6, 7, 8, 9, 13, 14, 15]].all()
    for q, by in zip(found.qpos, change, strict=True):
        before = heights(q)
        mujoco.mj_integratePos(MODEL, q, by[:8].copy(), 1.0)
        np.testing.assert_allclose(heights(q), before, atol=1e-6)
        mujoco.mj_integratePos(MODEL, q, by[8:].copy(), 1e-3)
        np.testing.assert_allclose(heights(q), before, atol=1e-6)


def heights(q: Array) -> Array:
    """Of the lowest points of wheels and casters above the floor."""
    data = mujoco.MjData(MODEL)
    data.qpos[:] = q
    mujoco.mj_kinematics(MODEL, data)
    return data.geom_xpos[1:, 2] - MODEL.geom_size[1:, 0]


@pytest.mark.parametrize("what", ["flies", "sinks", "tips over", "jumps", "weightless", "unmeasured", "lost"])
def test_what_does_not_stay_on_the_ground_begins_as_it_was_measured(what: str) -> None:
    qpos, qvel, model = *around(settled().qpos), MODEL
    if what == "flies":
        qpos[1, 2] += 2 * SETTINGS.footing
    if what == "sinks":  # the model is elsewhere than the machine
        qpos[:, 2] -= 0.02
    if what == "tips over":  # on one wheel in one window
        mujoco.mj_integratePos(MODEL, qpos[1], np.array([0, 0, 0.05, 0.4, 0, 0, 0, 0]), 1.0)
    if what == "jumps":
        qvel[1, 2] = 2 * SETTINGS.lifting * STD[10]
    if what == "weightless":
        model = mujoco.MjModel.from_xml_string(rover(gravity="0 0 0"))
    if what == "lost":
        qvel[1, 2] = np.nan
    prior = prior_of(qpos, qvel)
    bodies = free_bodies(model, () if what == "unmeasured" else tuple(OUTPUTS))
    assert grounded(prior, bodies, model, SETTINGS) is prior


def test_a_ball_that_flies_beside_a_rover_keeps_both_as_they_were_measured() -> None:
    ball = '<body name="ball" pos="1 1 1"><freejoint/><geom size="0.05"/></body></worldbody>'
    sensor = '<framepos name="ball" objtype="xbody" objname="ball"/></sensor>'
    model = mujoco.MjModel.from_xml_string(rover().replace("</worldbody>", ball).replace("</sensor>", sensor))
    prior = StartPrior(model.qpos0[None].copy(), np.zeros((1, 14)), np.zeros((1, 14)), np.ones(28))
    assert grounded(prior, free_bodies(model, (*OUTPUTS, "sensor.ball")), model, SETTINGS) is prior


def test_a_wall_does_not_hold_what_drives_towards_it() -> None:
    wall = f'<geom type="box" size="0.01 1 0.1" pos="{0.13 + 0.02 + 0.01 + 0.002} 0 0.1"/><body name="chassis"'
    model = mujoco.MjModel.from_xml_string(rover().replace('<body name="chassis"', wall))
    found = ground(prior_of(*around(settled().qpos)), model)
    assert found.grounded
    assert found.nstate == 10


def test_a_body_on_another_one_keeps_both_as_they_were_measured() -> None:
    cube = '<body name="{0}" pos="0 0 {1}"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>'
    sensor = '<framepos name="{0}" objtype="xbody" objname="{0}"/>'
    bodies, sensors = (
        "".join(text.format(name, z) for name, z in (("low", 0.05), ("high", 0.15))) for text in (cube, sensor)
    )
    plane = '<geom type="plane" size="5 5 0.1"/>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{plane}{bodies}</worldbody><sensor>{sensors}</sensor></mujoco>"
    )
    prior = StartPrior(model.qpos0[None].copy(), np.zeros((1, 12)), np.zeros((1, 12)), np.full(24, 0.01))
    assert grounded(prior, free_bodies(model, ("sensor.low", "sensor.high")), model, SETTINGS) is prior


@pytest.mark.parametrize("height", [-0.0298, -0.0295, -0.029, -0.027])
def test_a_caster_may_be_near_the_ground(height: float) -> None:
    """Bottom 0.2 to 3 mm above it; at the first it just carries, over which a solver without bounds fails."""
    xml = rover().replace('pos="0.13 0 -0.0295"', f'pos="0.13 0 {height}"')
    model = mujoco.MjModel.from_xml_string(xml)
    for seed in (2, 4):
        log = drive(xml, 4.0, seed).log("log", seed)
        prior = cut([log], recorded(log), model, SETTINGS).prior
        assert prior.grounded
        assert prior.nstate == 10


def test_a_harder_push_is_told_from_noise_by_the_setting() -> None:
    qpos, qvel = around(settled().qpos)
    qvel[1, 2] = 2 * SETTINGS.lifting * STD[10]
    assert ground(prior_of(qpos, qvel), settings=replace(SETTINGS, lifting=10.0)).grounded


def recorded(*logs: Log) -> MeasurementSet:
    return replace(measured(logs), noise={name: Noise(std, "", "given") for name, std in OUTPUTS.items()})


def windows() -> Windows:
    logs = [drive(rover(), 4.0, seed).log(f"log_{seed}", seed) for seed in (1, 2)]
    return cut(logs, recorded(*logs), MODEL, SETTINGS)


def test_the_machines_own_logs_are_explained_down_to_their_noise() -> None:
    model = model_of(rover())
    replay, found = fit_states(model, model.space.nominal, windows(), solver_settings(), 1)
    assert replay.windows.prior.grounded
    assert replay.touching
    used = replay.fitted
    assert 0.8 < (found.residuals[used] ** 2).mean() < 1.15


def test_a_wheel_is_as_strong_as_its_motor() -> None:
    """Its own inertia asks for a fifth of what the motor does: the rest moves the chassis, through the contact."""
    driven = drive(rover(), 4.0, 1)
    log = driven.log("log", 1)
    found, coasting = (machine_scales(MODEL, [each], 0.03) for each in (log, replace(log, commands={})))
    applied = np.sqrt((driven.controls**2).mean(0))
    assert found.torque["left"] == pytest.approx(applied[0], rel=0.1)
    assert found.torque["right"] == pytest.approx(applied[1], rel=0.1)
    assert coasting.torque["left"] < 0.5 * applied[0]


def test_a_replay_of_some_windows_is_grounded_too() -> None:
    model = model_of(rover())
    replay = Replay(model, windows(), 1)
    assert replay.part(np.array([0, 2])).windows.prior.grounded

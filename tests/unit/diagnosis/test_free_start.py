"""A cube that tumbles as it falls, seen by the sensors of its frame: where it begins a window, and how it turns."""

import mujoco
import numpy as np
from diagnosis_machines import log_of, measured, model_of, windows_settings
from scipy.spatial.transform import Rotation

from dr_lab.diagnosis.windows.free_start import free_bodies
from dr_lab.diagnosis.windows.orientations import continuous, turning
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.trajectory import Array, Log, Noise

XML = """<mujoco model="cube"><option timestep="0.001" integrator="RK4"/><worldbody><body name="cube">
  <freejoint/><geom type="box" size="0.05 0.05 0.05" mass="0.37"/></body></worldbody>
  <sensor><framepos name="place" objtype="xbody" objname="cube"/>
    <framequat name="turn" objtype="xbody" objname="cube"/></sensor></mujoco>"""
CHANNELS = ("sensor.place", "sensor.turn")
SPIN, SPEED = np.array([4.0, -7.0, 2.0]), np.array([0.5, -0.2, 1.0])


def fallen(seconds: float = 0.6, rate: float = 150.0) -> tuple[Log, Array, Array, Array]:
    """Log, times, qpos and qvel of the motion: a cube turns at a constant rate, q(t) = q₀ exp(ω t/2)."""
    time = np.arange(0.0, seconds, 1 / rate)
    start = Rotation.from_rotvec([0.3, 0.4, -0.2])
    turn = (start * Rotation.from_rotvec(time[:, None] * SPIN)).as_quat(scalar_first=True)
    turn[::7] *= -1.0  # the same orientations
    place = SPEED * time[:, None] + np.array([0.0, 0.0, 1.0]) - 0.5 * np.array([0.0, 0.0, 9.81]) * time[:, None] ** 2
    log = log_of("toss", {"sensor.place": (time, place), "sensor.turn": (time, turn)})
    velocity = SPEED - np.array([0.0, 0.0, 9.81]) * time[:, None]
    return log, time, np.hstack([place, turn]), np.hstack([velocity, np.tile(SPIN, (len(time), 1))])


def test_a_window_begins_where_the_sensors_saw_the_body() -> None:
    model, (log, time, qpos, qvel) = model_of(XML), fallen()
    noise = {"sensor.place": Noise(1e-3, "m", "given"), "sensor.turn": Noise(5e-3, "", "given")}
    data = measured([log])
    data.noise.update(noise)  # pyright: ignore[reportAttributeAccessIssue]
    windows = cut([log], data, model.nominal(), windows_settings(length=0.15, prior_scale=1.0))
    prior = windows.prior
    assert len(windows) >= 2
    for k, begin in enumerate(windows.begin):
        row = np.abs(time - begin).argmin()
        offset = begin - time[row]
        np.testing.assert_allclose(prior.qpos[k, :3], qpos[row, :3] + offset * qvel[row, :3], atol=1e-4)
        apart = Rotation.from_quat(prior.qpos[k, 3:], scalar_first=True).inv() * Rotation.from_quat(
            qpos[row, 3:], scalar_first=True
        )
        np.testing.assert_allclose((apart * Rotation.from_rotvec(offset * SPIN)).magnitude(), 0.0, atol=1e-3)
        np.testing.assert_allclose(prior.qvel[k], qvel[row] + offset * np.array([0, 0, -9.81, 0, 0, 0]), atol=2e-2)
    np.testing.assert_allclose(prior.std[:3], 1e-3, rtol=0.2)
    np.testing.assert_allclose(prior.std[3:6], 1e-2, rtol=0.2)  # a turn by φ moves a quaternion by φ/2


def test_turning_is_that_of_mujoco() -> None:
    rate = 1e-6
    start = np.array([0.5, -0.5, 0.1, 0.7])
    start = start / np.linalg.norm(start)
    moved = start.copy()
    mujoco.mju_quatIntegrate(moved, SPIN, rate)
    unit, spin, _ = turning(start[None] * 1.02, (moved - start)[None] * 1.02 / rate, np.zeros((1, 4)))
    np.testing.assert_allclose(unit[0], start, atol=1e-12)
    np.testing.assert_allclose(spin[0], SPIN, rtol=1e-4)


def test_signs_of_quaternions_are_made_to_follow_one_another() -> None:
    one = np.array([1.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(continuous(np.array([one, -one, one, -one])), np.tile(one, (4, 1)))


def test_only_frames_in_the_world_place_a_body() -> None:
    compiled = model_of(XML).nominal()
    (body,) = free_bodies(compiled, CHANNELS)
    assert (body.address, body.dof) == (0, 0)
    assert free_bodies(compiled, CHANNELS[:1])[0].orientation is None
    (blind,) = free_bodies(compiled, ())
    assert (blind.position, blind.orientation) == (None, None)
    relative = XML.replace('objname="cube"/></sensor>', 'objname="cube" reftype="xbody" refname="cube"/></sensor>')
    (seen,) = free_bodies(model_of(relative).nominal(), CHANNELS)
    assert (seen.position is None, seen.orientation) == (False, None)


MOUNT, TURN = np.array([0.1, -0.05, 0.2]), Rotation.from_rotvec([0.3, 1.0, -0.5])  # of an IMU's board in the cube
WELDED = XML.replace(
    "</body></worldbody>",
    '<body name="board" pos="0.1 -0.05 0.2" quat="{}"><site name="imu"/></body></body></worldbody>',
).format(" ".join(map(str, TURN.as_quat(scalar_first=True))))


def test_a_site_on_what_is_welded_to_a_body_places_it_as_its_own_frame_does() -> None:
    log, time, qpos, _ = fallen()
    frames = Rotation.from_quat(qpos[:, 3:], scalar_first=True)
    of_site = {
        "sensor.place": (time, qpos[:, :3] + frames.apply(MOUNT)),
        "sensor.turn": (time, (frames * TURN).as_quat(scalar_first=True)),
    }
    site = WELDED.replace('objtype="xbody" objname="cube"', 'objtype="site" objname="imu"')
    noise = {"sensor.place": Noise(1e-3, "m", "given"), "sensor.turn": Noise(5e-3, "", "given")}
    priors = []
    for xml, one in ((WELDED, log), (site, log_of("toss", of_site))):
        data = measured([one])
        data.noise.update(noise)  # pyright: ignore[reportAttributeAccessIssue]
        priors.append(cut([one], data, model_of(xml).nominal(), windows_settings(length=0.15)).prior)
    own, mounted = priors
    np.testing.assert_allclose(mounted.qpos[:, :3], own.qpos[:, :3], atol=1e-4)
    np.testing.assert_allclose(mounted.qpos[:, 3:], own.qpos[:, 3:], atol=1e-9)
    np.testing.assert_allclose(mounted.qvel, own.qvel, atol=5e-2)
    np.testing.assert_allclose(mounted.qacc[:, 3:], own.qacc[:, 3:], atol=1e-6)


def test_a_place_away_from_the_frame_without_an_orientation_places_nothing() -> None:
    site = WELDED.replace('objtype="xbody" objname="cube"', 'objtype="site" objname="imu"')
    (body,) = free_bodies(model_of(site).nominal(), CHANNELS[:1])
    assert body.position is None

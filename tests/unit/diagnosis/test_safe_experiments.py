"""Where experiments start and what they keep: families of commands, limits, distances, poses."""

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import experiment_settings
from effect_machines import block, hanging, placed

from dr_lab.diagnosis.experiment import play
from dr_lab.diagnosis.next_experiment.clearance import Clearance
from dr_lab.diagnosis.next_experiment.family import Bounds
from dr_lab.diagnosis.next_experiment.held_commands import held_standing
from dr_lab.diagnosis.next_experiment.limits import Limits, Shown
from dr_lab.diagnosis.next_experiment.ranges import command_ranges, controlled, slews
from dr_lab.diagnosis.next_experiment.standing import first_pose, standing
from dr_lab.errors import ConfigError
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Log, Signal

SETTINGS = experiment_settings()
FAMILY = replace(SETTINGS.family, sines=4, lowest=0.2, highest=5.0)
SAFETY = replace(SETTINGS.safety, reserve=0.1, draws=0, spread=1.0)
WEIGHT = 0.5 * 9.81 * 0.3  # N·m of the hanging rod, horizontal


def shown(*distance: float) -> Shown:
    """Logs in which a joint went from −1 to 1 at up to 2 a second, its actuator with a force of up to 3."""
    low, high, speed, force = (np.array([value]) for value in (-1.0, 1.0, 2.0, 3.0))
    return Shown(low, high, speed, force, np.array(distance))


@pytest.mark.parametrize("seed", range(5))
def test_commands_begin_and_end_softly_within_their_range(seed: int) -> None:
    bounds = Bounds(np.array([0.5, -1.0]), np.array([-2.0, -1.0]), np.array([1.0, 4.0]), np.array([3.0, np.inf]))
    time = np.arange(601) / 100
    genes = FAMILY.draw(20, 2, np.random.default_rng(seed))
    values = FAMILY.commands(genes, time, bounds)
    assert values.shape == (20, 2, 601)
    assert (values >= bounds.low[:, None]).all()
    assert (values <= bounds.high[:, None]).all()
    np.testing.assert_allclose(values[:, :, [0, -1]], np.broadcast_to(bounds.hold[:, None], (20, 2, 2)), atol=1e-12)
    assert np.abs(np.diff(values[:, 0], axis=1)).max() <= 0.03 * (1 + 1e-9)  # 3 a second at 100 Hz
    assert np.ptp(values, axis=2).min() > 0


def test_a_resized_experiment_is_as_much_smaller() -> None:
    bounds = Bounds(np.zeros(1), np.full(1, -2.0), np.full(1, 2.0), np.full(1, np.inf))
    genes = FAMILY.draw(3, 1, np.random.default_rng(0))
    genes[..., -1] = 1.0
    time = np.arange(301) / 100
    whole, half = (FAMILY.commands(g, time, bounds) for g in (genes, FAMILY.resized(genes, np.full(3, 0.5))))
    np.testing.assert_allclose(half, whole / 2, atol=1e-12)


def test_a_family_needs_a_band() -> None:
    with pytest.raises(ConfigError, match="lowest below highest"):
        replace(FAMILY, lowest=5.0)


def test_limits_are_the_models_where_it_declares_them() -> None:
    free = Limits.of(block().nominal(), shown(), SAFETY)
    assert (free.low[0], free.high[0]) == pytest.approx((-1.4, 1.4))  # 0.2 of the range to either side
    assert free.speed[0] == pytest.approx(2.4)
    np.testing.assert_allclose(free.force[:, 0], [-3.6, 3.6])
    drive = '<motor name="drive" joint="rail" forcerange="-5 4"/>'
    ended = Limits.of(block(drive, 'range="-0.3 0.7"').nominal(), shown(), SAFETY)
    assert (ended.low[0], ended.high[0]) == pytest.approx((-0.3, 0.7))
    np.testing.assert_allclose(ended.force[:, 0], [-5, 4])


def test_a_motion_at_its_limit_takes_all_of_it() -> None:
    kept = Limits.of(block().nominal(), shown(), SAFETY).within(SAFETY, np.zeros(1), shown())
    assert kept.high[0] == pytest.approx(1.4 - 0.28)
    qpos, qvel = np.zeros((1, 3, 1)), np.zeros((1, 3, 1))
    qpos[0, 1], qvel[0, 2] = kept.low[0] / 2, kept.speed[0]
    taken = kept.excess(qpos, qvel, np.full((1, 3, 1), 1.8), np.zeros(1))
    assert taken["position"][0, 0] == pytest.approx(0.5)
    assert taken["speed"][0, 0] == pytest.approx(1.0)
    assert taken["force"][0, 0] == pytest.approx(0.5)  # of a motor that is known from its command, no reserve


def test_where_it_starts_is_always_allowed() -> None:
    kept = Limits.of(block().nominal(), shown(), SAFETY).within(SAFETY, np.array([1.4]), shown())
    still = np.full((1, 2, 1), 1.4)
    assert kept.excess(still, 0 * still, 0 * still, np.array([1.4]))["position"][0, 0] <= 1


@pytest.mark.parametrize("start", [1.4, 1.401])
def test_a_machine_that_leans_on_a_stop_may_press_on_it(start: float) -> None:
    """It gives by a thousandth of the range of 2.8; what goes farther is too far, by as much as it is farther."""
    kept = Limits.of(block().nominal(), shown(), SAFETY).within(SAFETY, np.array([start]), shown())
    pressed = start + np.array([1e-12, 2.8e-3, 5.6e-3])
    qpos = np.stack([np.full(3, start), pressed], axis=1)[..., None]
    taken = kept.excess(qpos, 0 * qpos, 0 * qpos, np.array([start]))["position"][:, 0]
    np.testing.assert_allclose(taken, [0.0, 1.0, 2.0], atol=1e-6)
    back = kept.excess(np.full((1, 2, 1), start - 2.0), 0 * qpos[:1], 0 * qpos[:1], np.array([start]))
    assert back["position"][0, 0] < 1


BALLS = """<mujoco><worldbody>
  <geom name="wall" type="box" size="0.1 1 1" pos="1 0 0"/>
  <body name="cart"><joint name="x" type="slide" axis="1 0 0"/><geom name="cart" size="0.2"/>
    <body name="arm" pos="0 0 1"><joint name="z" type="slide" axis="0 0 1"/><geom name="hand" size="0.1"/>
      <body name="tip" pos="0 0 1"><joint name="y" type="slide" axis="0 1 0"/><geom name="tip" size="0.05"/>
      </body></body></body>
</worldbody></mujoco>"""


def balls() -> Model:
    return from_spec("balls", mujoco.MjSpec.from_string(BALLS), {})


def test_distances_are_those_of_what_may_meet() -> None:
    clearance = Clearance(balls(), np.zeros(0), reach=5.0)
    assert set(clearance.pairs) == {("wall", "cart"), ("wall", "hand"), ("wall", "tip"), ("cart", "tip")}
    found = dict(
        zip(clearance.pairs, clearance.distances(np.array([[0.3, 0.0, 0.0], [0.0, -2.5, 0.0]])).T, strict=True)
    )
    np.testing.assert_allclose(found["wall", "cart"], [0.9 - 0.3 - 0.2, 0.7], atol=1e-6)
    np.testing.assert_allclose(found["cart", "tip"], [2 - 0.25, 0.5 - 0.25], atol=1e-6)


def test_more_configurations_than_are_looked_at_at_once() -> None:
    clearance = Clearance(balls(), np.zeros(0), reach=5.0)
    x = np.linspace(-1.0, 0.5, 700)
    found = clearance.distances(np.stack([x, 0 * x, 0 * x], axis=1))[:, clearance.pairs.index(("wall", "cart"))]
    np.testing.assert_allclose(found, 0.7 - x, atol=1e-6)


def test_pairs_that_no_motion_brings_closer_are_told() -> None:
    """The cart alone moves: what it carries stays as far from it, and what is beyond reach is not known to."""
    clearance = Clearance(balls(), np.zeros(0), reach=5.0)
    low, high = np.array([-0.5, 0.0, 0.0]), np.array([0.5, 0.0, 0.0])
    steady = clearance.steady(low, high, np.random.default_rng(0))
    assert {pair for pair, same in zip(clearance.pairs, steady, strict=True) if same} == {("cart", "tip")}
    near = Clearance(balls(), np.zeros(0), reach=0.1)
    assert not near.steady(low, high, np.random.default_rng(0)).any()
    all_move = np.full(3, 0.5)
    assert not clearance.steady(-all_move, all_move, np.random.default_rng(0)).any()


def test_parts_may_come_no_closer_than_in_the_logs_nor_than_the_clearance() -> None:
    """What touched in the logs may touch; what came to 5 mm may not come closer; all else keeps 10 mm."""
    seen = shown(-0.001, 0.005, 0.04)
    limits = Limits.of(block().nominal(), seen, SAFETY)
    np.testing.assert_allclose(limits.distance, [-np.inf, 0.0045, 0.01])
    kept = limits.within(SAFETY, np.zeros(1), seen)
    np.testing.assert_allclose(kept.distance, [-np.inf, 0.00495, 0.02])
    start = np.array([0.04, 0.00695, 0.04])
    at, closer = (kept.too_close(np.array(at), start) for at in ([-1.0, 0.00495, 0.02], [-1.0, 0.004, 0.015]))
    np.testing.assert_allclose(at, [0.0, 1.0, 1.0])
    assert (closer > 1).tolist() == [False, True, True]
    np.testing.assert_allclose(kept.too_close(start, start), 0.0)
    inside = np.array([0.04, 0.004, 0.04])
    assert (kept.too_close(inside, inside) > 1).tolist() == [False, True, False]


def test_a_motor_holds_what_gravity_pulls() -> None:
    found = standing(hanging().nominal(), np.array([0.7]), {"drive": (-5.0, 5.0)}, SETTINGS.stillness)
    assert abs(found.hold["drive"]) == pytest.approx(WEIGHT * np.sin(0.7), rel=1e-6)
    assert found.qpos[0] == pytest.approx(0.7)
    assert found.rests


def test_a_position_controller_is_sent_as_far_as_gravity_pulls_it_back() -> None:
    spec = hanging().spec.copy()
    drive = spec.actuators[0]
    drive.gainprm[0], drive.biastype, drive.biasprm[1] = 50.0, mujoco.mjtBias.mjBIAS_AFFINE, -50.0
    found = standing(spec.compile(), np.array([0.7]), {"drive": (-2.0, 2.0)}, SETTINGS.stillness)
    assert abs(found.hold["drive"] - 0.7) == pytest.approx(WEIGHT * np.sin(0.7) / 50, rel=1e-6)


FILTERED = [
    ("dead_zone", {"width": 0.3}, lambda control: control + 0.3),
    ("voltage_sag", {"slope": 0.09}, lambda control: (1 - np.sqrt(1 - 4 * 0.09 * control)) / (2 * 0.09)),
    ("command_power", {"exponent": 2.0, "full": 5.0}, lambda control: np.sqrt(5.0 * control)),
    ("torque_scale", {"factor": 0.7}, lambda control: control / 0.7),  # no filter
]


@pytest.mark.parametrize(("name", "values", "command"), FILTERED)
def test_what_holds_a_machine_is_sent_through_the_filters_of_its_model(
    name: str, values: dict[str, float], command: Callable[[float], float]
) -> None:
    model = hanging().with_effect(placed(hanging(), name, "drive"))
    z = model.space.vector({f"{name}@drive.{key}": value for key, value in values.items()})
    found = held_standing(model, z, np.array([0.7]), {"drive": (-5.0, 5.0)}, SETTINGS.stillness)
    assert abs(found.hold["drive"]) == pytest.approx(command(WEIGHT * np.sin(0.7)), rel=1e-6)
    assert found.rests
    hold = Signal("drive", "", np.array([0.0, 1.0]), np.full(2, found.hold["drive"]))
    assert np.ptp(play(model, z[None], found.qpos, [{"drive": hold}], 1.0).tape.qpos) < 1e-4


def test_a_machine_that_needs_nothing_is_sent_nothing_through_a_dead_zone() -> None:
    model = hanging().with_effect(placed(hanging(), "dead_zone", "drive"))
    z = model.space.vector({"dead_zone@drive.width": 0.3})
    assert held_standing(model, z, np.zeros(1), {"drive": (-5.0, 5.0)}, SETTINGS.stillness).hold["drive"] == 0.0


def test_a_weight_that_the_filtered_command_cannot_hold_is_not_held() -> None:
    model = hanging().with_effect(placed(hanging(), "dead_zone", "drive"))
    z = model.space.vector({"dead_zone@drive.width": 0.3})
    limit = WEIGHT * np.sin(0.7) + 0.1  # enough without the dead zone
    found = held_standing(model, z, np.array([0.7]), {"drive": (-limit, limit)}, SETTINGS.stillness)
    assert abs(found.hold["drive"]) == pytest.approx(limit)
    assert found.qpos[0] < 0.6


def test_what_no_actuator_holds_comes_to_rest_below() -> None:
    found = standing(hanging().nominal(), np.array([0.7]), {"drive": (-1e-9, 1e-9)}, SETTINGS.stillness)
    assert found.qpos[0] == pytest.approx(0.0, abs=0.02)
    assert found.rests


def test_what_falls_for_ever_does_not_rest() -> None:
    spec = block().spec.copy()
    spec.option.gravity = [1.0, 0.0, 0.0]  # along the rail
    assert not standing(spec.compile(), np.zeros(1), {"drive": (-0.1, 0.1)}, SETTINGS.stillness).rests


def test_it_starts_where_logs_do() -> None:
    time = np.arange(3.0)
    logs = [
        Log(str(q), {"hinge.position": Signal("hinge.position", "rad", time, q + time)}, {}) for q in (0.1, 0.3, 0.9)
    ]
    assert first_pose(hanging().nominal(), logs)[0] == pytest.approx(0.3)
    assert first_pose(hanging().nominal(), [])[0] == 0.0


SERVO = '<position name="drive" joint="rail" kp="40" kv="2" gear="2"/>'


def test_a_position_controller_stays_in_its_joints_range_and_speed() -> None:
    model = block(SERVO, 'range="-0.3 0.7"').nominal()
    limits = Limits.of(model, shown(), SAFETY)
    assert controlled(model, 0) == 0
    assert command_ranges(model, limits, {"drive": (-3.0, 1.0)}, SAFETY)["drive"] == pytest.approx((-0.6, 1.4))
    assert slews(model, limits, ["drive"])[0] == pytest.approx(2 * 2.4)


def test_a_motor_goes_as_far_as_its_ctrlrange_or_the_logs() -> None:
    limits = Limits.of(block().nominal(), shown(), SAFETY)
    free = block().nominal()
    assert command_ranges(free, limits, {"drive": (-3.0, 1.0)}, SAFETY)["drive"] == pytest.approx((-3.6, 3.6))
    ranged = block('<motor name="drive" joint="rail" ctrlrange="-1 9" ctrllimited="true"/>').nominal()
    assert command_ranges(ranged, limits, {"drive": (-3.0, 1.0)}, SAFETY)["drive"] == pytest.approx((-1.0, 9.0))
    assert np.isinf(slews(free, limits, ["drive"])[0])
    assert controlled(free, 0) is None
    assert command_ranges(free, limits, {"drive": (0.0, 0.0)}, SAFETY) == {}


def test_safety_must_be_a_share() -> None:
    with pytest.raises(ConfigError, match="reserve"):
        replace(SAFETY, reserve=1.0)

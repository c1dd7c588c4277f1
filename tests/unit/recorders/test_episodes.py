"""Episodes in recordings: the files hold what was played, and the eye stays with a machine that travels."""

import dataclasses
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np
import pytest
import rerun.blueprint as rrb
from hydra.utils import instantiate
from mcap.reader import make_reader
from omegaconf import OmegaConf
from recorder_samples import read_recording

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import read_log
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.episodes import anything_drawn, episodes_page, episodes_table
from dr_lab.recorders.episodes_mcap import write_episodes
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import Curve
from dr_lab.recorders.training_review import TrainingRecord, write_training_review

XML = """<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/><body name="cart" pos="0 0 1">
  <joint name="rail" type="slide" axis="1 0 0"/><geom name="block" type="box" size=".5 .5 .5"/>
  <body name="ball" pos="0 0 1"><joint name="socket" type="ball"/><geom name="sphere" size=".2"/></body>
</body></worldbody><actuator><motor name="drive" joint="rail"/></actuator></mujoco>"""
STEPS, DT = 200, 0.02


def episode(speed: float, name: str = "episode_1", mass: float = 2.0) -> Episode:
    """A cart at constant speed."""
    model = mujoco.MjModel.from_xml_string(XML)
    time = np.arange(STEPS + 1, dtype=np.float64) * DT
    qpos = np.zeros((STEPS + 1, 5))
    qpos[:, 0], qpos[:, 1] = speed * time, 1.0
    qvel = np.zeros((STEPS + 1, 4))
    qvel[:, 0] = speed
    steps = np.arange(STEPS, dtype=float)
    context = {"cart.mass": (mass, "kg"), "friction": (0.5, "1")}
    seen = np.stack([time, -time], 1)
    return Episode(name, context, model, time, qpos, qvel, seen, np.sin(steps)[:, None], 0.1 * steps, "truncated")


def entry(topic: str, field: str | list[str], unit: str) -> dict[str, object]:
    return {"topic": f"/episode_1/{topic}", "field": field, "unit": unit}


@pytest.fixture(scope="module")
def contract() -> DataContract:
    path = Path(__file__).parents[3] / "conf" / "data_contract" / "default.yaml"
    return instantiate(OmegaConf.load(path))


def test_an_episode_survives_the_round_trip_through_mcap(tmp_path: Path, contract: DataContract) -> None:
    played = episode(speed=3.0)
    write_episodes(
        tmp_path / "episodes.mcap", [played, episode(1.0, "episode_2")], {"model.xml": b"<x/>"}, {"env": "e"}
    )
    outputs = {
        "rail.position": entry("joint_states", "position[rail]", "m"),
        "rail.velocity": entry("joint_states", "velocity[rail]", "m/s"),
        "sensor.socket": entry("socket/position", [f"data[{k}]" for k in range(4)], "1"),
        "sensor.reward": entry("reward", "data[0]", "1"),
    }
    commands = {"drive": entry("action", "data[0]", "1")}
    log = read_log(tmp_path / "episodes.mcap", outputs, commands, contract)
    for name, value in {"rail.position": played.qpos[:, 0], "rail.velocity": played.qvel[:, 0]}.items():
        np.testing.assert_allclose(log.outputs[name].time, played.time, atol=1e-9)
        np.testing.assert_array_equal(log.outputs[name].value, value)
    np.testing.assert_array_equal(log.outputs["sensor.socket"].value, played.qpos[:, 1:])
    np.testing.assert_allclose(log.outputs["sensor.reward"].time, played.time[1:], atol=1e-9)
    np.testing.assert_array_equal(log.outputs["sensor.reward"].value, played.reward)
    np.testing.assert_allclose(log.commands["drive"].time, played.time[:-1], atol=1e-9)
    np.testing.assert_array_equal(log.commands["drive"].value, played.action[:, 0])


def test_the_file_says_in_which_context_each_episode_was(tmp_path: Path) -> None:
    heavy = episode(1.0, "episode_2", mass=7.25)
    write_episodes(tmp_path / "episodes.mcap", [episode(3.0), heavy], {}, {"env": "e"})
    with (tmp_path / "episodes.mcap").open("rb") as file:
        reader = make_reader(file)
        (told,) = (record.metadata for record in reader.iter_metadata())
        topics = {channel.topic for _, channel, _ in reader.iter_messages()}
    assert told["episode_2.cart.mass"] == "7.25 kg"
    assert told["episode_1.cart.mass"] == "2 kg"
    assert float(told["episode_2.return"]) == heavy.undiscounted == pytest.approx(0.1 * STEPS * (STEPS - 1) / 2)
    assert told["episode_2.ended"] == "truncated"
    assert "/episode_2/context" in topics


def test_joints_without_a_name_have_topics_of_their_own(tmp_path: Path) -> None:
    free = '<body pos="{} 0 2"><freejoint/><geom size="0.1"/></body>'
    hinge = '<body><joint/><geom size="0.1"/></body>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{free.format(0)}{hinge}{free.format(1)}</worldbody></mujoco>"
    )
    qpos, qvel, seen = (np.zeros((4, n)) for n in (model.nq, model.nv, 2))
    time, action, reward = np.linspace(0.0, 0.3, 4), np.zeros((3, 0)), np.zeros(3)
    played = Episode("episode_1", {}, model, time, qpos, qvel, seen, action, reward, "truncated")
    write_episodes(tmp_path / "episodes.mcap", [played], {}, {})
    with (tmp_path / "episodes.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    topics = [channel.topic for channel in summary.channels.values()] if summary else []
    assert len(set(topics)) == len(topics) == 8
    assert {"/episode_1/joint_0/position", "/episode_1/joint_2/velocity"} < set(topics)


def test_the_eye_goes_along_with_a_machine_that_travels(
    tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    path = tmp_path / "review.rrd"
    both = [episode(3.0), episode(0.1, "episode_2")]
    write_training_review(path, TrainingRecord("run", episodes=both), look)
    found = read_recording(path)
    followed = found["/episode/episode_1/world/followed"]
    np.testing.assert_allclose(followed["t"], np.arange(STEPS + 1) * DT)
    np.testing.assert_allclose(np.squeeze(followed["Transform3D:translation"])[:, 0], 3.0 * both[0].time, rtol=1e-6)
    assert "/episode/episode_2/world/followed" not in found
    cart = found["/episode/episode_1/world/machine/cart"]
    np.testing.assert_allclose(cart["Transform3D:translation"][-1][0], [3.0 * both[0].time[-1], 0.0, 1.0], rtol=1e-6)
    assert len(found["/episode/episode_1/reward"]["Scalars:scalars"]) == STEPS


@pytest.mark.parametrize("over", ["iteration", "frames"])
def test_only_the_beginning_of_long_episodes_is_drawn_and_what_training_counts_shows_the_start(
    over: Literal["iteration", "frames"], tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    path = tmp_path / "review.rrd"
    curve = Curve("return", "", np.arange(2), np.zeros(2), over)
    record = TrainingRecord("run", [curve], episodes=[episode(3.0)])
    write_training_review(path, record, dataclasses.replace(look, longest=1.0))
    found = read_recording(path)
    cart = found["/episode/episode_1/world/machine/cart"]
    assert max(cart["t"]) == pytest.approx(1.0)
    assert cart[over] == [0]
    assert found["/curve/return"][over] == [0, 1]


def test_a_machine_without_visible_shapes_has_its_rewards_and_actions(
    tmp_path: Path, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")
    hidden = XML.replace('type="box"', 'type="box" group="3"').replace('name="sphere"', 'name="sphere" group="3"')
    unseen = dataclasses.replace(episode(3.0), geometry=mujoco.MjModel.from_xml_string(hidden))
    write_training_review(tmp_path / "review.rrd", TrainingRecord("run", episodes=[unseen]), look)
    found = read_recording(tmp_path / "review.rrd")
    assert len(found["/episode/episode_1/reward"]["Scalars:scalars"]) == STEPS
    assert not any(path.startswith("/episode/episode_1/world/machine") for path in found)


def test_many_episodes_stand_in_tabs_of_a_few(look: Look) -> None:
    page = episodes_page([episode(0.1, f"episode_{k + 1}") for k in range(10)], look)
    tabs = next(iter(page.contents))
    assert isinstance(tabs, rrb.Tabs)
    assert [part.name for part in tabs.contents] == [
        "episode 1 … episode 4",
        "episode 5 … episode 8",
        "episode 9 … episode 10",
    ]
    assert isinstance(next(iter(episodes_page([episode(0.1)], look).contents)), rrb.Horizontal)


def test_beside_a_timeline_that_counts_there_are_machines_alone(look: Look) -> None:
    def views(part: rrb.Container | rrb.View) -> list[type]:
        inner = part.contents if isinstance(part, rrb.Container) else None
        return [type(part)] if inner is None else [kind for each in inner for kind in views(each)]

    episodes = [episode(0.1), dataclasses.replace(episode(0.1, "episode_2"), ended="infeasible")]
    assert views(episodes_page(episodes, look, "iteration")) == [rrb.Spatial3DView, rrb.TextDocumentView]
    assert views(episodes_page(episodes, look)).count(rrb.TimeSeriesView) == 2
    assert views(episodes_page(episodes[1:], look)) == [rrb.TextDocumentView]
    assert not anything_drawn(episodes[1:])


def test_the_table_tells_return_end_and_context() -> None:
    lines = episodes_table([episode(3.0)]).splitlines()
    assert lines[0] == "| episode | return | time [s] | ended | cart.mass [kg] | friction |"
    assert lines[2] == "| 1 | 1990 | 4 | truncated | 2 | 0.5 |"
    assert episodes_table([]) == ""


def test_an_episode_of_another_shape_is_told() -> None:
    with pytest.raises(DataError, match=r"action has shape \(200, 2\), expected \(200, 1\)"):
        Episode(**{**vars(episode(1.0)), "action": np.zeros((STEPS, 2))})

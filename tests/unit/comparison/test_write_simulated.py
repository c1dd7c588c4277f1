"""`simulated.mcap`, read by a library that dr_lab did not write."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from dr_lab.comparison.write_simulated import write_simulated
from dr_lab.measurements.mcap import McapSource
from dr_lab.measurements.signal_map import channel_map
from dr_lab.recorders.overlay import BEFORE, Overlay
from dr_lab.trajectory import Signal


def shown(log: str, begin: float, command_begin: float) -> Overlay:
    time = np.linspace(begin, begin + 0.99, 100)
    joint = Signal("hinge.position", "rad", time, np.sin(time))
    command = Signal("drive", "N·m", np.linspace(command_begin, command_begin + 1.19, 120), np.zeros(120))
    still = np.zeros((1, 1, 3)), np.zeros((1, 1, 4))
    simulated = {BEFORE: {joint.name: joint.value}}
    measured, sent = {joint.name: joint}, {command.name: command}
    return Overlay(log, time[:1], {BEFORE: still}, measured, simulated, {}, sent, {joint.name: 0.1})


def test_logs_whose_commands_begin_before_0_or_overlap_are_shifted(tmp_path: Path) -> None:
    path = tmp_path / "simulated.mcap"
    write_simulated(path, [shown("a", 0.0, -0.3), shown("b", 0.0, -0.2)], {}, {})
    with path.open("rb") as file:
        reader = make_reader(file)
        (metadata,) = [record.metadata for record in reader.iter_metadata()]
        times = {"/real/joint_states": [], "/command": []}
        for _, channel, message in reader.iter_messages(topics=list(times)):
            times[channel.topic].append(message.log_time * 1e-9)
    # Log a lies from 0.3 to 1.29 s, its commands from 0 to 1.19 s; b's first command follows a second later.
    assert metadata == {"a.shift": "0.300000000 s", "b.shift": "2.490000000 s"}
    assert times["/command"][0] == 0.0
    np.testing.assert_allclose([times["/real/joint_states"][k] for k in (0, 100)], [0.3, 2.49])
    np.testing.assert_allclose(np.diff(times["/command"])[119], 1.1)


def test_a_joint_that_pauses_is_not_interpolated_over(tmp_path: Path) -> None:
    path = tmp_path / "simulated.mcap"
    overlay = shown("a", 0.0, 0.0)
    time = np.delete(np.linspace(0.1, 0.8, 141), np.arange(40, 81))  # no samples between 0.295 and 0.505 s
    other = Signal("other.position", "rad", time, 2.0 * time)
    measured, gaps = {**overlay.measured, other.name: other}, {"hinge.position": 0.05, other.name: 0.025}
    simulated = {BEFORE: {**overlay.simulated[BEFORE], other.name: other.value}}
    write_simulated(path, [replace(overlay, measured=measured, simulated=simulated, gaps=gaps)], {}, {})
    source = McapSource(path)
    for prefix in ("/real", "/sim", "/residual"):
        entry = {"topic": f"{prefix}/joint_states", "field": "position[other]", "unit": "rad"}
        samples = source.samples(channel_map("other.position", entry, ""))
        at = samples.stamps["log"].elapsed
        kept = np.concatenate([np.arange(0.1, 0.295, 0.01), np.arange(0.51, 0.805, 0.01)])
        np.testing.assert_allclose(at, kept, atol=1e-6)
        np.testing.assert_allclose(samples.value, 0.0 if prefix == "/residual" else 2.0 * kept, atol=1e-6)


def test_a_topic_of_several_logs_is_read_without_a_note(tmp_path: Path) -> None:
    path = tmp_path / "simulated.mcap"
    write_simulated(path, [shown("a", 0.0, 0.0), shown("b", 0.0, 0.0)], {}, {})
    source = McapSource(path)
    entry = {"topic": "/sim/joint_states", "field": "position[hinge]", "unit": "rad"}
    assert len(source.samples(channel_map("hinge.position", entry, "")).value) == 200
    assert source.notes == ()

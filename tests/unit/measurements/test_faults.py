"""Faults that data alone show: frozen sensors, copied logs, machines at rest under commands."""

from dataclasses import replace

import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.faults.find import mark_faults
from dr_lab.measurements.faults.frozen import find_frozen
from dr_lab.trajectory import Array, Log, Note, Signal

QUANTUM, LENGTH = 2 * np.pi / 2048, 5.0


@pytest.fixture(scope="module")
def contract() -> DataContract:
    return instantiate(compose("close", ["effect=spring"]).measurements.contract)


def waves(seed: int, time: Array, joint: int = 0) -> Array:
    rng = np.random.default_rng([seed, joint])
    rates, phases = rng.uniform(0.4, 3.0, 5), rng.uniform(0, 2 * np.pi, 5)
    return 0.3 * np.sin(2 * np.pi * rates * time[:, None] + phases).sum(1)


def swinging(seed: int, rests_from: float = np.inf, held: float = 1.0) -> Log:
    """Two joints with encoders at 500 Hz and a command at 250 Hz, which is `held` times as strong while they rest."""
    time, sent = np.arange(0.0, LENGTH, 0.002), np.arange(0.0, LENGTH, 0.004)
    # Brakes within 50 ms.
    moved = np.minimum(time, rests_from) + 0.05 * (1 - np.exp(-np.maximum(time - rests_from, 0.0) / 0.05))
    outputs = {}
    for joint in (0, 1):
        name = f"joint_{joint}.position"
        outputs[name] = Signal(name, "rad", time, QUANTUM * np.round(waves(seed, moved, joint) / QUANTUM))
    drive = waves(seed, sent, 2) * np.where(sent < rests_from, 1.0, held)
    return Log(f"log_{seed}", outputs, {"motor": Signal("motor", "N·m", sent, drive)})


def frozen(log: Log, name: str, begin: float, end: float) -> Log:
    signal = log.outputs[name]
    inside = (signal.time >= begin) & (signal.time < end)
    value = np.where(inside, signal.value[inside.argmax()], signal.value)
    return replace(log, outputs={**log.outputs, name: replace(signal, value=value)})


def faults(log: Log) -> list[Note]:
    return [note for note in log.notes if note.kind == "fault"]


def test_sound_logs_are_left_alone(contract: DataContract) -> None:
    logs = [swinging(seed) for seed in range(4)]
    fit, held_out = mark_faults(logs[:2], logs[2:], contract, {})
    assert [*fit, *held_out] == logs


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_frozen_encoder_is_told_and_its_span_left_out(contract: DataContract, noise: float) -> None:
    log = swinging(0)
    if noise:
        rng = np.random.default_rng(0)
        outputs = {n: replace(s, value=s.value + noise * rng.standard_normal(len(s))) for n, s in log.outputs.items()}
        log = replace(log, outputs=outputs)
    ((one, marked), _) = mark_faults([swinging(1), frozen(log, "joint_1.position", 2.0, 3.2)], [], contract, {})
    (note,) = faults(marked)
    assert note.signal == "joint_1.position"
    assert "from 2.00 to 3.20 s" in note.message
    assert faults(one) == []
    time = marked.outputs["joint_1.position"].time
    assert not ((time > 2.01) & (time < 3.19)).any()
    assert len(marked.outputs["joint_0.position"]) == len(log.outputs["joint_0.position"])


def test_a_sensor_slower_than_its_topic_is_not_frozen(contract: DataContract) -> None:
    log = swinging(0)
    slow = {
        name: replace(signal, value=np.repeat(signal.value[::60], 60)[: len(signal)])
        for name, signal in log.outputs.items()
    }
    ((marked,), _) = mark_faults([replace(log, outputs=slow)], [], contract, {})
    assert faults(marked) == []


def test_a_motor_that_starts_from_rest_is_no_frozen_sensor(contract: DataContract) -> None:
    """It turns evenly most of the time, so that the braking it shows would not stop it within a sample."""
    time = np.arange(0.0, 6.0, 0.01)
    gone = np.maximum(time - 1.0, 0.0)
    value = 20.0 * (gone - 0.02 * (1 - np.exp(-gone / 0.02)))
    assert not find_frozen(Signal("shaft.position", "rad", time, value), contract)
    amid = np.where(time < 1.0, 20.0 * (time - 1.0), value)  # turning at once, and at once again behind the span
    held = np.where((time > 0.4) & (time < 1.0), amid[time <= 0.4][-1], amid)
    assert find_frozen(Signal("shaft.position", "rad", time, held), contract)


def test_friction_that_holds_a_joint_is_no_frozen_sensor(contract: DataContract) -> None:
    """A joint that comes to rest by braking and later sets off from rest."""
    log = swinging(0, rests_from=2.0, held=0.2)
    ((marked,), _) = mark_faults([log], [], contract, {})
    assert faults(marked) == []


def test_a_machine_at_rest_under_full_commands_is_off(contract: DataContract) -> None:
    _, (marked,) = mark_faults([swinging(1)], [swinging(0, rests_from=3.0)], contract, {})
    (note,) = faults(marked)
    assert note.message.startswith("Off: from 3.")
    assert "motor" in note.message


@pytest.mark.parametrize("seed", [2, 4, 5])
def test_a_sensor_that_is_silent_is_no_machine_at_rest(contract: DataContract, seed: int) -> None:
    log = swinging(seed)
    outputs = {}
    for name, signal in log.outputs.items():
        heard = (signal.time < 2.0) | (signal.time >= 3.5)
        outputs[name] = replace(signal, time=signal.time[heard], value=signal.value[heard])
    ((marked,), _) = mark_faults([replace(log, outputs=outputs)], [], contract, {})
    assert faults(marked) == []


def test_an_encoder_that_freezes_amid_an_even_motion_is_told(contract: DataContract) -> None:
    """No braking is seen anywhere: every step of the speed is exactly 0."""
    time = np.arange(2048) / 256
    value = np.where((time >= 2.0) & (time < 3.2), 2.0, time)
    even = Signal("wheel.position", "rad", time, value)
    ((marked,), _) = mark_faults([Log("log", {"wheel.position": even}, {})], [], contract, {})
    (note,) = faults(marked)
    assert "from 2.00 to 3.20 s" in note.message


@pytest.mark.parametrize("part", [slice(None), slice(700, 1900)])
def test_a_held_out_copy_of_a_fitted_log_is_refused(contract: DataContract, part: slice) -> None:
    original = swinging(0)
    moved = {
        name: Signal(name, signal.unit, signal.time[part] + 40.0, signal.value.astype(np.float32)[part].astype(float))
        for name, signal in original.outputs.items()
    }
    copy = Log(
        "other_name", moved, {"motor": replace(original.commands["motor"], time=original.commands["motor"].time + 40)}
    )
    with pytest.raises(DataError, match=r"'log_0' and 'other_name' hold the same data"):
        mark_faults([original, swinging(1)], [swinging(2), copy], contract, {})


def test_the_end_of_a_log_that_wraps_is_a_copy_though_its_turns_are_counted_anew(contract: DataContract) -> None:
    time = np.arange(0.0, LENGTH, 0.002)
    angle = 3.0 * time + np.sin(5.0 * time)
    whole = Log("whole", {"q.position": Signal("q.position", "rad", time, angle)}, {})
    end = Log("end", {"q.position": Signal("q.position", "rad", time[1000:], angle[1000:] - 2 * np.pi)}, {})
    with pytest.raises(DataError, match="'whole' and 'end' hold the same data"):
        mark_faults([whole], [end], contract, {"q.position": 2 * np.pi})
    assert mark_faults([whole], [end], contract, {}) == ((whole,), (end,))


def test_a_copy_within_the_fitted_logs_is_told(contract: DataContract) -> None:
    ((first, second), _) = mark_faults([swinging(0), replace(swinging(0), name="again")], [], contract, {})
    assert faults(first) == []
    (note,) = faults(second)
    assert "log_0" in note.message
    assert note.count == 2500


def test_slow_motion_that_shares_a_moment_with_another_is_no_copy(contract: DataContract) -> None:
    """Coarse encoders give few different values in 32 samples; a tenth of a second of both is the same."""
    time = np.arange(0.0, LENGTH, 0.002)
    moment = (time >= 1.0) & (time < 1.1)
    logs = []
    for number, slow in enumerate((0.3 * np.sin(0.5 * time), 0.2 * np.cos(0.7 * time))):
        value = np.where(moment, np.sin(60.0 * time), 0.05 * np.round(slow / 0.05))
        logs.append(Log(f"log_{number}", {"joint.position": Signal("joint.position", "rad", time, value)}, {}))
    fit, held_out = mark_faults(logs[:1], logs[1:], contract, {})
    assert [*fit, *held_out] == logs


def test_a_standstill_may_lie_within_a_copy(contract: DataContract) -> None:
    copy = replace(swinging(0, rests_from=3.0), name="again")
    (_, second), _ = mark_faults([swinging(0, rests_from=3.0), copy], [], contract, {})
    assert [note.count for note in faults(second) if note.message.startswith("Copied")] == [2500]


@pytest.mark.parametrize(("alike", "told"), [(0.6, False), (2.0, True)])
def test_two_falls_from_the_same_rest_are_no_copies(contract: DataContract, alike: float, told: bool) -> None:
    one, other = swinging(0), swinging(1)
    outputs = {
        name: replace(signal, value=np.where(signal.time < alike, one.outputs[name].value, signal.value))
        for name, signal in other.outputs.items()
    }
    fit, _ = mark_faults([one, replace(other, outputs=outputs)], [], contract, {})
    assert bool(faults(fit[1])) == told

"""Faults injected into the logs of a small machine are found with log and time; what machines really do is no fault."""

import re
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.faults.fault_words import parts_outside
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise, Signal
from tests.diagnosis_machines import suspected

STEP, LENGTH, PEAK = 0.002, 5.0, 1.5
XML = """
<mujoco>
  <option timestep="0.002" integrator="RK4"/>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" damping="0.02" {shoulder}/>
      <inertial pos="0 0 -0.15" mass="{mass}" diaginertia="0.004 0.004 0.0004"/>
      <body name="lower" pos="0 0 -0.3">
        <joint name="elbow" axis="0 1 0" damping="0.01"/>
        <inertial pos="0 0 -0.1" mass="0.3" diaginertia="0.001 0.001 0.0001"/>
      </body>
    </body>
  </worldbody>
  <actuator>{actuator}</actuator>
</mujoco>
"""
MOTOR = '<motor name="motor" joint="shoulder"/>'
SERVO = '<position name="motor" joint="shoulder" kp="12" kv="0.3"/>'
Act = Callable[[Array, Array], Array]


@cache
def settings() -> FaultSettings:
    return instantiate(compose("close", ["effect=spring"]).faults, _convert_="all")


def nominal(actuator: str = MOTOR) -> Model:
    """The model as documented: the machine's upper link is 12 % lighter."""
    return from_spec("arm", mujoco.MjSpec.from_string(XML.format(mass=0.44, shoulder="", actuator=actuator)), {})


def command(seed: int, time: Array) -> Array:
    rng = np.random.default_rng(seed)
    rates, phases = rng.uniform(0.4, 3.0, 5), rng.uniform(0, 2 * np.pi, 5)
    waves = np.sin(2 * np.pi * rates * time[:, None] + phases).sum(1)
    return PEAK * waves / np.abs(waves).max()


def driven(act: Act, shoulder: str, actuator: str, seed: int) -> Log:
    """A log whose commands act as `act` says of times and commands; encoders of 4096 steps."""
    model = mujoco.MjModel.from_xml_string(XML.format(mass=0.5, shoulder=shoulder, actuator=actuator))
    data, time = mujoco.MjData(model), np.arange(0.0, LENGTH, STEP)
    sent = command(seed, np.floor(time / 0.004) * 0.004)
    acting, path = act(time, sent), np.empty((len(time), 2))
    for k in range(len(time)):
        path[k], data.ctrl[:] = data.qpos, acting[k]
        mujoco.mj_step(model, data)
    quantum = 2 * np.pi / 4096
    outputs = {
        f"{joint}.position": Signal(f"{joint}.position", "rad", time, quantum * np.round(path[:, i] / quantum))
        for i, joint in enumerate(("shoulder", "elbow"))
    }
    return Log(f"log_{seed}", outputs, {"motor": Signal("motor", "N·m", time[::2], sent[::2])})


def recorded(act: Act = lambda time, sent: sent, shoulder: str = "", actuator: str = MOTOR) -> MeasurementSet:
    logs = [driven(act, shoulder, actuator, seed) for seed in (1, 2, 3)]
    noise = {name: Noise(4.4e-4, "rad", "estimated") for name in logs[0].outputs}
    return MeasurementSet("arm", tuple(logs[:2]), tuple(logs[2:]), noise, dict.fromkeys((*noise, "motor"), 0.02))


def told(measured: MeasurementSet, change: Callable[[Signal], Signal], log: str = "") -> tuple[Fault, ...]:
    """Faults of a set whose commands are changed, in one log or in all."""

    def changed(each: Log) -> Log:
        return replace(each, commands={"motor": change(each.commands["motor"])}) if log in ("", each.name) else each

    parts = {part: tuple(map(changed, getattr(measured, part))) for part in ("fit", "held_out")}
    return suspected(nominal(), replace(measured, **parts), settings())


@pytest.fixture(scope="module")
def sound() -> MeasurementSet:
    return recorded()


def test_sound_logs_raise_nothing(sound: MeasurementSet) -> None:
    assert suspected(nominal(), sound, settings()) == ()


@pytest.mark.parametrize(
    ("act", "shoulder"),
    [
        (lambda time, sent: np.interp(time - 0.04, time, sent), ""),
        (lambda time, sent: np.clip(sent, -0.6, 0.6), ""),
        (lambda time, sent: np.sign(sent) * np.maximum(np.abs(sent) - 0.2, 0.0), ""),
        (lambda time, sent: sent, 'frictionloss="0.25"'),
        (lambda time, sent: 0.6 * sent, 'frictionloss="0.1" stiffness="0.3"'),
    ],
    ids=["delay", "saturation", "dead zone", "friction", "weak, spring"],
)
def test_what_machines_do_is_no_fault(act: Act, shoulder: str) -> None:
    assert suspected(nominal(), recorded(act, shoulder), settings()) == ()


def test_a_turned_sign_is_told_in_its_log(sound: MeasurementSet) -> None:
    (fault,) = told(sound, lambda s: replace(s, value=-s.value), "log_2")
    assert (fault.kind, fault.log, fault.signal) == ("sign", "log_2", "motor")
    assert fault.begin < 0.3
    assert fault.end > LENGTH - 0.3
    assert "sign: -1 in measurements.commands.motor; where it stands there already, delete it." in fault.remedy
    everywhere = told(sound, lambda s: replace(s, value=-s.value))
    assert [(f.kind, f.log) for f in everywhere] == [("sign", f"log_{k}") for k in (1, 2, 3)]


def test_a_sign_of_one_log_is_not_told_where_the_others_know_none(sound: MeasurementSet) -> None:
    """Commands that are not those of the motion, which by chance it follows with the other sign in one log."""
    first, second, third = (log.commands["motor"] for log in (*sound.fit, *sound.held_out))
    turned = replace(first, value=-first.value)
    foreign = {"log_1": turned, "log_2": third, "log_3": second}
    faults = told(sound, lambda sent: next(new for log, new in foreign.items() if sent is of(sound, log)))
    assert "sign" not in {fault.kind for fault in faults}
    assert "sign" in {fault.kind for fault in told(sound, lambda sent: turned, "log_1")}


def of(measured: MeasurementSet, name: str) -> Signal:
    return next(log.commands["motor"] for log in (*measured.fit, *measured.held_out) if log.name == name)


def test_a_servos_turned_sign_is_told() -> None:
    measured = recorded(actuator=SERVO)
    assert suspected(nominal(SERVO), measured, settings()) == ()
    turned = recorded(lambda time, sent: -sent, actuator=SERVO)
    assert {f.kind for f in suspected(nominal(SERVO), turned, settings())} == {"sign"}


@pytest.mark.parametrize(("factor", "word"), [(1e3, "mN·m"), (1e-3, "kilo"), (180 / np.pi, "deg")])
def test_a_factor_between_units_is_told(sound: MeasurementSet, factor: float, word: str) -> None:
    faults = told(sound, lambda s: replace(s, value=factor * s.value))
    assert [(f.kind, f.log) for f in faults] == [("unit", f"log_{k}") for k in (1, 2, 3)]
    assert word in faults[0].message


@pytest.mark.parametrize(("factor", "turned"), [(1e3, False), (-1e3, True)])
def test_a_factor_with_a_turned_sign_asks_for_both(sound: MeasurementSet, factor: float, *, turned: bool) -> None:
    fault = told(sound, lambda s: replace(s, value=factor * s.value))[0]
    assert "or its scale" in fault.remedy
    assert ("where it stands there already, delete it" in fault.remedy) == turned


@pytest.mark.parametrize("shift", [0.5, -0.3])
def test_commands_out_of_step_are_told_with_the_shift(sound: MeasurementSet, shift: float) -> None:
    (fault,) = told(sound, lambda s: replace(s, time=s.time + shift), "log_3")
    assert (fault.kind, fault.log) == ("shift", "log_3")
    assert f"latency: {shift:.2f}" in fault.remedy


def test_commands_that_repeat_tell_no_shift(monkeypatch: pytest.MonkeyPatch) -> None:
    """A shift by 0.15 s, or by 0.5 s less, or more: one sine looks the same."""
    monkeypatch.setattr(sys.modules[__name__], "command", lambda seed, time: PEAK * np.sin(4 * np.pi * time + seed))
    faults = told(recorded(), lambda s: replace(s, time=s.time + 0.15), "log_3")
    assert "shift" not in {fault.kind for fault in faults}


@pytest.mark.parametrize(("begin", "end"), [(3.0, np.inf), (0.0, 0.55), (1.2, 1.9)])
def test_a_machine_that_is_switched_off_is_told_with_the_time(begin: float, end: float) -> None:
    measured = recorded(lambda time, sent: np.where((time < begin) | (time >= end), sent, 0.0))
    faults = suspected(nominal(), measured, settings())
    assert [(f.kind, f.log) for f in faults] == [("off", f"log_{k}") for k in (1, 2, 3)]
    for fault in faults:
        assert fault.begin == pytest.approx(begin, abs=0.25)
        assert fault.end == pytest.approx(min(end, LENGTH), abs=0.25)
        kept = [stretch.split(":") for stretch in re.findall(r"\[(.*?)\]", fault.remedy)]
        assert len(kept) == (begin > 1.0) + (end < LENGTH)
        for start, stop in kept:
            assert float(stop or LENGTH) < begin or float(start or 0.0) > end


def thinned(measured: MeasurementSet, period: float) -> MeasurementSet:
    """The same set with the commands' samples a period apart, each as it was then."""

    def thin(log: Log) -> Log:
        sent = log.commands["motor"]
        keep = np.arange(0, len(sent), round(period / 0.004))
        return replace(log, commands={"motor": replace(sent, time=sent.time[keep], value=sent.value[keep])})

    return replace(measured, fit=tuple(map(thin, measured.fit)), held_out=tuple(map(thin, measured.held_out)))


def test_commands_that_changed_more_often_than_logged_are_told(sound: MeasurementSet) -> None:
    faults = suspected(nominal(), thinned(sound, 0.02), settings())
    assert [(f.kind, f.log) for f in faults] == [("decimated", f"log_{k}") for k in (1, 2, 3)]
    assert "every 20 ms" in faults[0].message


def test_commands_that_are_truly_held_are_not_called_decimated() -> None:
    measured = recorded(lambda time, sent: sent[np.searchsorted(time, np.floor(time / 0.02 + 1e-6) * 0.02 - 1e-6)])
    assert suspected(nominal(), thinned(measured, 0.02), settings()) == ()


def test_commands_without_any_effect_are_told() -> None:
    measured = recorded(lambda time, sent: 0.3 * np.sin(4 * time))
    assert {f.kind for f in suspected(nominal(), measured, settings())} <= {"off", "shift"}


def test_a_log_of_zeros_is_one_of_a_machine_that_is_off(sound: MeasurementSet) -> None:
    """The pendulum hangs down, where it needs no torque at all, whatever its commands say."""
    outputs = {name: replace(signal, value=0 * signal.value) for name, signal in sound.fit[0].outputs.items()}
    still = replace(sound.fit[0], outputs=outputs)
    (fault,) = suspected(nominal(), replace(sound, fit=(still, sound.fit[1])), settings())
    assert (fault.kind, fault.log) == ("off", "log_1")
    assert "in the whole log" in fault.message


def test_machines_that_cannot_be_tested_are_left_in_peace(sound: MeasurementSet) -> None:
    unmeasured = {"shoulder.position"}
    fit = tuple(
        replace(log, outputs={name: log.outputs[name] for name in unmeasured}) for log in (*sound.fit, *sound.held_out)
    )
    assert suspected(nominal(), replace(sound, fit=fit, held_out=()), settings()) == ()


@pytest.mark.parametrize(
    ("log", "begin", "end", "named"),
    [
        ("log_1", None, 0.63, "log_1[0.7:]"),
        ("log_1[0:4.9]", None, 0.63, "log_1[0.7:4.9]"),
        ("log_1[0.5:]", 2.09, 3.0, "log_1[0.5:2] and log_1[3:]"),
        ("log_1", 2.09, None, "log_1[:2]"),
        ("log_1", None, None, ""),
    ],
)
def test_stretches_outside_of_a_span_are_named(log: str, begin: float | None, end: float | None, named: str) -> None:
    assert parts_outside(log, begin, end) == named

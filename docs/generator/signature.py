"""What an effect does to a small machine: the residual of a model that lacks it, and the force that is then missing."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect, PlacedEffect, Scales, place
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

HERE = Path(__file__).parent
SHARE = 0.3  # of the way from absent to an upper bound, where an effect has no start of its own


@dataclass(frozen=True)
class Bench:
    """A machine and how it is moved.

    Attributes:
        name: of its file.
        joint: of which a channel is shown.
        unit: of the channel.
        seconds: how long.
        before: s of commands before that, for effects that remember.
        scales: magnitudes that give an effect's bounds their size.
        command: command at times, of every actuator.
        command_unit: its unit.
        channel: ``position`` or ``velocity``.
    """

    name: str
    joint: str
    unit: str
    seconds: float
    before: float
    scales: Scales
    command: Callable[[Array], Array]
    command_unit: str
    channel: str = "position"

    def model(self) -> Model:
        """The machine without any effect."""
        return from_spec(self.name, mujoco.MjSpec.from_file(str(HERE / f"{self.name}.xml")), {})


def _scales(joints: tuple[str, ...], actuator: str, half_range: float, speed: float, force: float) -> Scales:
    low, high = (dict.fromkeys(joints, sign * half_range) for sign in (-1.0, 1.0))
    return Scales(low, high, dict.fromkeys(joints, speed), dict.fromkeys(joints, force), {actuator: force})


MOTOR_ARM = Bench(
    "motor_arm",
    "joint",
    "rad",
    3.0,
    0.1,
    _scales(("joint",), "motor", 0.7, 3.0, 0.6),
    lambda t: 0.5 * np.sin(4.0 * t) + 0.5 * np.sin(9.0 * t),
    "N·m",
)
SERVO_ARM = replace(MOTOR_ARM, name="servo_arm", command_unit="rad", scales=_scales(("joint",), "servo", 0.7, 3.0, 0.6))
BLOCK = Bench(
    "block",
    "across",
    "m",
    1.5,
    0.1,
    _scales(("across", "up"), "push", 0.1, 1.0, 8.0),
    lambda t: 8.0 * np.sin(12.0 * t),
    "N",
)
TWO_LINKS = replace(
    MOTOR_ARM,
    name="two_links",
    joint="elbow",
    scales=_scales(("shoulder", "elbow"), "motor", 0.7, 3.0, 0.6),
)
WRIST = replace(MOTOR_ARM, name="wrist", scales=_scales(("turn", "joint", "roll", "bend"), "motor", 0.7, 3.0, 0.6))
FLYER = replace(BLOCK, name="flyer", joint="flight", command=lambda t: 8.0 * np.cos(12.0 * t))
DRIVEN_LINKS = replace(TWO_LINKS, name="driven_links")
STICKY_ARM = replace(MOTOR_ARM, name="sticky_arm")
BENCHES = (MOTOR_ARM, SERVO_ARM, BLOCK, TWO_LINKS, WRIST, FLYER, DRIVEN_LINKS, STICKY_ARM)
SHOWN_AT = {"contact_stiffness": "up"}  # another joint than the bench's
SHOWN_IN = {"velocity_low_pass": "velocity"}  # another channel than the position


@dataclass(frozen=True)
class Signature:
    """An effect at work.

    Attributes:
        bench: the machine.
        placed: the effect at its site.
        values: short name → value of its parameters here.
        time: s, shape (n,).
        residual: measured less simulated channel, shape (n,).
        series: what the missing force may be drawn against, each of shape (n,).
        force: generalised force that the model without the effect lacks, shape (n,); None where contacts or another
            joint hide it.
    """

    bench: Bench
    placed: PlacedEffect
    values: Mapping[str, float]
    time: Array
    residual: Array
    series: Mapping[str, Array]
    force: Array | None


def put(effect: Effect) -> tuple[Bench, PlacedEffect]:
    """The machine on which an effect is shown, and the effect at its first site there.

    Args:
        effect: of the catalogue.

    Raises:
        LookupError: it can sit on none of them.
    """
    for bench in BENCHES:
        compiled = bench.model().nominal()
        for site in effect.sites(compiled)[:1]:
            shown = replace(bench, joint=SHOWN_AT.get(effect.name, bench.joint))
            if SHOWN_IN.get(effect.name) == "velocity":
                shown = replace(shown, channel="velocity", unit=f"{bench.unit}/s")
            return shown, place(effect, compiled, site, bench.scales)
    raise LookupError(f"Effect {effect.name!r} can sit on none of the machines of the plots: give it one here.")


def values_of(placed: PlacedEffect) -> dict[str, float]:
    """Full name → value at which an effect is shown: its last start away from absent, or a share of the bounds."""
    start = placed.starts[-1] if placed.starts else {}
    moved = {p.name: p.nominal + SHARE * (p.high - p.nominal) for p in placed.parameters}
    held = {p.name: p.nominal for p in placed.parameters}
    return {**(held if placed.starts else moved), **start}


def signature(effect: Effect) -> Signature:
    """Simulate the machine with and without an effect, from the same start under the same commands.

    Args:
        effect: of the catalogue.

    Raises:
        LookupError: there is no machine for it.
    """
    bench, placed = put(effect)
    plain, values = bench.model(), values_of(placed)
    extended = plain.with_effect(placed)
    z = extended.space.vector(values)[None]
    time = np.arange(round(bench.seconds / plain.spec.option.timestep) + 1) * plain.spec.option.timestep
    measured = _reported(extended, z, bench, time, "position")
    residual = _reported(extended, z, bench, time, bench.channel)
    residual -= _reported(plain, np.empty((1, 0)), bench, time, bench.channel)
    speed = np.gradient(measured, time)
    series = {
        "position": measured,
        "velocity": speed,
        "acceleration": np.gradient(speed, time),
        "command": bench.command(time),
    }
    compiled = plain.nominal()
    force = _missing(compiled, series) if not compiled.ngeom and compiled.nv == 1 else None
    short = placed.local(values)
    named = {name: float(value) for name, value in short.items()}
    return Signature(bench, placed, named, time, residual, series, force)


def _reported(model: Model, z: Array, bench: Bench, time: Array, channel: str) -> Array:
    """Position or velocity that the machine reports, shape (n,)."""
    compiled = model.nominal()
    step = compiled.opt.timestep
    now, past = (
        np.tile(bench.command(t)[None, :, None], compiled.nu)
        for t in (time[:-1], np.arange(-round(bench.before / step), 0) * step)
    )
    start = compiled.qpos0[None, None], np.zeros((1, 1, compiled.nv))
    rollout = Simulator(model, 1, threads=1).replay(z, *start, now, past)
    joint = compiled.joint(bench.joint)
    paths = {"position": rollout.qpos[0, :, joint.qposadr[0]], "velocity": rollout.qvel[0, :, joint.dofadr[0]]}
    path = paths[channel]
    reading = model.reading(
        z, f"{bench.joint}.{channel}", lambda t: np.interp(t, time, path)[..., None], np.zeros((1, 1))
    )
    return np.array(reading(time[None, None])).reshape(-1)[: len(time)]


def _missing(model: mujoco.MjModel, series: Mapping[str, Array]) -> Array:
    """M(q) q̈ + c(q, q̇) − Jᵀu along the measured motion: 0 where the model is right."""
    data, found = mujoco.MjData(model), []
    for q, v, a, u in zip(*(series[name] for name in ("position", "velocity", "acceleration", "command")), strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:], data.ctrl[:] = q, v, a, u
        mujoco.mj_inverse(model, data)
        needed = data.qfrc_inverse[0]
        mujoco.mj_fwdActuation(model, data)
        found.append(needed - data.qfrc_actuator[0])
    return np.array(found)

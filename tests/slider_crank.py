"""A slider-crank: MJCF whose loop a connect constraint closes, and the same machine by its own equation of motion."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dr_lab.trajectory import Array, Log, Signal

CRANK, ROD = 0.1, 0.3  # m
SAMPLE = 0.004  # s
CRANK_INERTIA, ROD_MASS, SLIDER_MASS = 0.004, 0.2, 1.05  # kg·m², kg, kg; the model's slider has 1 kg
MJCF = """<mujoco model="slider_crank">
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody>
    <body name="crank">
      <joint name="crank" axis="0 0 1" damping="0.01"/>
      <inertial mass="0.3" pos="0 0 0" diaginertia="0.004 0.004 0.004"/>
      <body name="rod" pos="0.1 0 0">
        <joint name="pin" axis="0 0 1"/>
        <inertial mass="0.2" pos="0.15 0 0" diaginertia="1e-5 0.0015 0.0015"/>
      </body>
    </body>
    <body name="slider" pos="0.4 0 0">
      <joint name="slider" type="slide" axis="1 0 0"/>
      <inertial mass="1" pos="0 0 0" diaginertia="0.001 0.001 0.001"/>
    </body>
  </worldbody>
  <equality><connect name="wrist" body1="rod" body2="slider" anchor="0.3 0 0" {}/></equality>
  <actuator><motor name="motor" joint="crank"/></actuator>
</mujoco>"""


def rod_angle(angle: Array) -> Array:
    """Angle of the rod in the world, rad."""
    return -np.arcsin(CRANK / ROD * np.sin(angle))


def place(angle: Array) -> Array:
    """Position of the slider, m, 0 where the crank points at it."""
    return CRANK * np.cos(angle) + ROD * np.cos(rod_angle(angle)) - (CRANK + ROD)


def slopes(angle: Array) -> tuple[Array, Array]:
    """Slopes of the slider's position and of the rod's angle by the crank's angle."""
    rod = -CRANK / ROD * np.cos(angle) / np.cos(rod_angle(angle))
    return -CRANK * np.sin(angle) - ROD * np.sin(rod_angle(angle)) * rod, rod


def driven(torque: Array, start: Array, step: float, friction: float, damping: float) -> Array:
    """Angles of n cranks under torques held for each step, (n, s) → (n, s), by RK4; they begin at rest.

    J(q) q'' + ½ J'(q) q'² = τ − d q' − F |dx/dq| sign q', and at rest q'' = 0 while |τ| ≤ F |dx/dq|. A step within
    which a crank comes to rest is parted there.
    """
    state, found = np.stack([start, np.zeros_like(start)]), np.empty(torque.shape)
    for k, held in enumerate(torque.T):
        found[:, k] = state[0]
        end = _after(state, held, step, friction, damping)
        rests = end[1] * state[1] < 0
        if rests.any():
            slowing = np.where(rests, (state[1] - end[1]) / step, np.inf)
            until = np.full(len(start), step)
            for _ in range(3):  # by the chord
                until += end[1] / slowing
                end = _after(state, held, until, friction, damping)
            end[1, rests] = 0.0
            end = _after(end, held, step - until, friction, damping)
        state = end
    return found


def _after(state: Array, torque: Array, step: Array | float, friction: float, damping: float) -> Array:
    """Angles and speeds, (2, n), after a step in which no crank changes its direction."""
    angle, speed = state
    moves = (speed != 0) | (np.abs(torque) > friction * np.abs(slopes(angle)[0]))
    way = np.where(moves, np.sign(np.where(speed != 0, speed, torque)), 0.0)
    forces = moves * torque, friction * way, damping
    one = _rate(state, *forces)
    two = _rate(state + step / 2 * one, *forces)
    three = _rate(state + step / 2 * two, *forces)
    four = _rate(state + step * three, *forces)
    return state + step / 6 * (one + 2 * two + 2 * three + four)


def _rate(state: Array, torque: Array, friction: Array, damping: float) -> Array:
    angle, speed = state
    bend = (_inertia(angle + 1e-5) - _inertia(angle - 1e-5)) / 2e-5
    rubbing = friction * np.abs(slopes(angle)[0])
    return np.stack([speed, (torque - 0.5 * bend * speed**2 - damping * speed - rubbing) / _inertia(angle)])


def _inertia(angle: Array) -> Array:
    """What the crank feels of all parts, kg·m²."""
    slider, rod = slopes(angle)
    along = -CRANK * np.sin(angle) - 0.5 * ROD * np.sin(rod_angle(angle)) * rod
    across = CRANK * np.cos(angle) + 0.5 * ROD * np.cos(rod_angle(angle)) * rod
    own = ROD_MASS * ROD**2 / 12
    return CRANK_INERTIA + SLIDER_MASS * slider**2 + ROD_MASS * (along**2 + across**2) + own * rod**2


def logs(
    names: str, seconds: float = 8.0, friction: float = 0.0, noise: tuple[float, float] = (1e-3, 1e-4)
) -> list[Log]:
    """Logs of crank and slider under sums of sines, every 4 ms, one for each letter; noise in rad and m."""
    held, count = 4, len(names)  # steps for a sample
    step = SAMPLE / held
    rng = np.random.default_rng(list(names.encode()))
    time: Array = np.asarray(SAMPLE * np.arange(round(seconds / SAMPLE)), np.float64)
    rate, phase, size = (
        rng.uniform(low, high, (count, 3, 1)) for low, high in ((0.3, 1.5), (0.0, 2 * np.pi), (0.3, 0.6))
    )
    torque = np.sum(size * np.sin(2 * np.pi * rate * time + phase), axis=1)
    angle = driven(np.repeat(torque, held, axis=1), rng.uniform(-2.0, 2.0, count), step, friction, 0.02)[:, ::held]
    seen = {
        "crank.position": ("rad", angle + rng.normal(scale=noise[0], size=angle.shape)),
        "slider.position": ("m", place(angle) + rng.normal(scale=noise[1], size=angle.shape)),
    }
    return [
        Log(
            name,
            {channel: Signal(channel, unit, time, value[k]) for channel, (unit, value) in seen.items()},
            {"motor": Signal("motor", "N·m", time, torque[k])},
        )
        for k, name in enumerate(names)
    ]


def written(folder: Path, found: Sequence[Log], offset: float) -> list[str]:
    """The logs as tables, the slider counted from another zero."""
    paths = []
    for log in found:
        columns = [*log.outputs.values(), *log.commands.values()]
        rows = np.column_stack([columns[0].time, *(signal.value for signal in columns)])
        rows[:, 2] += offset
        paths.append(str(folder / f"{log.name}.csv"))
        np.savetxt(paths[-1], rows, "%.9g", ",", header="time,crank,slider,motor", comments="")
    return paths

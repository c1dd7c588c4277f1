"""A rover on two wheels and casters, its place measured as a motion capture does."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.trajectory import Array, Log, Signal

STEP = 0.002  # s
OUTPUTS = {"left.position": 2e-4, "right.position": 2e-4, "sensor.place": 2e-4, "sensor.turn": 5e-4}  # noise, rad and m


def rover(friction: float = 0.0, gravity: str = "0 0 -9.81") -> str:
    """The MJCF; the left wheel's dry friction in N·m."""
    wheel = '<geom type="sphere" size="0.05" condim="4" friction="0.9 0.005 0.0001"/>'
    wheel += '<inertial pos="0 0 0" mass="0.3" diaginertia="0.0002 0.0004 0.0002"/>'
    axle = 'axis="0 1 0" damping="0.01" armature="0.003"'
    caster = 'type="sphere" size="0.02" friction="0.02 0.0001 0.0001" priority="1"'
    return f"""<mujoco model="rover"><option timestep="{STEP}" integrator="RK4" gravity="{gravity}"/><worldbody>
      <geom type="plane" size="5 5 0.1" friction="0.9 0.005 0.0001"/>
      <body name="chassis" pos="0 0 0.05"><freejoint/>
        <inertial pos="-0.03 0 0.02" mass="6" diaginertia="0.04 0.06 0.08"/>
        <geom name="rear" pos="-0.13 0 -0.03" {caster}/><geom name="front" pos="0.13 0 -0.0295" {caster}/>
        <body pos="0 0.13 0"><joint name="left" {axle} frictionloss="{friction}"/>{wheel}</body>
        <body pos="0 -0.13 0"><joint name="right" {axle}/>{wheel}</body>
      </body></worldbody>
      <actuator><motor name="left" joint="left"/><motor name="right" joint="right"/></actuator>
      <sensor><framepos name="place" objtype="xbody" objname="chassis"/>
        <framequat name="turn" objtype="xbody" objname="chassis"/></sensor></mujoco>"""


@dataclass(frozen=True)
class Driven:
    """How a rover drove.

    Attributes:
        time: s, shape (n,).
        qpos: shape (n, nq).
        qvel: shape (n, nv).
        controls: of the step behind each, shape (n, nu).
    """

    time: Array
    qpos: Array
    qvel: Array
    controls: Array

    def log(self, name: str, seed: int) -> Log:
        """A log of every fifth step, with noise."""
        rng, rows = np.random.default_rng(seed), slice(None, None, 5)
        exact = {
            "left.position": self.qpos[rows, 7],
            "right.position": self.qpos[rows, 8],
            "sensor.place": self.qpos[rows, :3],
            "sensor.turn": self.qpos[rows, 3:7],
        }
        noisy = {k: value + OUTPUTS[k] * rng.standard_normal(value.shape) for k, value in exact.items()}
        noisy["sensor.turn"] /= np.linalg.norm(noisy["sensor.turn"], axis=1, keepdims=True)
        outputs = {k: Signal(k, "", self.time[rows], value) for k, value in noisy.items()}
        commands: Mapping[str, Signal] = {
            side: Signal(side, "N·m", self.time[rows], self.controls[rows, k])
            for k, side in enumerate(("left", "right"))
        }
        return Log(name, outputs, commands)


def drive(xml: str, seconds: float, seed: int, size: float = 0.09) -> Driven:
    """Sums of sines at both motors, held over five steps, from rest on the ground."""
    model = mujoco.MjModel.from_xml_string(xml)
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    frequency, phase = rng.uniform(0.1, 0.9, (2, 4)), rng.uniform(0.0, 2 * np.pi, (2, 4))
    count = round(seconds / STEP)
    rows: Sequence[list[Array]] = ([], [], [])
    for k in range(count):
        if k % 5 == 0:
            data.ctrl[:] = size * np.sin(2 * np.pi * frequency * k * STEP + phase).sum(1)
        for kept, value in zip(rows, (data.qpos, data.qvel, data.ctrl), strict=True):
            kept.append(value.copy())
        mujoco.mj_step(model, data)
    return Driven(np.linspace(0.0, STEP * (count - 1), count), *(np.array(each) for each in rows))

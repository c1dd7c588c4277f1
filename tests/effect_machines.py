"""Machines with known answers, and effects as their yaml files make them, for the tests of the effects."""

from functools import cache
from pathlib import Path

import hydra
import mujoco
import numpy as np
from hydra.utils import instantiate
from mujoco.batch import MODEL_FIELDS
from omegaconf import DictConfig

from dr_lab.cli.groups import every
from dr_lab.effects.effect import Effect, PlacedEffect, Scales, place
from dr_lab.physics.body_contexts import field_of
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

CONF = Path(__file__).parents[1] / "conf"
NAMES = tuple(every("effect", (CONF,)))


@cache
def _composed(names: str) -> DictConfig:
    with hydra.initialize_config_dir(str(CONF), version_base=None):
        return hydra.compose(overrides=[f"+effect=[{names}]"]).effects


@cache
def catalogue_effect(name: str) -> Effect:
    """The effect that conf/effect/<name>.yaml describes."""
    composed = _composed(",".join(NAMES) if name in NAMES else name)
    return instantiate(composed[name], _convert_="all")


def block(actuator: str = '<motor name="drive" joint="rail"/>', joint: str = "", option: str = "") -> Model:
    """A block of 2 kg on a horizontal rail, so that x'' = F / 2 kg."""
    xml = f"""<mujoco model="block">
      <compiler angle="radian"/>
      <option timestep="0.002" integrator="RK4" gravity="0 0 -9.81" {option}/>
      <worldbody><body name="block">
        <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/>
        <joint name="rail" type="slide" axis="1 0 0" {joint}/>
      </body></worldbody>
      <actuator>{actuator}</actuator>
    </mujoco>"""
    return from_spec("block", mujoco.MjSpec.from_string(xml), {})


def block_by(integrator: str, joint: str = "") -> Model:
    """The same by another integrator, such as ``Euler``."""
    found = block(joint=joint)
    found.spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    return found


def hanging(joint: str = "") -> Model:
    """A pendulum about y that hangs from the origin: 0.5 kg at 0.3 m, 0.005 kg·m² about its centre."""
    xml = f"""<mujoco model="pendulum">
      <compiler angle="radian"/>
      <option timestep="0.002" integrator="RK4" gravity="0 0 -9.81"/>
      <worldbody><body name="rod">
        <inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
        <joint name="hinge" axis="0 1 0" {joint}/>
      </body></worldbody>
      <actuator><motor name="drive" joint="hinge"/></actuator>
    </mujoco>"""
    return from_spec("pendulum", mujoco.MjSpec.from_string(xml), {})


def scales_of(model: Model, torque: float = 10.0, speed: float = 2.0, position: float = 1.0) -> Scales:
    """The same magnitudes for every joint, and commands up to 5."""
    compiled = model.nominal()
    names = [compiled.joint(i).name for i in range(compiled.njnt)]
    return Scales(
        lowest=dict.fromkeys(names, -position / 2),
        highest=dict.fromkeys(names, position / 2),
        speed=dict.fromkeys(names, speed),
        torque=dict.fromkeys(names, torque),
        command={compiled.actuator(i).name: 5.0 for i in range(compiled.nactuator)},
    )


def placed(model: Model, name: str, site: str, scales: Scales | None = None) -> PlacedEffect:
    """The catalogue's effect at a site of a model."""
    return place(catalogue_effect(name), model.nominal(), site, scales or scales_of(model))


def with_effect(model: Model, name: str, site: str, **values: float) -> mujoco.MjModel:
    """The model compiled with an effect of the catalogue at the given values (short names)."""
    extended = model.with_effect(placed(model, name, site))
    label = extended.effects[-1].label
    return extended.compile(extended.space.vector({f"{label}.{key}": value for key, value in values.items()}))


def motion(model: mujoco.MjModel, seconds: float, qpos: float = 0.0, qvel: float = 0.0, ctrl: float = 0.0) -> Array:
    """Time, position and velocity of the first joint under a constant command, shape (steps + 1, 3)."""
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = qpos, qvel
    if model.nu:
        data.ctrl[0] = ctrl
    rows = [(0.0, qpos, qvel)]
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        rows.append((data.time, data.qpos[0], data.qvel[0]))
    return np.array(rows)


def stopping(model: mujoco.MjModel) -> Array:
    """How the block moves that slides, stops under a friction of 8 N, and creeps on if that lets it; as `motion`."""
    return motion(model, 0.6, ctrl=6.0, qvel=0.4)


def acceleration(model: mujoco.MjModel, qpos: float = 0.0, qvel: float = 0.0, ctrl: float = 0.0) -> float:
    """Acceleration of the first joint in a state."""
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = qpos, qvel
    if model.nu:
        data.ctrl[0] = ctrl
    mujoco.mj_forward(model, data)
    return float(data.qacc[0])


def energies(model: mujoco.MjModel, qpos: list[float], qvel: list[float]) -> Array:
    """Kinetic and potential energy in 500 steps of RK4 without damping, J."""
    model.dof_damping[:] = 0.0
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, found = mujoco.MjData(model), []
    data.qpos[:], data.qvel[:] = qpos, qvel
    for _ in range(500):
        mujoco.mj_step(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        found.append(float(data.energy.sum()))
    return np.array(found)


def replayed(model: Model, z: Array, controls: Array, past: Array, seed: int = 0) -> Array:
    """Positions of one window under contexts z (c, n), all from the same random state, shape (c, s + 1, nq)."""
    compiled = model.nominal()
    rng = np.random.default_rng(seed)
    qpos = compiled.qpos0.copy()
    mujoco.mj_integratePos(compiled, qpos, 0.2 * rng.normal(size=compiled.nv), 1.0)
    qvel = 0.5 * rng.normal(size=compiled.nv)
    count = len(z)
    rollout = Simulator(model, count, threads=1).replay(
        z, np.tile(qpos, (count, 1, 1)), np.tile(qvel, (count, 1, 1)), controls, past
    )
    assert not rollout.infeasible.any()
    return rollout.qpos


def field_sizes(model: mujoco.MjModel) -> list[tuple[int, ...]]:
    """Shapes of a model's fields that simulations may have of their own; beside a law they are written one by one."""
    return [field_of(model, name).shape for name in MODEL_FIELDS]


def model_bytes(model: mujoco.MjModel) -> bytes:
    """All of a compiled model."""
    buffer = np.zeros(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()

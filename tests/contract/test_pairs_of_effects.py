"""Two effects in one model: what a fit simulates is what the exported model simulates."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from effect_machines import NAMES, catalogue_effect, scales_of

from dr_lab.comparison.export import ExportedModel
from dr_lab.effects.effect import PlacedEffect, place
from dr_lab.physics.law import History
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

STEPS, BEFORE = 75, 40
CART = """<mujoco model="cart">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="RK4" density="1.2"/>
  <worldbody><body name="cart">
    <inertial mass="1" pos="0.02 0 0.01" diaginertia="0.01 0.01 0.01"/>
    <joint name="rail" axis="0 1 0" damping="0.5" stiffness="2" springref="0.1"/>
    <body name="rod">
      <joint name="hinge" axis="0 1 0" damping="0.01"/>
      <geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.4" density="1500"/>
    </body>
  </body></worldbody>
  <actuator><motor name="drive" joint="rail" gear="2"/></actuator>
</mujoco>"""
GEAR = {"gear": {"target": "actuator.drive.gear[0]", "unit": "1", "low": 0.5, "high": 4.0}}
ACTING = (  # on what a motor gives
    ("joint_elasticity", "rail"),
    ("motor_side_elasticity", "rail"),
    ("backlash", "rail"),
    ("torque_speed_limit", "drive"),
)


@cache
def machine(gear: float = 2.0) -> Model:
    model = from_spec("cart", mujoco.MjSpec.from_string(CART), GEAR)
    return replace(model, spec=model.spec_at(np.array([gear])))


def put(name: str, site: str) -> PlacedEffect:
    return place(catalogue_effect(name), machine().nominal(), site, scales_of(machine(), torque=3.0, speed=2.0))


def present(one: PlacedEffect) -> dict[str, float]:
    """Values at which the effect acts: its last start, and well off absent where that says nothing."""
    away = {p.name: 0.6 * p.nominal + 0.4 * p.high for p in one.parameters}
    return {**away, **(one.starts[-1] if one.starts else {})}


def exported(model: Model, z: Array) -> Model:
    """The model that an export reads back, with all digits."""
    return ExportedModel(model.name, model.spec_at(z), (), {}, model.effects, fixed=model.space.mapping(z))


def played(model: Model, z: Array) -> Array:
    """Positions under contexts z (c, n), after some measured motion, shape (c, s + 1, nq)."""
    nu, count = model.nominal().nu, len(z)
    wave = 4.0 * np.sin(0.1 * np.arange(-BEFORE, STEPS))[:, None] * (np.arange(nu) == 0)
    moved = np.sin(0.01 * np.arange(-BEFORE, 0.0))[None, :, None] * [0.3, -0.2]
    history = History(np.array([0.4]), moved, 5.0 * np.cos(5.0 * moved), wave[None, :BEFORE])
    starts = np.full((count, 1, 2), 0.1), np.full((count, 1, 2), 1.5)
    rollout = Simulator(model, count, threads=1).replay(z, *starts, wave[None, BEFORE:], wave[None, :BEFORE], history)
    assert not rollout.infeasible.any()
    return rollout.qpos


def pairs() -> Iterator[object]:
    """Every other place; what an effect does at its second site and further ones is left to the slow tests."""
    compiled = machine().nominal()
    for name, site in ACTING:
        for other in NAMES:
            for k, beside in enumerate(catalogue_effect(other).sites(compiled)):
                if (other, beside) != (name, site):
                    yield pytest.param(name, site, other, beside, marks=[pytest.mark.slow] if k else [])


@pytest.mark.parametrize(("name", "site", "other", "beside"), list(pairs()))
def test_a_fit_simulates_what_its_export_simulates(name: str, site: str, other: str, beside: str) -> None:
    effects = put(name, site), put(other, beside)
    both = replace(machine(), effects=effects)
    values = {**present(effects[0]), **present(effects[1]), "gear": 3.0}
    z = np.stack([both.space.vector(values), both.space.nominal])
    fitted = played(both, z)[0]
    alone = played(exported(both, z[0]), np.empty((1, 0)))[0]
    np.testing.assert_allclose(fitted, alone, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("name", "site"), ACTING)
def test_a_declared_gear_is_the_gear(name: str, site: str) -> None:
    """Whether it is the model's own or a parameter's value."""
    one = put(name, site)
    low, high = (replace(machine(gear), effects=(one,)) for gear in (1.0, 3.0))
    z = low.space.vector({**present(one), "gear": 3.0})[None]
    np.testing.assert_allclose(played(low, z), played(high, z), rtol=0, atol=1e-9)

"""A block that is to be pushed towards a goal, which is its context, and policies for it."""

from dataclasses import dataclass

import mujoco
import numpy as np
import torch
from block_on_rail import BlockOnRail, constant

from dr_lab.collectors.collector import Policy
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.evaluators.evaluator import Subject
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser
from dr_lab.physics.model import from_spec
from dr_lab.physics.parameter import Parameter
from dr_lab.training.policy_snapshots import PolicySnapshot
from dr_lab.trajectory import Array

STEP, STEPS = 0.1, 4
XML = f"""<mujoco model="block"><option timestep="{STEP}" integrator="Euler"/><worldbody><body name="block">
  <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-9 9"/></actuator></mujoco>"""


@dataclass(frozen=True, kw_only=True)
class Towards(BlockOnRail):
    """What the velocity has towards the goal's side is rewarded."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("goal.side", "1", 1.0, -1.0, 1.0),)

    def observe(self, fields: Fields, values: Values) -> Array:
        del values
        return fields["qvel"].copy()

    def reward(self, change: Change) -> Array:
        return change.values["goal.side"] * change.fields["qvel"][:, 0]


def towards() -> Setting:
    model, task = from_spec("block", mujoco.MjSpec.from_string(XML), {}), Towards(frame_skip=1, time_limit=STEPS)
    return Setting(name="towards", model=model, task=task, show_context=False, infeasible_return=-99.0)


def gaussian() -> GaussianActor:
    return GaussianActor(1, np.array([-9.0]), np.array([9.0]), 0, NoNormaliser, [], "tanh", log_std=-2.0)


def subject(*policies: Policy, setting: Setting | None = None) -> Subject:
    """A run on the goals, or another task, that has kept these policies, 100 control steps apart."""
    kept = [PolicySnapshot(100 * k, policy, constant(0.0)) for k, policy in enumerate(policies, start=1)]

    def again(*_: object) -> None:
        raise AssertionError

    return Subject("run", setting or towards(), constant(0.0), again, threads=1, snapshots=kept)  # pyright: ignore[reportArgumentType]


def without_noise() -> Policy:
    return lambda observation: torch.zeros(len(observation), 1)

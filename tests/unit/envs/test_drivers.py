"""The model that a policy drives is the model."""

from dataclasses import fields

import numpy as np
from effect_machines import hanging, placed

from dr_lab.envs.drivers import stepwise
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator


def test_free_inertias_reach_the_machine_that_a_policy_drives() -> None:
    free = from_spec("pendulum", hanging().spec, "inertial")
    contexts = np.stack([free.space.nominal, free.space.high])
    velocities = []
    for model in (free, stepwise(free)):
        simulator = Simulator(model, 2, threads=1)
        simulator.set_contexts(contexts)
        simulator.reset()
        simulator.step(np.ones((2, 1)), 50)
        velocities.append(simulator.batch.bind("qvel")[:, 0].copy())
    np.testing.assert_array_equal(velocities[1], velocities[0])
    assert velocities[0][0] != velocities[0][1]


def test_nothing_of_the_model_is_lost() -> None:
    parameters = {"inertial": "all", "damping": {"target": "joint.hinge.damping", "unit": "1", "low": 0.0, "high": 1.0}}
    model = from_spec("pendulum", hanging().spec, parameters, {"joint.hinge.armature": "damping / 100"})
    model = model.with_effect(placed(model, "dead_zone", "drive"))
    driven = stepwise(model)
    assert all(getattr(driven, field.name) is getattr(model, field.name) for field in fields(Model))

"""Steps that evaluate the equations of motion once."""

from dataclasses import replace

import mujoco

from dr_lab.physics.model import Model


def single_stage(model: Model) -> Model:
    """The model with semi-implicit Euler steps in place of RK4, which evaluates its equations four times a step.

    Args:
        model: the model; returned as it is where its integrator is another one, which evaluates them once.
    """
    if model.spec.option.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        return model
    spec = model.spec.copy()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    found = replace(model, spec=spec)
    vars(found)["bodies_apart"] = model.bodies_apart  # it takes compiling to tell, and the integrator is no part of it
    return found

"""What effects at a body's contacts have in common."""

import mujoco

from dr_lab.effects.body_effect import moving_bodies
from dr_lab.effects.contact_pairs import meeting
from dr_lab.effects.effect import Effect


class ContactEffect(Effect):
    """An effect that sits at a moving body whose geoms may touch others: a foot, a wheel, a finger.

    A contact takes its parameters from both geoms, by maxima, means and priorities. A change of one geom may therefore
    change nothing, or change other bodies' contacts. So the body's contacts become explicit pairs, each with parameters
    of its own.
    """

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the bodies with contacts that end a chain or touch something in the model's initial position.

        Links in the middle of a chain can hardly touch before the chain's end does.
        """
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        touching = {int(model.geom_bodyid[geom]) for geom in data.contact.geom.flat if geom >= 0}
        parents = {int(parent) for parent in model.body_parentid}
        bodies = ((name, model.body(name).id) for name in moving_bodies(model))
        outer = ((name, body) for name, body in bodies if body in touching or body not in parents)
        return tuple(name for name, body in outer if meeting(model, body))

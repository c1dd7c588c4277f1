"""What effects at a body's contacts have in common."""

import mujoco

from dr_lab.effects.body_effect import moving_bodies
from dr_lab.effects.contact_pairs import meeting
from dr_lab.effects.effect import Effect


class ContactEffect(Effect):
    """An effect that sits at a moving body whose geoms may touch others: a foot, a wheel, a finger.

    Contacts take their parameters from both geoms, by maxima, means and priorities, so that a change of one geom may
    change nothing, or other bodies' contacts. The contacts of the body become explicit pairs, which stand alone.
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

"""Where the fit of a model begins when an effect is taken away from one that was fitted with it."""

import numpy as np

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.search.as_special_case import shared
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


def taken_away(fitter: Fitter, whole: FittedModel) -> list[Point]:
    """The starts, each with the states of the whole model's fit.

    1. The other parameters are as they were.
    2. They make up as best they can for what is gone, by the linear model: a mass takes over from a payload. Without
       that the effect would get the credit for what the others can do alone.
    3. One effect that stays does what both did, where one of the two is a special case of the other: friction that
       creeps takes over from Coulomb friction beside it. The linear model does not tell that where only their sum is
       known, and the way there is long.

    Args:
        fitter: of the model that lacks something.
        whole: the model that has it, fitted to the same windows.
    """
    names, space = fitter.space.names, whole.model.space
    gone = {p.name: p.nominal for p in space.parameters if p.name not in names}
    rows = [space.index(name) for name in names]
    made_up, states = whole.fit.made_up(space, gone)
    starts = [
        fitter.begin(np.asarray(z[rows]), delta) for z, delta in ((whole.fit.z, whole.fit.delta), (made_up, states))
    ]
    return starts + [fitter.begin(z, whole.fit.delta) for z in _left_to(fitter.replay.model, whole)]


def _left_to(fewer: Model, whole: FittedModel) -> list[Array]:
    """Contexts in which one of the effects that stay does what those of its kind that are gone did, too."""
    stay, space, values = {effect.label for effect in fewer.effects}, fewer.space, whole.values()
    placed = [effect for effect in whole.model.effects if isinstance(effect, PlacedEffect)]
    gone, contexts = [effect for effect in placed if effect.label not in stay], list[Array]()
    for heir in (effect for effect in placed if effect.label in stay):
        left = {name: values[name] for name in space.names}
        for other in gone:
            for ours, its in shared(heir, other).items():
                if ours not in heir.effect.shapes:
                    left[f"{heir.label}.{ours}"] += values[f"{other.label}.{its}"]
        if any(left[name] != values[name] for name in space.names):
            contexts.append(space.clip(space.vector(left)))
    return contexts

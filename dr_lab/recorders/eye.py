"""Where the eye stands, so that a moving robot just fills its view."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from dr_lab.recorders.look import Look
from dr_lab.trajectory import Array

# Rerun's eye sees this angle from the lower to the upper edge of a view.
_FIELD_OF_VIEW = np.deg2rad(55.0)
# Width over height of the narrowest view that a robot is shown in.
_ASPECT = 0.85
# Rerun's eye begins to follow a thing from this many times the half diagonal of its bounding box.
_BEGINNING = 1.5
_UNSEEN = (0, 0, 0, 0)


def eye_controls(points: Array, look: Look, followed: str | None = None) -> rrb.EyeControls3D:
    """An orbiting eye that sees all points; see `stand`.

    Args:
        points: what must be seen, m, shape (k, 3), k ≥ 1.
        look: direction of the eye and the margin.
        followed: path of an entity that the eye goes along with; None lets it stand.
    """
    position, target = stand(points, look)
    return rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=position,
        look_target=target,
        eye_up=[0, 0, 1],
        tracking_entity=followed,
    )


def followed_box(points: Array, look: Look) -> rr.Boxes3D:
    """A box that is not seen about what `stand` looks at, so large that an eye that follows it stands there, too."""
    position, target = stand(points, look)
    half = np.linalg.norm(position - target) / (_BEGINNING * np.sqrt(3.0))
    return rr.Boxes3D(half_sizes=[[half] * 3], centers=[target], fill_mode="solid", colors=[_UNSEEN])


def stand(points: Array, look: Look) -> tuple[Array, Array]:
    """Position of the eye and the point that it looks at, each in m, shape (3,).

    With u to the right, v up and w towards the eye from the middle of the points, one at (u, v, w) is inside the view
    from a distance d ≥ w + max(|u| / aspect, |v|) / tan(field of view / 2). The largest of these, times the margin,
    is the distance.

    Args:
        points: what must be seen, m, shape (k, 3), k ≥ 1.
        look: direction of the eye and the margin.
    """
    azimuth, elevation = np.deg2rad([look.azimuth, look.elevation])
    towards = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    axes = np.stack([right, np.cross(towards, right), towards])
    seen = points @ axes.T
    middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
    u, v, w = (seen - middle).T
    distance = np.max(w + np.maximum(np.abs(u) / _ASPECT, np.abs(v)) / np.tan(_FIELD_OF_VIEW / 2))
    target = middle @ axes
    return target + look.margin * distance * towards, target

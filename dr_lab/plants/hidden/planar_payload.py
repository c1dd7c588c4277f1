"""A rigid body of any shape that is fixed to a link of a planar mechanism."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_payload import RigidPayload


@dataclass(frozen=True)
class PlanarPayload(RigidPayload):
    """Point masses that are held together, of which the joints feel what they are in the plane."""

    name: ClassVar[str] = "planar_payload"

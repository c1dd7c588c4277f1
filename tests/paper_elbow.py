"""The two-joint arm of the strangers by Lagrange's equations."""

from dr_lab.plants.double_pendulum import DoublePendulum
from dr_lab.plants.drive import ForceDrive
from dr_lab.plants.moments import Moments

UPPER, FORE = 0.9, 0.6  # kg, as documented


def on_paper(
    length: float, upper: float = UPPER, fore: float = FORE, damping: tuple[float, float] = (0.0, 0.0)
) -> DoublePendulum:
    """The arm with an upper link of a length (m), masses (kg) and dampings (N·m·s/rad); inertias go with the masses."""
    return DoublePendulum(
        links=(
            Moments.body(upper, 0.14, 0.00675 * upper / UPPER),
            Moments.body(fore, 0.16, 0.00648 * fore / FORE),
        ),
        damping=damping,
        armature=(0.005, 0.003),
        gravity=(0.0, 0.0, -9.81),
        drives=(ForceDrive(), ForceDrive()),
        length=length,
        rotor=0.0,
        gear=0.0,
    )

"""What effects of bodies and of what surrounds the machine could give along a course."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from dr_lab.plants.alike.course import Course
from dr_lab.plants.alike.felt import Felt
from dr_lab.plants.alike.grids import Grids
from dr_lab.plants.alike.lacking import lacking
from dr_lab.plants.alike.response import Signature
from dr_lab.plants.alike.rival import Rival, lacked, linear
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.trajectory import Array

_SMALL = 1e-4  # kg, m, rad, share: step of derivatives of what is linear, or nearly so
# m: whatever is fixed to a body acts as a sum of ten point masses here, some of them negative.
_PLACES = np.concatenate([0.1 * np.eye(3), -0.1 * np.eye(3), 0.1 - 0.1 * np.eye(3), np.zeros((1, 3))])
_IN_PLANE = 0.1 * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]])  # m; in a plane four are enough


def body_rivals(course: Course, grids: Grids, felt: Felt, command: Array, base: Array) -> Iterator[Rival]:
    """Effects of every body, then of the world.

    Args:
        course: where the machine moves.
        grids: shapes that are tried.
        felt: what counts.
        command: mean over each interval, shape (K, actuators).
        base: what the machine without any effect lacks, shape (K, n).
    """
    own = lacking(course, course.machine, np.zeros_like(command))
    density, wind = course.machine.model.opt.density, course.machine.model.opt.wind
    calm = course.machine.with_medium(-density, tuple(-wind)) if density > 0 else course.machine
    response = _Response(course, command, base, felt, float(np.abs(own).max()), calm)
    for body in course.machine.bodies:
        yield from _of_body(response, body, grids)
    yield from _of_world(response)


@dataclass(frozen=True)
class _Response:
    """What the machine lacks where it is altered a little.

    Attributes:
        course: where the machine moves.
        command: mean over each interval, shape (K, actuators).
        base: what the machine as it is lacks, shape (K, n).
        counts: what counts as felt.
        largest: force that inertia and gravity ask for along the course, N·m or N.
        calm: the machine without medium.
    """

    course: Course
    command: Array
    base: Array
    counts: Felt
    largest: float
    calm: MujocoMachine

    def slope(self, altered: MujocoMachine, by: float) -> Array:
        """Change of what is lacking, for each unit of what was altered."""
        return (lacking(self.course, altered, self.command) - self.base) / by

    def weighed(self, body: str, places: Array) -> list[Array]:
        """Change of what is lacking for each kg at each of some places in a body's frame, by inertia and weight alone.

        To a medium a body is a box that grows with what is fixed to it: no load is told by that.
        """
        base = lacking(self.course, self.calm, self.command)
        loaded = (self.calm.with_mass_at(body, _SMALL, place) for place in places)
        return [(lacking(self.course, each, self.command) - base) / _SMALL for each in loaded]

    def loads(self, body: str, places: Array) -> list[Signature]:
        """What each kg at each of some places in a body's frame gives."""
        machine = self.course.machine
        return [lacked(self.slope(machine.with_mass_at(body, _SMALL, place), _SMALL)) for place in places]

    def swing(self, body: str, axis: Array) -> Array:
        """Change of what is lacking for each m by which a body's centre moves along an axis, of first order alone."""
        ahead, behind = (self.course.machine.with_centre_moved(body, side * _SMALL * axis) for side in (1.0, -1.0))
        return 0.5 * (self.slope(ahead, _SMALL) - self.slope(behind, _SMALL))

    def felt(self, *columns: Array) -> list[Array]:
        """Those of some slopes that change a force."""
        return self.counts.alone([*columns], self.largest)


def _of_body(response: _Response, body: str, grids: Grids) -> Iterator[Rival]:
    machine, slope, felt = response.course.machine, response.slope, response.felt
    lever = machine.lever(body)
    near, middle, far = (slope(machine.with_load(body, _SMALL, share * lever), _SMALL) for share in (0.0, 1.0, 2.0))
    # What a point mass adds is of second order in its distance.
    bend, rise = 0.5 * (far - 2 * middle + near), 0.5 * (4 * middle - 3 * near - far)
    reaches = grids.reaches if machine.turns(body) else [1.0]
    loads = [lacked(near + share * rise + share**2 * bend) for share in reaches]
    yield Rival(f"payload@{body}", 1 + machine.turns(body), tuple(linear(load, positive=True)[0] for load in loads))
    places = machine.in_plane(body, _IN_PLANE)
    if response.counts.together(response.weighed(body, _PLACES)):
        yield Rival(f"rigid_payload@{body}", len(_PLACES), linear(*response.loads(body, _PLACES)))
    elif len(flat := felt(*response.weighed(body, places))) == len(_IN_PLANE) and response.counts.together(flat):
        yield Rival(f"planar_payload@{body}", len(flat), linear(*response.loads(body, places)))
    moved = felt(*(response.swing(body, axis) for axis in np.eye(3)))
    if moved:
        yield Rival(f"centre_of_mass_offset@{body}", len(moved), linear(*map(lacked, moved)))
    if machine.link(body):
        longer = felt(slope(machine.with_link_longer(body, _SMALL), _SMALL))
        if longer:
            yield Rival(f"link_length@{body}", 1, linear(*map(lacked, longer)))
    wider = felt(slope(machine.with_inertia_scaled(body, 1 + _SMALL), _SMALL))
    if wider:
        yield Rival(f"inertia_error@{body}", 1, linear(*map(lacked, wider)))
    pulls = _pulls(response.course, body)
    anchor = len(felt(*pulls[1:])) if machine.turns(body) else 0
    if anchor:
        signs = (True, False, False, False)
        yield Rival(f"cable_force@{body}", 2 + anchor, linear(*map(lacked, pulls), positive=signs))


def _pulls(course: Course, body: str) -> list[Array]:
    """What a cable to a body's centre p that is never slack takes, by k and by each entry of k a, shape (K, n) each.

    k (a − p) through the centre's Jacobian, with a its anchor.
    """
    found = [course.machine.centre(position, body) for position in course.position]
    places, turnings = (np.array(each) for each in zip(*found, strict=True))
    return [np.einsum("kp,kpn->kn", places, turnings), *-turnings.transpose(1, 0, 2)]


def _of_world(response: _Response) -> Iterator[Rival]:
    machine, slope, felt = response.course.machine, response.slope, response.felt
    x, y, z = machine.gravity
    tilted = felt(
        slope(machine.with_gravity((x, y + _SMALL * z, z - _SMALL * y)), _SMALL),
        slope(machine.with_gravity((x - _SMALL * z, y, z + _SMALL * x)), _SMALL),
    )
    if tilted:
        yield Rival("base_tilt@world", len(tilted), linear(*map(lacked, tilted)))
    lighter = felt(slope(machine.with_gravity(((1 - _SMALL) * x, (1 - _SMALL) * y, (1 - _SMALL) * z)), _SMALL))
    if lighter and len(machine.joints) > 1:
        yield Rival("gravity_compensation@world", 1, linear(*map(lacked, lighter), positive=True))
    dragged = felt(slope(machine.with_medium(1.0, (0.0, 0.0, 0.0)), 1.0))
    if dragged:
        yield Rival("air_drag@world", 1, linear(*map(lacked, dragged), positive=True))
    if machine.model.opt.density > 0:
        blown = felt(*(slope(machine.with_medium(0.0, wind), 1.0) for wind in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))))
        if blown:
            yield Rival("wind@world", len(blown), linear(*map(lacked, blown)))

"""A place in a recording's tree of entities, and the ways to write there."""

from dataclasses import dataclass

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from dr_lab.trajectory import Array

TIMELINE = "t"
ITERATIONS = "iteration"
FRAMES = "frames"


@dataclass(frozen=True)
class Branch:
    """An entity of a recording; ``branch / "name"`` is the one below it, whatever characters the name has.

    Attributes:
        recording: the recording that is written.
        parts: the entity's path, unescaped.
    """

    recording: rr.RecordingStream
    parts: tuple[str, ...] = ()

    def __truediv__(self, part: str) -> "Branch":
        """The entity `part` below this one."""
        return Branch(self.recording, (*self.parts, part))

    def static(self, archetype: rr.AsComponents) -> None:
        """Write something that holds at all times."""
        self.recording.log(entity_path(*self.parts), archetype, static=True)

    def over_time(self, time: Array, columns: rr.ComponentColumnList) -> None:
        """Write columns over times in s, shape (n,), in one go."""
        # Rounded here, because Rerun cuts seconds down to whole nanoseconds: 4.1 s would become 4.099999999 s.
        clock = rr.TimeColumn(TIMELINE, duration=np.rint(1e9 * time).astype("timedelta64[ns]"))
        self.recording.send_columns(entity_path(*self.parts), [clock], columns)

    def over_iterations(self, iteration: NDArray[np.integer], columns: rr.ComponentColumnList) -> None:
        """Write columns over iterations of training, shape (n,), in one go."""
        self.over(ITERATIONS, iteration, columns)

    def over_frames(self, frames: NDArray[np.integer], columns: rr.ComponentColumnList) -> None:
        """Write columns over control steps of training, shape (n,), in one go."""
        self.over(FRAMES, frames, columns)

    def over(self, timeline: str, count: NDArray[np.integer], columns: rr.ComponentColumnList) -> None:
        """Write columns over what a timeline counts, shape (n,), in one go."""
        self.recording.send_columns(entity_path(*self.parts), [rr.TimeColumn(timeline, sequence=count)], columns)


def entity_path(*parts: str) -> str:
    """Rerun's path of an entity, with the special characters of its parts escaped."""
    return rr.new_entity_path([*parts])

"""A recording as a file that is whole or not there."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from dr_lab.files import atomic
from dr_lab.recorders.branch import Branch


@contextmanager
def recording_file(path: Path, application: str, name: str, blueprint: rrb.Blueprint) -> Iterator[Branch]:
    """Write a recording with its layout, atomically.

    Args:
        path: the file, by custom ``review.rrd``.
        application: whose layout it is; Rerun keeps one for each.
        name: of the recording.
        blueprint: the layout.

    Yields:
        The root of its entities.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    with atomic(path) as temporary:
        recording = rr.RecordingStream(application)
        try:
            recording.save(temporary, default_blueprint=blueprint)
            recording.send_recording_name(name)
            yield Branch(recording)
        finally:
            # Also closes the file, which would otherwise lack its end.
            recording.disconnect()

"""`review.rrd` of a benchmark: its rates, its confusion matrix, its cases."""

from collections.abc import Mapping
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from dr_lab.recorders.confusion import Picture
from dr_lab.recorders.recording import recording_file

# Rerun keeps one layout an application: every recording of a benchmark shares this one.
APPLICATION = "dr_lab_benchmark"


def write_benchmark_review(path: Path, picture: Picture, pages: Mapping[str, str]) -> None:
    """Write the recording with its layout, atomically.

    Entities: ``/confusion`` and ``/pages/<title>``; the first page stands beside the matrix.

    Args:
        path: the file, by custom ``review.rrd``.
        picture: the confusion matrix, shape (height, width, 3).
        pages: Markdown by title.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    with recording_file(path, APPLICATION, "benchmark", _blueprint(pages)) as root:
        (root / "confusion").static(rr.Image(picture))
        for title, text in pages.items():
            (root / "pages" / title).static(rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))


def _blueprint(pages: Mapping[str, str]) -> rrb.Blueprint:
    views = [rrb.TextDocumentView(origin=rr.new_entity_path(["pages", title]), name=title) for title in pages]
    matrix = rrb.Spatial2DView(origin="confusion", name="Confusion: hidden (rows) and answered (columns)")
    first = rrb.Horizontal(*views[:1], matrix, column_shares=[3, 4], name="Overview")
    return rrb.Blueprint(
        rrb.Tabs(first, *views[1:], name="Review"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="hidden"),
    )

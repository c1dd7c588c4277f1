"""Pages of a recording as the headless viewer draws them."""

import io
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from PIL import Image
from rerun.experimental import ViewerClient

Colour = tuple[int, ...]


def pages(viewer: ViewerClient) -> Iterator[tuple[str, set[str]]]:
    """Turn the pages one after the other; gives each one's name and the identities of its views."""
    layout = viewer.get_blueprint().blueprint
    book = next(
        parts["ContainerBlueprint"]
        for parts in layout.values()
        if parts.get("ContainerBlueprint", {}).get("display_name") == "Review"
    )
    for page in book["contents"]:
        book["active_tab"] = page
        views = set(_views(layout, page))
        viewer.set_blueprint(layout, of="recording")
        time.sleep(1.0)  # s: until the page is drawn
        kind = layout[page].get("ContainerBlueprint") or layout[page]["ViewBlueprint"]
        yield kind["display_name"], views


def _views(layout: dict[str, Any], part: str) -> Iterator[str]:
    """Identities of the views in a part of the layout; of tabs those in the first, which comes to the front."""
    if part.startswith("/view/"):
        yield part.removeprefix("/view/")
        return
    container = layout[part]["ContainerBlueprint"]
    children = container["contents"]
    if isinstance(children, str):  # an only child comes without its list
        children = [children]
    if container["container_kind"] == "Tabs":
        container["active_tab"], *_ = children = children[:1]
    for child in children:
        yield from _views(layout, child)


def pixels_of(viewer: ViewerClient, name: str, among: set[str]) -> np.ndarray:
    """Hue, saturation and value, 0 … 255, of the view whose name starts with `name`, shape (pixels, 3)."""
    view = next(v for v in viewer.get_state().views if v.name.startswith(name) and v.view_id in among)
    return np.asarray(Image.open(io.BytesIO(viewer.take_screenshot(view.view_id))).convert("HSV")).reshape(-1, 3)


def count(pixels: np.ndarray, colour: Colour) -> int:
    """Pixels of a colour, whatever the light on it: the same hue, or bright and grey where the colour is grey."""
    hue, saturation, value = pixels.astype(int).T
    wanted, strength, _ = np.asarray(Image.new("RGB", (1, 1), colour[:3]).convert("HSV")).ravel().astype(int)
    if strength < 40:
        return int(((saturation < 40) & (value > 120)).sum())
    turn = np.abs((hue - wanted + 128) % 256 - 128)
    return int(((turn < 8) & (saturation > 80) & (value > 80)).sum())


def require_pages(viewer: ViewerClient, expected: Mapping[str, Mapping[str, Sequence[Colour]]]) -> None:
    """Check that every page is there, that no view is empty, complains or lacks a colour.

    Args:
        viewer: a viewer with a recording.
        expected: by the beginning of a page's name and of a view's name, the colours that the view must show.
    """
    left = dict(expected)
    for page, views in pages(viewer):
        for view, colours in left.pop(page.partition(":")[0]).items():
            pixels = pixels_of(viewer, view, views)
            assert (pixels[:, 2] > 120).sum() > 100, f"{view} is empty"
            for colour in colours:
                assert count(pixels, colour) > 50, f"{view} lacks {colour}"
    assert not left
    complaints = {view.name: view.reports for view in viewer.get_state().views if view.reports}
    assert not complaints
    assert not [entry.message for entry in viewer.get_logs() if entry.level == "ERROR"]

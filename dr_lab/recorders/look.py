"""How a recording looks: rates, colours and the eye, read from `conf/recorder/`."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dr_lab.bounds import Count, Natural, Positive, require_bounds
from dr_lab.errors import ConfigError

COLOURS = ("measured", "before", "after", "noise", "command", "ground", "fixed", "text", "axis")


@dataclass(frozen=True)
class Look:
    """Settings of `review.rrd`.

    Attributes:
        longest: of a log or an episode, s that are shown, from its first sample on.
        episodes: of a trained policy that are played to be shown; 0 for none.
        pose_rate: highest rate of body poses, Hz.
        colours: ``#RRGGBB`` for each of `COLOURS`.
        palette: ``#RRGGBB`` of what is told apart by nothing but its colour, in turn.
        ghost_alpha: opacity of simulated robots, 0 … 255.
        ghost_swell: factor on their size, a little above 1; see `shape.Paint`.
        line_width: of plotted signals, points on the screen.
        measured_width: of measured signals, which lie below the simulated ones.
        scatter_points: most dots a role and joint in a scatter plot.
        scatter_bins: most equally filled velocity ranges whose mean residual is drawn.
        overview_channels: channels plotted on the first page.
        azimuth: direction from the robot to the eye about z, degrees from +x.
        elevation: of the eye above the horizontal plane, degrees.
        margin: distance of the eye over that from which all moving parts just fill the view.

    Raises:
        ConfigError: a colour is missing or not ``#RRGGBB``, or a number is too small.
    """

    longest: Positive
    episodes: Natural
    pose_rate: Positive
    colours: Mapping[str, str]
    palette: Sequence[str]
    ghost_alpha: Natural
    ghost_swell: Positive
    line_width: Positive
    measured_width: Positive
    scatter_points: Count
    scatter_bins: Count
    overview_channels: Natural
    azimuth: float
    elevation: float
    margin: Positive

    def __post_init__(self) -> None:
        require_bounds(self, "recorder")
        given = {f"colours.{name}": self.colours.get(name, "nothing") for name in COLOURS}
        given |= {f"palette[{index}]": colour for index, colour in enumerate(self.palette or ["nothing"])}
        for name, colour in given.items():
            if not re.fullmatch(r"#[0-9A-Fa-f]{6}", colour):
                raise ConfigError(f"recorder.{name} is {colour!r}; expected a colour as '#RRGGBB'.")

    def colour(self, name: str, alpha: int = 255) -> tuple[int, int, int, int]:
        """Colour `name` as red, green, blue, alpha, each 0 … 255."""
        return _rgba(self.colours[name], alpha)

    def series(self, index: int, alpha: int = 255) -> tuple[int, int, int, int]:
        """Colour of the line with this number, from the palette over and over."""
        return _rgba(self.palette[index % len(self.palette)], alpha)

    def command(self, index: int) -> tuple[int, int, int, int]:
        """Colour of the command with this number: the first has its own, others the palette's that have no role."""
        taken = {self.colours[name].upper() for name in COLOURS}
        free = [colour for colour in self.palette if colour.upper() not in taken]
        colours = [self.colours["command"], *free]
        return _rgba(colours[index % len(colours)], alpha=255)


def _rgba(colour: str, alpha: int) -> tuple[int, int, int, int]:
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue, alpha

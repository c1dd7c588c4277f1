"""Trajectories from an MCAP file of episodes, as `train` and `evaluate` write them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import torch
from torch import Tensor

from dr_lab.bounds import at_least, require_bounds
from dr_lab.errors import DataError
from dr_lab.experts.expert import Demonstrations, Expert, require_enough
from dr_lab.measurements.mcap import McapSource

_SEEN, _DONE = "/observation", "/action"


class McapExpert(Expert):
    """The episodes of ``episodes.mcap``: ``/<episode>/observation`` and ``/<episode>/action``, in the order of names.

    Any program may write such a file: one message of ``std_msgs/msg/Float64MultiArray`` before the first control step
    and one after each for the observation, one for each action.

    Args:
        path: the file.
        episodes: how many are taken, the first; None takes all.

    Raises:
        ConfigError: the number is below 1.
    """

    def __init__(self, path: str, episodes: Annotated[int | None, at_least(1)]) -> None:
        self.path, self.episodes = path, episodes
        require_bounds(self, "expert", McapExpert)

    def demonstrations(self) -> Demonstrations:
        """Read them."""
        path = Path(self.path).expanduser()
        if not path.is_file():
            raise DataError(
                f"There is no file {path}. Make one with dr-lab evaluate run=FOLDER evaluator=demonstrations, and give "
                "the episodes.mcap of its folder."
            )
        source = McapSource(path)
        names = [topic.removesuffix(_SEEN) for topic in source.topics if topic.endswith(_SEEN)]
        if not names:
            raise DataError(
                f"{path} holds no episodes: none of its topics ends in {_SEEN} ({', '.join(source.topics)}). Give an "
                "episodes.mcap that dr-lab train or dr-lab evaluate has written."
            )
        require_enough(len(names), self.episodes, str(path))
        chosen = sorted(names, key=_natural)[: self.episodes]
        courses = {name: _course(source, name, path) for name in chosen}
        _require_alike(courses, path)
        return Demonstrations.of(list(courses.values()))


def _course(source: McapSource, name: str, path: Path) -> tuple[Tensor, Tensor]:
    seen, done = (torch.from_numpy(source.rows(name + topic).copy()) for topic in (_SEEN, _DONE))
    if len(seen) != len(done) + 1:
        raise DataError(
            f"{name} of {path} has {len(seen)} observations and {len(done)} actions; expected one observation more, "
            "that after the last action."
        )
    if not (seen.isfinite().all() and done.isfinite().all()):
        raise DataError(f"{name} of {path} holds NaN or infinite numbers. Leave it out, or play the expert again.")
    return seen, done


def _require_alike(courses: Mapping[str, tuple[Tensor, Tensor]], path: Path) -> None:
    """Check that all episodes are of one task: as many numbers seen and done in each."""
    by_widths: dict[tuple[int, int], str] = {}
    for name, (seen, done) in courses.items():
        by_widths.setdefault((seen.shape[1], done.shape[1]), name)
    if len(by_widths) > 1:
        found = "; ".join(f"{name} sees {seen} numbers and does {done}" for (seen, done), name in by_widths.items())
        raise DataError(f"The episodes of {path} are of several tasks: {found}. Give a file of one env alone.")


def _natural(name: str) -> tuple[str, int]:
    """So that episode_10 comes after episode_9."""
    stem = name.rstrip("0123456789")
    return stem, int(name[len(stem) :] or 0)

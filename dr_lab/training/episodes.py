"""Episodes of a trained policy that its run shows and keeps: in 3-D in ``review.rrd``, in full in ``episodes.mcap``."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dr_lab.collectors.collector import Policy
from dr_lab.envs.environment import Environment
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.episodes_mcap import write_episodes
from dr_lab.reports.episode_entry import EpisodeEntry, ValueEntry
from dr_lab.seeding import derived_seed, stream
from dr_lab.training.recorded import record

FILE = "episodes.mcap"


def play_episodes(
    environment: Environment, policy: Policy, source: ContextSource | None, count: int, seed: int, threads: int | None
) -> list[Episode]:
    """Play a policy in contexts drawn from a distribution, one episode in each.

    Args:
        environment: what is played.
        policy: what acts.
        source: p(z); None for the nominal context.
        count: number of episodes; 0 gives none.
        seed: of contexts and starts.
        threads: C threads of the physics; None takes every core.
    """
    if count == 0:
        return []
    streams = [stream(seed, "shown", episode) for episode in range(count)]
    z = (
        np.tile(environment.space.nominal, (count, 1))
        if source is None
        else source.propose(streams, np.arange(count)).z
    )
    starts = derived_seed(seed, "shown")
    return record(environment, environment.make(None, count, starts, threads).episodes, policy, z)


def keep_episodes(run_dir: Path, environment: Environment, episodes: Sequence[Episode]) -> None:
    """Write ``episodes.mcap`` with the nominal scene and the run's configuration in it, if there are episodes."""
    if not episodes:
        return
    attachments = {"model.xml": environment.scene_xml().encode()}
    config = run_dir / "config.yaml"
    if config.is_file():
        attachments[config.name] = config.read_bytes()
    metadata = {"schema": "dr_lab/episodes/1", "env": environment.name, "run": str(run_dir)}
    write_episodes(run_dir / FILE, episodes, attachments, metadata)


def described(episodes: Sequence[Episode]) -> tuple[EpisodeEntry, ...]:
    """What `report.json` says of them."""
    return tuple(
        EpisodeEntry(
            name=episode.name,
            undiscounted=episode.undiscounted,
            seconds=float(episode.time[-1]),
            ended=episode.ended,
            context={name: ValueEntry(value, unit) for name, (value, unit) in episode.context.items()},
        )
        for episode in episodes
    )

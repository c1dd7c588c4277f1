"""A search of readings: the robot, its gyroscopes and the logs' series, tried by the equation of motion."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import mujoco

from dr_lab.proposal.against import beyond, of_command, too_fast
from dr_lab.proposal.drives import Drive, drives_of, integrates
from dr_lab.proposal.grid import Grid, grid_of, held_of, integral_of, path_of
from dr_lab.proposal.gyros import gyros_of
from dr_lab.proposal.per_control import per_control
from dr_lab.proposal.search import Options, search
from dr_lab.proposal.searched import Searched
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.settled import all_rests
from dr_lab.proposal.survey import Series
from dr_lab.proposal.trial import Trial
from dr_lab.proposal.weight import shown_by_weight


@dataclass(frozen=True)
class Tries:
    """What readings are tried with.

    Attributes:
        model: compiled, without contacts and limits.
        worn: by the name of a gyroscope, which series is which of its axes.
        settings: thresholds.
    """

    model: mujoco.MjModel
    worn: Mapping[str, Mapping[int, Series]]
    settings: ProposalSettings

    def search(
        self,
        candidates: Sequence[Series],
        asked: Sequence[Series],
        options: Sequence[Options],
        *,
        rates: Collection[int] = (),
    ) -> Searched:
        """The reading of the candidates, some of which are velocities, that fits best, with what may be commands."""
        model, settings = self.model, self.settings
        grid = grid_of([*candidates, *asked], settings)
        force, biased = per_control(model)
        drives = drives_of(model, force)
        rests = all_rests(candidates, asked, settings) if any(each.servo or each.added for each in drives) else {}
        trial = self._trial(grid, candidates, asked, drives, biased=biased, rates=rates)
        gyros = None if rates else gyros_of(trial, self.worn, settings)
        found = search(
            trial,
            options,
            lambda readings, outcome: (
                sum(of_command(drive, readings, outcome, asked, rests, settings) for drive in drives)
                + len(beyond(model, trial, readings))
                + too_fast(model, trial, readings, settings.contract.speed_limit)
            ),
            lambda readings, outcome: shown_by_weight(trial, readings, outcome, settings),
            settings,
            gyros,
        )
        return Searched(trial, found, tuple(asked), drives, gyros=gyros)

    def _trial(
        self,
        grid: Grid,
        candidates: Sequence[Series],
        asked: Sequence[Series],
        drives: Sequence[Drive],
        *,
        biased: bool,
        rates: Collection[int],
    ) -> Trial:
        model, settings = self.model, self.settings
        moved, rated = {drive.dof for drive in drives}, {drive.dof for drive in drives if drive.rate}
        rising = {drive.dof for drive in drives if not drive.added and integrates(model)[model.actuator(drive.name).id]}
        velocities = [k for k, each in enumerate(asked) if each.words.kind == "asked velocity"]
        return Trial(
            model=model,
            grid=grid,
            candidates=tuple(path_of(s, grid, settings.cutoff, rate=k in rates) for k, s in enumerate(candidates)),
            drives=tuple(tuple(held_of(each, grid, lag) for lag in settings.lags) for each in asked),
            lags=settings.lags,
            servos=tuple(model.nu == 0 and each.words.kind != "drive" for each in asked),
            driven=tuple(dof in moved for dof in range(model.nv)),
            biased=biased,
            rates=frozenset(rates),
            integrals=tuple(tuple(integral_of(each, grid, lag) for lag in settings.lags) for each in asked if rising),
            integrated=frozenset(rising),
            barred=frozenset((k, dof) for k in velocities for dof in range(model.nv) if dof not in rated),
        )

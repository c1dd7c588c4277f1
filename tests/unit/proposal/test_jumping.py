"""Series that hold and jump."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.proposal.jumping import jumps
from dr_lab.trajectory import Array

TIME = np.arange(0.0, 10.0, 0.02)
RNG = np.random.default_rng(0)
SERIES = {
    "one step": np.where(TIME > 1.0, 1.7, 0.0),
    "levels at random": np.repeat(RNG.uniform(-1.0, 1.0, 20), 25),
    "a staircase of ten": np.floor(TIME),
    "a joint that moves": np.sin(TIME),
    "an angle that wraps": np.mod(TIME, 1.0),
    "a coarse encoder": np.round(30 * np.sin(0.3 * TIME)) / 30,
    "nothing": np.zeros_like(TIME),
}


@pytest.mark.parametrize(("name", "told"), [(name, k < 3) for k, name in enumerate(SERIES)])
def test_only_what_holds_and_jumps_far_is_no_position(name: str, told: bool) -> None:
    assert _jumps(SERIES[name]) is told


def test_a_series_that_moves_in_one_log_is_a_position() -> None:
    assert not _jumps(SERIES["one step"], SERIES["a joint that moves"])
    assert _jumps(SERIES["one step"], SERIES["nothing"])


def _jumps(*logs: Array) -> bool:
    series = SimpleNamespace(signals=[SimpleNamespace(value=value) for value in logs])
    return jumps(cast(Any, series), instantiate(compose("init", ["robot=it", "logs=[it]"]).proposal))

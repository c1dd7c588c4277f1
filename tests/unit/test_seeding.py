"""Keyed random streams."""

import numpy as np
import pytest

from dr_lab.cli.arguments import checked
from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.errors import ConfigError
from dr_lab.seeding import stream


def test_a_stream_is_known_by_its_seed_and_keys() -> None:
    streams = (stream(1, "a"), stream(1, "b"), stream(2, "a"), stream(1, "a", 0), stream(1, "a"))
    draws = [generator.random(4) for generator in streams]
    np.testing.assert_array_equal(draws[0], draws[4])
    assert len({tuple(draw) for draw in draws}) == 4


def test_the_numbers_are_the_same_on_every_machine() -> None:
    assert stream(1, "truth", "arm.mass").random() == pytest.approx(0.8428831792628104)


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(ConfigError, match="at least 0"):
        stream(-1)


@pytest.mark.parametrize("verb", ["diagnose", "record", "train", "evaluate", "export"])
def test_a_negative_seed_is_refused_before_anything_is_built(verb: str) -> None:
    """Of a sweep no job begins then."""
    with pytest.raises(ConfigError, match=r"^seed is -1; expected at least 0\.$"):
        checked(verb, compose(verb, ["seed=-1"]), (shipped(),))

"""Bounds of numbers stand where a class declares them, and are told by the key that holds the number."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import lt
from typing import Annotated, Any

import pytest

from dr_lab.bounds import (
    FINITE,
    ORDERED,
    Confidence,
    Count,
    Positive,
    above,
    at_least,
    at_most,
    below,
    numbers,
    places,
    require_bounds,
)
from dr_lab.errors import ConfigError


@dataclass(frozen=True)
class Spring:
    stiffness: Positive = 1.0
    share: Annotated[float, at_least(0.0), at_most(1.0)] = 0.5
    length: Annotated[float, above(0.0), below(math.inf)] = 1.0
    coils: Count = 3
    limit: Annotated[float | None, above(0.0)] = None
    confidence: Confidence = 0.9
    free: float = -1.0
    ends: Annotated[Sequence[float] | None, numbers(2, at_least(0.0), FINITE)] = None
    limits: Annotated[Sequence[float] | None, numbers(None, above(0.0))] = None
    span: Annotated[Sequence[float] | None, ORDERED] = None
    corners: Annotated[Sequence[Sequence[float]] | None, places(lt, "from low to high")] = None

    def __post_init__(self) -> None:
        require_bounds(self, "bed.spring")


@dataclass(frozen=True)
class DampedSpring(Spring):
    damping: Positive = 1.0


class Motor:
    def __init__(self, torque: Positive) -> None:
        self.torque = torque
        require_bounds(self, "", Motor)


class GearedMotor(Motor):
    def __init__(self, ratio: Positive, **motor: float) -> None:
        super().__init__(**motor)
        self.ratio = ratio
        require_bounds(self, "gear", GearedMotor)


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        ("stiffness", 0.0, "is 0; expected a number above 0."),
        ("stiffness", math.nan, "is nan; expected a number above 0."),
        ("share", -0.5, "is -0.5; expected at least 0."),
        ("share", 1.5, "is 1.5; expected at most 1."),
        ("length", math.inf, "is inf; expected a number below inf."),
        ("coils", 0, "is 0; expected at least 1."),
        ("limit", 0.0, "is 0; expected a number above 0."),
        ("confidence", 95.0, "is 95; expected a share between 0 and 1, such as 0.95."),
        ("damping", 0.0, "is 0; expected a number above 0."),
        ("stiffness", math.inf, "is inf; expected a finite number."),
        ("ends", [1.0], "is [1.0]; expected 2 finite numbers, each at least 0."),
        ("ends", [1.0, -1.0], "is [1.0, -1.0]; expected 2 finite numbers, each at least 0."),
        ("ends", [1.0, math.inf], "is [1.0, inf]; expected 2 finite numbers, each at least 0."),
        ("limits", [1.0, 0.0, 2.0], "is [1.0, 0.0, 2.0]; expected numbers, each a number above 0."),
        ("span", [2.0, 1.0], "is [2.0, 1.0]; expected [lowest, highest], lowest < highest."),
        ("span", [2.0], "is [2.0]; expected [lowest, highest], lowest < highest."),
        ("span", [math.nan, 1.0], "is [nan, 1.0]; expected [lowest, highest], lowest < highest."),
        ("corners", [[0.0, 1.0]], "is [[0.0, 1.0]]; expected [[x, y], [x, y]], from low to high."),
        ("corners", [[0, 1], [1, 0]], "is [[0, 1], [1, 0]]; expected [[x, y], [x, y]], from low to high."),
        ("corners", [[0, 1], [1]], "is [[0, 1], [1]]; expected [[x, y], [x, y]], from low to high."),
    ],
)
def test_a_number_out_of_bounds_is_told_by_its_key(name: str, value: Any, fault: str) -> None:  # noqa: ANN401
    with pytest.raises(ConfigError) as told:
        DampedSpring(**{name: value})
    assert str(told.value) == f"bed.spring.{name} {fault}"


def test_what_lies_on_a_bound_is_within_it_and_none_is_no_number() -> None:
    assert DampedSpring(share=0.0, limit=None).share == 0.0
    assert DampedSpring(share=1.0, limit=2.0).share == 1.0
    assert DampedSpring(limit=math.inf, limits=[math.inf], span=[-math.inf, math.inf], ends=(0.0, 1.0)).limits
    assert DampedSpring(corners=[[0, 1], [1, 2]]).corners


def test_a_class_with_an_init_of_its_own_and_one_that_builds_on_it() -> None:
    assert GearedMotor(2.0, torque=1.0).ratio == 2.0
    with pytest.raises(ConfigError, match=r"^torque is 0; expected a number above 0\."):
        GearedMotor(2.0, torque=0.0)
    with pytest.raises(ConfigError, match=r"^gear\.ratio is -1; expected a number above 0\."):
        GearedMotor(-1.0, torque=1.0)

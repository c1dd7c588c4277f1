import doctest
import math

import pytest

from dr_lab.reports import quantity
from dr_lab.reports.quantity import number, percent, uncertain


def test_examples_of_the_docstrings() -> None:
    result = doctest.testmod(quantity)
    assert result.attempted >= 5
    assert result.failed == 0


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (1.0, 0.0, "1 s"),
        (1.23456, None, "1.235 s"),
        (None, 1.0, "– s"),
        (0.0, 0.02, "0.000 ± 0.020 s"),
        (123456.0, 1200.0, "(1.235 ± 0.012)e5 s"),
        (98.6, 12.0, "99 ± 12 s"),
        (-3.2e-7, 4e-9, "(-3.200 ± 0.040)e-7 s"),
        (0.1, 0.0996, "0.10 ± 0.10 s"),
    ],
)
def test_value_with_its_deviation(value: float | None, std: float | None, text: str) -> None:
    assert uncertain(value, std, "s") == text


def test_missing_numbers_are_a_dash() -> None:
    assert number(math.nan) == number(math.inf) == number(None) == percent(None) == "–"


def test_a_share_of_zero_is_no_decimal() -> None:
    assert [percent(share) for share in (0.0, -0.0001, 0.0004, 0.0006, 0.1, -0.05)] == [
        "0 %", "0 %", "0 %", "0.1 %", "10 %", "-5.0 %"
    ]  # fmt: skip


def test_shares_out_of_reason_are_only_said_to_be_that() -> None:
    assert [percent(share) for share in (10.0, 10.01, 365.68, 1e300, -10.0, -10.01, -125462821.61)] == [
        "1000 %", "above 1000 %", "above 1000 %", "above 1000 %", "-1000 %", "below -1000 %", "below -1000 %"
    ]  # fmt: skip

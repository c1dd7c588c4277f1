from types import SimpleNamespace
from typing import Any, cast

import pytest

from dr_lab.diagnosis.search.shortlist import shortlist

# Sites and numbers of parameters of candidates in the order of their promise.
SHOULDER_FIRST = [("shoulder", 1), ("shoulder", 2), ("shoulder", 3), ("shoulder", 1), ("shoulder", 1), ("elbow", 1)]

RICH_FIRST = [("axis", 5), ("axis", 3), ("axis", 1), ("world", 1), ("motor", 1)]


def of(candidates: list[tuple[str, int]]) -> list[Any]:
    return [SimpleNamespace(site=site, parameters=range(count)) for site, count in candidates]


@pytest.mark.parametrize(
    ("candidates", "most", "fitted"),
    [
        pytest.param(SHOULDER_FIRST, 4, [0, 1, 5, 3], id="the other joint's first comes before the third of one"),
        pytest.param(RICH_FIRST, 4, [0, 1, 2, 3], id="richer kinds do not take the simple one's turn"),
        pytest.param([("a", 2), ("a", 2), ("a", 3), ("a", 1)], 2, [0, 3], id="a simple one has its place"),
        pytest.param([("a", 2), ("b", 2), ("c", 2)], 2, [0, 1], id="without simple ones promise alone decides"),
        pytest.param(SHOULDER_FIRST, 9, [0, 1, 2, 3, 4, 5], id="all where there is room"),
        pytest.param([], 4, [], id="nothing promises anything"),
    ],
)
def test_half_are_the_most_promising_and_half_are_simple(
    candidates: list[tuple[str, int]], most: int, fitted: list[int]
) -> None:
    found = shortlist(range(len(candidates)), cast(Any, of(candidates)), most)
    assert found[: len(fitted)] == fitted
    assert len(found) == min(most, len(candidates))

"""Type hints in words."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import pytest

from dr_lab.cli.expected import expected

SAID = {
    "a whole number or null": int | None,
    "{name: [a number, …], …} or null": Mapping[str, Sequence[float]] | None,
    "[{name: anything, …}, …]": list[dict[str, Any]],
    "{name: {name: a number or a text, …}, …}": Mapping[str, Mapping[str, float | str]],
    "'tanh' or 'relu'": Literal["tanh", "relu"],
    "[anything, …]": list,
    "{name: anything, …}": dict,
    "true or false": bool,
}


@pytest.mark.parametrize("words", SAID)
def test_words_of_a_type_hint(words: str) -> None:
    assert expected(SAID[words]) == words

"""Comparing takes a part of the locked libraries, in the very versions of the whole."""

import tomllib

from locks import COMPARING, EVERYTHING, ROOT, names, pins
from packaging.requirements import Requirement

from dr_lab.extras import EXTRAS

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def required(requirements: list[str]) -> set[str]:
    return {Requirement(each).name for each in requirements}


def test_the_small_lock_is_part_of_the_large_one() -> None:
    assert pins(COMPARING) < pins(EVERYTHING)


def test_the_locks_hold_what_is_asked_for() -> None:
    training = required(PROJECT["optional-dependencies"]["train"])
    assert required(PROJECT["dependencies"]) <= names(COMPARING)
    assert training <= names(EVERYTHING) - names(COMPARING)


def test_a_missing_library_of_training_is_known_as_such() -> None:
    assert {module for module, extra in EXTRAS.items() if extra == "train"} == required(
        PROJECT["optional-dependencies"]["train"]
    )
    assert set(EXTRAS.values()) <= set(PROJECT["optional-dependencies"])

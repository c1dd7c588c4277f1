"""What is printed to be typed again is read as what it was."""

import shlex
from pathlib import Path

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser

from dr_lab.reports.typed import add_formula_command, typed, view_command


def read(words: str) -> dict[str, object]:
    """What shell and Hydra make of overrides."""
    overrides = OverridesParser.create().parse_overrides(shlex.split(words))
    return {override.key_or_group: override.value() for override in overrides}


@pytest.mark.parametrize(
    "value",
    ["a=1,b(2)", "/data/arm [left]/x", " a", "a ", "it's", "17", "-1", "1e3", "1_0", "nan", "null", "True", "é"],
)
def test_a_value_is_read_as_the_text_that_it_is(value: str) -> None:
    assert read(typed("run", value)) == {"run": value}


@pytest.mark.parametrize("value", ["arm", "17/2", "2024-01-01", Path("/tmp/a_b.rrd")])
def test_a_value_without_signs_is_shown_plainly(value: Path | str) -> None:
    assert typed("run", value) == f"run={value}"


def test_a_run_and_a_joint_may_be_called_by_a_number() -> None:
    assert read(view_command(Path("17")).removeprefix("dr-lab view ")) == {"run": "17"}
    told = add_formula_command("17", "1", "2024").removeprefix("dr-lab add ")
    expected = {"effect": "formula", "model": "from_run", "model.run": "17", "measurements": "2024"}
    assert read(told) == expected | {"effect.joint": "1", "effect.run": "17"}


def test_the_users_own_folders_of_configuration_are_typed_again(tmp_path: Path) -> None:
    made = "# dr-lab close --config-dir 'my own' model=arm measurements=arm\n"
    (tmp_path / "config.yaml").write_text(made, encoding="utf-8")
    told = add_formula_command(tmp_path, "elbow", "arm")
    assert shlex.split(told)[:5] == ["dr-lab", "add", "--config-dir", "my own", "effect=formula"]

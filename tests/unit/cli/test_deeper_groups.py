"""A group that stands below others is told by its spelling, where it is given as if it were a verb's own."""

from pathlib import Path

import pytest
from cli_machine import CommandLine, write


def test_group_below_others_is_named_with_what_brings_it(
    dr_lab: CommandLine, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    swing = "_target_: parts.Machine\nname: swing\nmjcf: none\nparameters: {}\n"
    write(tmp_path / "conf/model/paved.yaml", f"defaults: [/floor@ground.floor: tiled, _self_]\n{swing}")
    write(tmp_path / "conf/floor/tiled.yaml", "defaults: [/stone@stone: slate]\n")
    write(tmp_path / "conf/stone/slate.yaml", "{}\n")
    for group, package in (("floor", "ground.floor"), ("stone", "ground.floor.stone")):
        assert dr_lab("compare", f"{group}=tiled") == 2
        told = f" Of that name below other groups: {group}@model.{package}=… (with model=paved).\n"
        assert told in capsys.readouterr().err
    assert dr_lab("compare", "flor=tiled") == 2
    assert "below other groups" not in capsys.readouterr().err

"""Files and code of the user's own: what is told where one is not found, or goes wrong."""

import sys
from pathlib import Path

import pytest
from cli_machine import CommandLine, module, write

Capture = pytest.CaptureFixture[str]
SHED = "_target_: parts.Machine\nname: shed\nmjcf: ${conf:model/shed.xml}\nparameters: {}\n"


def test_a_run_with_files_of_ones_own_is_repeated_as_its_first_lines_say(
    dr_lab: CommandLine, capsys: Capture, tmp_path: Path
) -> None:
    write(tmp_path / "here/mine/model/shed.yaml", SHED)
    write(tmp_path / "here/mine/model/shed.xml", "<mujoco/>")
    assert dr_lab("compare", "--config-dir", "mine", "model=shed", "hydra.run.dir=first") == 0
    typed, again, *_ = Path("first/config.yaml").read_text().splitlines()
    assert typed == "# dr-lab compare --config-dir mine model=shed"
    assert again.startswith("# Again: dr-lab ")
    words = again.removeprefix("# Again: dr-lab ").replace("FOLDER_OF_THIS_FILE", "first").split()
    assert dr_lab(*words, "hydra.run.dir=second") == 0
    assert [call["model"].name for call in dr_lab.calls] == ["shed", "shed"]
    assert "FOLDER_OF_THIS_FILE --config-dir mine --config-name" in Path("second/config.yaml").read_text()
    capsys.readouterr()
    assert dr_lab("compare", "--config-dir", "first", "--config-name", "config") == 2
    assert "One lies in mine: add --config-dir mine, beside other ones." in capsys.readouterr().err


def test_a_module_that_is_not_found_is_told_with_where_python_looks(
    dr_lab: CommandLine, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DR_LAB_TRUST", "parts,mislaid")
    assert dr_lab("compare", "model._target_=mislaid.Machine") == 2
    assert "PYTHONPATH=FOLDER DR_LAB_TRUST=mislaid dr-lab …" in capsys.readouterr().err
    assert dr_lab("compare", "model._target_=parts.nowhere.Machine") == 2
    assert "PYTHONPATH" not in capsys.readouterr().err


def test_an_error_of_the_users_code_is_no_fault_of_ours(
    dr_lab: CommandLine, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    theirs: dict[str, object] = {"__name__": "parts"}
    exec(compile("def reward(change):\n    return change[7]\n", "/mine/parts.py", "exec"), theirs)

    def compare(run_dir: Path, **everything: object) -> None:
        del run_dir, everything
        theirs["reward"]([1.0])  # pyright: ignore[reportCallIssue]

    name = "dr_lab.workflows.compare"
    monkeypatch.setitem(sys.modules, name, module(name, compare=compare))
    assert dr_lab("compare") == 2
    error = capsys.readouterr().err
    assert error.startswith("dr-lab compare: IndexError: list index out of range\nIt comes from code of yours: ")
    assert "/mine/parts.py, line 2. HYDRA_FULL_ERROR=1" in error

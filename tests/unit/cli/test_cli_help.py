"""What the help texts list, how fast they come, and tab completion in a real bash."""

import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cli_machine import CommandLine, write

from dr_lab import __version__
from dr_lab.cli.compose import compose, compose_outline
from dr_lab.cli.folders import shipped
from dr_lab.cli.verbs import verbs

Capture = pytest.CaptureFixture[str]
PROGRAM = Path(sys.executable).with_name("dr-lab")


@pytest.mark.parametrize("arguments", [(), ("--help",), ("-h",)])
def test_overview_lists_every_verb_with_its_line(dr_lab: CommandLine, capsys: Capture, arguments: tuple[str]) -> None:
    assert dr_lab(*arguments) == 0
    text = capsys.readouterr().out
    assert "  add      add one effect\n" in text
    assert "  compare  compare the two\n" in text


def test_version(dr_lab: CommandLine, capsys: Capture) -> None:
    assert dr_lab("--version") == 0
    assert capsys.readouterr().out == f"dr_lab {__version__}\n"


def test_every_shipped_verb_says_what_it_does() -> None:
    assert {"add", "close", "compare", "diagnose", "fit", "record", "view"} <= set(verbs())
    assert all(verbs().values())


def test_overview_takes_less_than_half_a_second() -> None:
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        subprocess.run([PROGRAM, "--help"], check=True, capture_output=True)
        seconds.append(time.perf_counter() - start)
    assert min(seconds) < 0.5


def test_reader_that_leaves_early_is_no_error() -> None:
    done = subprocess.run(
        ["bash", "-c", f"for n in 1 2 3; do {PROGRAM} --help | true; done"], check=True, capture_output=True, text=True
    )
    assert done.stderr == ""


def test_overview_imports_nothing_heavy() -> None:
    heavy = {"hydra", "mujoco", "numpy", "omegaconf", "rerun", "rich", "scipy"}
    code = "import sys; from dr_lab.__main__ import main; main([]); print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert heavy.isdisjoint(done.stderr.split())


def test_verb_help_lists_groups_options_and_keys(dr_lab: CommandLine, capsys: Capture) -> None:
    assert dr_lab("compare", "--help", "model=door") == 0
    lines = capsys.readouterr().out.splitlines()
    assert "  compare the two" in lines
    assert "  dr-lab compare model=swing" in lines
    assert "  model=door" in lines
    assert "      swing   a swing" in lines
    assert "  effect=all   several at once: effect=[a,b]" in lines
    assert "      rust  rust in the joint" in lines
    assert any(line.split() == ["horizon=0.5", "s,", "predicted", "open", "loop"] for line in lines)
    assert any(line.startswith("  threads=null") for line in lines)
    assert "Results: outputs/compare/<model>/<date_time>/" in lines
    assert dr_lab.calls == []


def test_help_of_a_whole_command_is_that_of_its_verb(dr_lab: CommandLine, capsys: Capture) -> None:
    assert dr_lab("compare", "--help") == 0
    alone = capsys.readouterr().out
    for beside in (["arm.xml", "logs/*.csv"], ["--config-name=config"]):
        assert dr_lab("compare", *beside, "--help") == 0
        assert capsys.readouterr().out == alone


def test_verb_help_lists_the_users_options(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    write(tmp_path / "mine/model/robot.yaml", "# my robot\nname: robot\n")
    assert dr_lab("compare", "--config-dir", str(tmp_path / "mine"), "--help") == 0
    assert "      robot   my robot" in capsys.readouterr().out.splitlines()


def test_verb_help_shows_the_keys_of_a_group_without_alternatives(
    dr_lab: CommandLine, capsys: Capture, tmp_path: Path
) -> None:
    write(tmp_path / "conf/fit.yaml", "# fit\ndefaults: [{base: run}, {solver: default}]")
    write(tmp_path / "conf/solver/default.yaml", "_target_: parts.Machine\ntolerance:\n  cost: 0.1  # share\n")
    assert dr_lab("fit", "--help", "solver.tolerance.cost=0.2") == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["solver=default"] in lines
    assert ["solver.tolerance.cost=0.2", "share"] in lines


def test_help_shows_the_keys_that_an_option_puts_at_the_top(
    dr_lab: CommandLine, capsys: Capture, tmp_path: Path
) -> None:
    write(tmp_path / "conf/fit.yaml", "# fit\ndefaults: [{base: run}, {source: here}]")
    write(tmp_path / "conf/source/here.yaml", "# @package _global_\nlength: 2  # m\nunsaid: 3\n")
    write(tmp_path / "conf/source/there.yaml", "# @package _global_\nwidth: 2  # m\n")
    assert dr_lab("fit", "--help") == 0
    out = capsys.readouterr().out
    assert ["length=2", "m"] in [line.split() for line in out.splitlines()]
    assert "unsaid" not in out
    assert "width=" not in out


def test_help_shows_the_sections_of_a_group_without_alternatives(
    dr_lab: CommandLine, capsys: Capture, tmp_path: Path
) -> None:
    write(tmp_path / "conf/fit.yaml", "# fit\ndefaults: [{base: run}, {comparison: default}]")
    sections = "solver:\n  damping: 0.1\n  steps: 3  # at most\nhanded:\n  steps: ${solver.steps}\n"
    write(tmp_path / "conf/comparison/default.yaml", f"# @package _global_\n{sections}")
    assert dr_lab("fit", "--help", "solver.steps=4") == 0
    out = capsys.readouterr().out
    lines = [line.split() for line in out.splitlines()]
    assert ["comparison=default"] in lines
    assert ["solver.damping=0.1"] in lines
    assert ["solver.steps=4", "at", "most"] in lines
    assert "handed.steps" not in out


def test_help_leaves_out_keys_that_only_hand_on_another(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    keys = (
        "pace: 31  # steps\nplan:\n  pace: ${pace}\n  model: ${model}\n  label: ${pace}_steps\nrest: ${pace}  # steps\n"
    )
    write(tmp_path / "conf/fit.yaml", f"# fit\ndefaults: [{{base: run}}, {{model: swing}}, _self_]\n{keys}")
    assert dr_lab("fit", "--help") == 0
    out = capsys.readouterr().out
    shown = [line.split() for line in out.splitlines()]
    assert [words for words in shown if any("31" in word for word in words)] == [
        ["pace=31", "steps"],
        ["plan.label=31_steps"],
        ["rest=31", "steps"],
    ]
    assert "plan.model" not in out
    assert dr_lab("fit", "--help", "plan.pace=4") == 0
    assert ["plan.pace=4"] in [line.split() for line in capsys.readouterr().out.splitlines()]


def test_help_ends_a_description_with_its_sentence(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    said = {"a": "as by (Mozifian et al. 2020, §V). Slow.", "b": "after Yu et al. PPO's twin", "c": "1.5 times. Fast."}
    for name, text in said.items():
        write(tmp_path / f"conf/effect/{name}.yaml", f"# @package effects.{name}\n# {text}\n")
    assert dr_lab("compare", "--help") == 0
    lines = capsys.readouterr().out.splitlines()
    assert {"      a     as by (Mozifian et al. 2020, §V)", "      b     after Yu et al. PPO's twin"} <= set(lines)
    assert "      c     1.5 times" in lines


def test_help_of_a_verb_whose_group_needs_a_choice(dr_lab: CommandLine, capsys: Capture) -> None:
    assert dr_lab("add", "--help") == 0
    out = capsys.readouterr().out
    assert "  effect=???   several" in out
    assert "  effect.joint=null" in out


def test_help_knows_the_keys_of_what_all_stands_for(dr_lab: CommandLine, capsys: Capture, tmp_path: Path) -> None:
    assert dr_lab("compare", "--help") == 0
    plain = capsys.readouterr().out
    assert dr_lab("compare", "--help", "effects.rust.name=moss") == 0
    assert capsys.readouterr().out == plain
    assert dr_lab("compare", "--help", "effects.rust.colour=red") == 2
    assert "effects.rust.colour" in capsys.readouterr().err
    own = "label: ${effects.wind.name}  # of the wind\n"
    write(tmp_path / "conf/fit.yaml", f"# fit\ndefaults: [{{base: run}}, {{effect: all}}, _self_]\n{own}")
    assert dr_lab("fit", "--help") == 0
    lines = capsys.readouterr().out.splitlines()
    assert ["label=wind", "of", "the", "wind"] in [line.split() for line in lines]
    assert "  effect=all   several at once: effect=[a,b]" in lines


def test_verb_help_imports_nothing_heavy_but_hydra() -> None:
    heavy = {"mujoco", "numpy", "rerun", "rich", "scipy", "typeguard"}
    code = (
        "import sys; from dr_lab.__main__ import main; main(['close', '--help']); print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert heavy.isdisjoint(done.stderr.split())


def test_an_outline_holds_nothing_of_what_all_stands_for() -> None:
    outline = compose_outline("close", ["seed=3"], (shipped(),))
    assert outline.seed == 3
    assert "effects" not in outline
    assert len(compose("close").effects) > 40  # composing has not been changed by it


COMPLETIONS = {
    "comp": ["compare"],
    "": ["add", "compare"],
    "compare mod": ["model."],
    "compare model=": ["model=broken", "model=door", "model=swing"],
    "compare model=d": ["model=door"],
    "compare effect=r": ["effect=rust"],
    "compare model=door hor": ["horizon="],
}


@pytest.mark.parametrize("typed", COMPLETIONS)
def test_completion(dr_lab: CommandLine, capsys: Capture, monkeypatch: pytest.MonkeyPatch, typed: str) -> None:
    monkeypatch.setenv("COMP_LINE", f"dr-lab {typed}")
    assert dr_lab("-sc", "query=bash") == 0
    words = capsys.readouterr().out.split()
    assert set(COMPLETIONS[typed]) <= set(words)
    assert all(word.startswith(typed.rsplit(" ", maxsplit=1)[-1]) for word in words)


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("--config-dir ~/mine model=r", ["model=robot"]),
        ("--config-dir=~/mine model=r", ["model=robot"]),
        ("--config-dir ~/beside -cd ~/mine model=r", ["model=robot"]),
        ("--config-dir nowhere model=d", ["model=door"]),
        ("--config-dir ", []),  # the shell completes files where nothing is offered
    ],
)
def test_completion_knows_the_users_folders(
    dr_lab: CommandLine,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    typed: str,
    offered: list[str],
) -> None:
    write(tmp_path / "mine/model/robot.yaml", "name: robot\n")
    (tmp_path / "beside").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("COMP_LINE", f"dr-lab compare {typed}")
    assert dr_lab("-sc", "query=bash") == 0
    assert capsys.readouterr().out.split() == offered


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
@pytest.mark.parametrize(
    "install", ["dr-lab -sc install=bash", pytest.param("dr-lab compare -sc install=bash", marks=pytest.mark.slow)]
)
def test_completion_in_bash(install: str) -> None:
    script = f"""
        PATH={PROGRAM.parent}:$PATH
        eval "$({install})"
        COMP_LINE="dr-lab compare model=qub" COMP_POINT=99 COMP_CWORD=2
        hydra_bash_completion
        echo "${{COMPREPLY[@]}}"
        complete -p dr-lab
    """
    done = subprocess.run(["bash", "-c", script], check=True, capture_output=True, text=True)
    replies, rule = done.stdout.splitlines()
    assert replies == "model=qube"
    assert "-F hydra_bash_completion" in rule

"""Only a run of the same verb, with the same settings, is gone on with."""

import shlex
from pathlib import Path

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import OmegaConf

from dr_lab.cli import job as jobs
from dr_lab.cli.job import Job, run_job
from dr_lab.cli.resuming import require_same_settings
from dr_lab.errors import ConfigError, DataError


def test_a_run_of_another_verb_is_told_as_such_and_not_by_its_settings(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("# dr-lab close model=robot\nmodel: {name: robot}\n")
    with pytest.raises(ConfigError, match=r"is a run of dr-lab close\. Give resume=FOLDER of a run of dr-lab train"):
        require_same_settings(OmegaConf.create({"frames": 1}), tmp_path, "train", ("frames",))
    require_same_settings(OmegaConf.create({"model": {"name": "robot"}}), tmp_path, "close", ())


def test_the_command_that_goes_on_with_other_settings_can_be_typed(tmp_path: Path) -> None:
    run = tmp_path / "my run (1), again"
    run.mkdir()
    (run / "config.yaml").write_text("# dr-lab train --config-dir 'my own'\nframes: 1\nseed: 0\n")
    with pytest.raises(ConfigError, match="is a run with other settings: seed is 1, there 0") as refused:
        require_same_settings(OmegaConf.create({"frames": 1, "seed": 1}), run, "train", ("frames",))
    command = str(refused.value).partition("recorded configuration: ")[2].partition(". Or start")[0]
    *words, resume = shlex.split(command)
    assert words == ["dr-lab", "train", "--config-dir", str(run), "--config-dir", "my own", "--config-name", "config"]
    assert OverridesParser.create().parse_override(resume).value() == str(run)


@pytest.mark.parametrize("left", [False, True])
def test_a_run_that_is_refused_leaves_a_folder_only_if_it_wrote_something(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], left: bool
) -> None:
    earlier, taken = tmp_path / "close" / "run", tmp_path / "close" / "run_2"
    taken.mkdir(parents=True)
    (taken / "config.yaml").touch()

    def refused(resume: str, run_dir: Path) -> None:
        del resume
        if left:
            (run_dir / "report.json").touch()
        raise DataError("A log changed.")

    monkeypatch.setattr(jobs, "build", lambda *_: (refused, {"resume": str(earlier), "run_dir": taken}))
    with pytest.raises(DataError, match=r"A log changed\."):
        run_job(Job("close", (), None, earlier, ()), OmegaConf.create({"outputs": str(tmp_path)}))
    assert taken.exists() == taken.parent.exists() == left
    assert "run holds the run that is gone on with; this one goes to" in capsys.readouterr().out

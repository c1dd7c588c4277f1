"""The same command goes on with its sweep: nothing twice, nothing lost, and nothing begun that cannot be run."""

import errno
import json
import os
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest
from filelock import FileLock
from hydra.core.plugins import Plugins
from hydra.core.utils import JobReturn
from hydra.plugins.launcher import Launcher
from probe_sweeps import Sweeps, completed, table

from dr_lab.__main__ import main
from dr_lab.errors import ConfigError
from dr_lab.sweeps.job_folder import LOCK_FILE, write_status
from dr_lab.sweeps.sweep import SweepJob, add_jobs, read_jobs

Sweep = Callable[..., int]


def report(folder: Path) -> dict[str, float]:
    return json.loads((folder / "report.json").read_text(encoding="utf-8"))


def test_the_same_command_finds_its_sweep_and_more_values_join(
    sweep: Sweep, sweeps: Sweeps, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sweeps.here(monkeypatch, "value=2.0,1,2.00", "size=3") == 0
    [swept] = Path("outputs/multirun/probe").iterdir()
    done = completed(swept)
    assert set(done) == {"0", "1"}  # 2.0 and 2.00 are the same
    capsys.readouterr()
    assert sweeps.here(monkeypatch, "size=3", "value=2.0,1,2.00") == 0
    assert "Nothing was left to do" in capsys.readouterr().out
    assert sweep("value=0,1,2.0", "size=3", "outputs=elsewhere", f"hydra.sweep.dir={swept}") == 0
    assert [(row["folder"], row["value"]) for row in table(swept)] == [("0", "2.0"), ("1", "1"), ("2", "0")]
    assert {number: completed(swept)[number] for number in done} == done


def test_no_job_writes_over_the_logs_of_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["record", "-m", "plant=furuta", "seed=1,2", "output=logs"]) == 2
    assert "output is 'logs' in 2 jobs, which would write over one another" in capsys.readouterr().err
    assert list(tmp_path.rglob("*.mcap")) == []


def test_other_files_of_the_same_name_make_other_jobs(sweep: Sweep, sweeps: Sweeps) -> None:
    """A model of another folder, or one that was edited since, is not what was completed."""
    for folder in ("one", "two"):
        (sweeps.home / folder).mkdir()
        (sweeps.home / folder / "a machine.xml").write_text(folder)
    done = []
    for folder, edited in [("one", ""), ("two", ""), ("one", ""), ("one", "more")]:
        if edited:
            (sweeps.home / folder / "a machine.xml").write_text(edited)
        assert sweep("--config-dir", folder, "value=1", "trouble=${conf:a machine.xml}") == 0
        done.append(len(completed(sweeps.home / "swept")))
    assert done == [1, 2, 2, 3]


@pytest.mark.slow
@pytest.mark.parametrize("place", ["hydra.sweep.dir={}/swept", "outputs={} hydra.sweep.dir='${{outputs}}/swept'"])
@pytest.mark.parametrize("folder", ["beside/../there", "link/there", "link/../there", "{home}/link/../there"])
def test_a_sweep_lies_where_the_system_finds_its_folder(
    sweeps: Sweeps, monkeypatch: pytest.MonkeyPatch, place: str, folder: str
) -> None:
    """Behind a link, ".." is not the folder before it."""
    (sweeps.home / "beside").mkdir()
    (sweeps.home / "far/away").mkdir(parents=True)
    (sweeps.home / "link").symlink_to("far/away")
    given = folder.format(home=sweeps.home)
    expected = (sweeps.home / given).resolve() / "swept"
    for _ in range(2):
        assert sweeps.here(monkeypatch, "value=1,2", *place.format(given).split()) == 0
    assert set(completed(expected)) == {"0", "1"}
    assert len(list(sweeps.home.rglob("report.json"))) == 2


def test_failed_job_alone_runs_again_and_goes_on_where_it_was(
    sweep: Sweep, sweeps: Sweeps, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    swept = tmp_path / "swept"
    (sweeps.trouble / "fails_2").touch()
    assert sweep("value=1,2,3") == 2
    told = capsys.readouterr().err
    assert "Not completed: 1 failed, of 3 in all.\n  job 1 (value=2): 2 is refused.\n    swept/1/error.txt\n" in told
    assert "Traceback" in (swept / "1/error.txt").read_text(encoding="utf-8")
    row = table(swept)[1]
    assert (row["status"], row["error"], row["log"]) == ("failed", "2 is refused.", "1/error.txt")
    done = completed(swept)
    for at, path in enumerate(sorted(swept.rglob("*"))):  # clocks jump: what is done is read, not dated
        os.utime(path, (at % 2 * 4e9, at % 2 * 4e9))
    (sweeps.trouble / "fails_2").unlink()
    assert sweep("value=1,2,3") == 0
    assert {number: completed(swept)[number] for number in done} == done
    assert [report(swept / number)["begun_at_step"] for number in "012"] == [0, 2, 0]
    assert {path.name for path in (swept / "1").iterdir()} == {path.name for path in (swept / "0").iterdir()}
    assert "resume: null" in (swept / "1/config.yaml").read_text(encoding="utf-8")


@pytest.mark.slow
def test_fail_fast_and_a_job_that_starts_over(sweep: Sweep, sweeps: Sweeps, tmp_path: Path) -> None:
    arguments = ("value=1,2", "hydra.sweeper.fail_fast=true", "hydra.sweep.subdir=at/${hydra.job.override_dirname}")
    first = tmp_path / "swept/at/value=1"
    (sweeps.trouble / "fails_1").touch()
    assert sweep(*arguments) == 2
    assert [row["status"] for row in table(tmp_path / "swept")] == ["failed", "waiting"]
    (first / "steps.txt").rename(first / "half_written.txt")  # nothing to go on with
    (sweeps.trouble / "fails_1").unlink()
    assert sweep(*arguments) == 0
    assert [row["folder"] for row in table(tmp_path / "swept")] == ["at/value=1", "at/value=2"]
    assert report(first)["begun_at_step"] == 0
    assert not (first / "half_written.txt").exists()


def test_nothing_begins_where_one_job_cannot_be_run(
    sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sweep("value=1,two,three,???,'${nowhere}',{_target_: os.system}") == 2
    told = capsys.readouterr().err
    assert "5 of 6 jobs cannot be run, so none was begun:\n" in told
    assert "\n  value=two: value is 'two'; expected a number.\n" in told
    assert "No value for value. Give one: dr-lab probe value=…" in told
    assert "Interpolation key 'nowhere' not found" in told
    assert "outside the trusted packages" in told
    assert sweep("size=4,-5", "value=1,two") == 2
    told = capsys.readouterr().err
    assert "3 of 4 jobs cannot be run, so none was begun:\n" in told
    assert "\n  size=-5 value=1: size is -5; expected at least 0.\n" in told
    assert sweep("value=1", "+valu=3") == 2
    assert "There is no key 'valu' in dr-lab probe. Did you mean 'value'?" in capsys.readouterr().err
    assert sweep("valu=1,2") == 2
    assert "Did you mean 'value'?" in capsys.readouterr().err
    assert not (tmp_path / "swept").exists()


def test_null_is_a_value_like_others(sweep: Sweep, tmp_path: Path) -> None:
    (tmp_path / "earlier").mkdir()
    (tmp_path / "earlier" / "steps.txt").write_text("2", encoding="utf-8")
    assert sweep("resume=null,earlier") == 0
    assert [report(tmp_path / "swept" / job)["begun_at_step"] for job in "01"] == [0, 2]


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        ("value=range(3,3)", "value=range(3,3) holds no value"),
        ("base=glob(nothing*)", "holds no value"),
        ("hydra.sweep.dir=", "hydra.sweep.dir is empty"),
        ("value=interval(0,1)", "value=interval(0,1) leaves the value to a search: hydra/sweeper=study"),
    ],
)
def test_sweeps_without_a_job_are_refused(
    typed: str, message: str, sweep: Sweep, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sweep(typed) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "swept").exists()


@pytest.mark.parametrize(
    ("folders", "message"),
    [
        (("same", "same"), "would be the folder of jobs 0 and 1"),
        ((".",), "puts job 0 into '.', outside of"),
        (("a/b", "a"), "a/b would be the folder of job 0 and lie in that of job 1"),
        (("a", "c", "a/b/"), "a/b would be the folder of job 2 and lie in that of job 0"),
        (("a", "./a"), "would be the folder of jobs 0 and 1"),
        (("../0",), "puts job 0 into '../0', outside of"),
        (("mine",), "holds something that is not of this sweep"),
    ],
)
def test_folders_of_jobs_are_their_own(folders: tuple[str, ...], message: str, tmp_path: Path) -> None:
    (tmp_path / "swept/mine").mkdir(parents=True)
    (tmp_path / "swept/mine/notes.txt").touch()
    jobs = [SweepJob(n, str(n), folder, ()) for n, folder in enumerate(folders)]
    with pytest.raises(ConfigError, match=message):
        add_jobs(tmp_path / "swept", "probe", "resume", jobs)
    assert read_jobs(tmp_path / "swept") == []


def test_waits_for_a_process_that_outlived_its_sweep(sweep: Sweep, sweeps: Sweeps, tmp_path: Path) -> None:
    job = tmp_path / "swept/0"
    (sweeps.trouble / "fails_1").touch()
    assert sweep("value=1") == 2
    begun = threading.Event()

    def outlived() -> None:
        with FileLock(job / LOCK_FILE):
            write_status(job, "running")
            begun.set()
            time.sleep(0.5)
            write_status(job, "completed", seconds=5.0)

    process = threading.Thread(target=outlived)  # in a thread of its own: the lock is not one's own there either
    process.start()
    begun.wait()
    assert sweep("value=1") == 0
    process.join()
    assert json.loads((job / "status.json").read_text(encoding="utf-8"))["seconds"] == 5.0
    assert not (job / "report.json").exists()


def test_jobs_that_die_again_do_not_keep_others_from_their_turn(
    sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a pool of processes that a job takes down with it, one job at a time."""
    # Hydra loads its plugins anew, so the class that it uses is not the one that an import finds.
    launcher = Plugins.instance().class_name_to_class["hydra._internal.core_plugins.basic_launcher.BasicLauncher"]
    assert issubclass(launcher, Launcher)
    launch, handed = launcher.launch, []

    def pool(self: Launcher, batch: Sequence[Sequence[str]], initial_job_idx: int) -> Sequence[JobReturn]:
        for value, *rest in batch:
            handed.append(value)
            if value in ("value=1", "value=2"):
                folder = tmp_path / "swept" / rest[-1].partition("=")[2].strip("'")
                folder.mkdir(parents=True, exist_ok=True)
                write_status(folder, "running")
                raise BrokenProcessPool
            launch(self, [[value, *rest]], initial_job_idx=initial_job_idx)
        return []

    monkeypatch.setattr(launcher, "launch", pool)
    assert sweep("value=1,2") == 2
    handed.clear()
    assert sweep("value=1,2,3") == 2
    assert handed == ["value=3", "value=1", "value=2"]
    assert [row["status"] for row in table(tmp_path / "swept")] == ["unfinished", "unfinished", "completed"]


@pytest.mark.slow
def test_why_a_job_could_not_begin(
    sweep: Sweep, sweeps: Sweeps, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (sweeps.trouble / "fails_2").touch()
    assert sweep("value=1,2") == 2
    capsys.readouterr()

    def refuse(*given: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", "old.txt")

    with monkeypatch.context() as patched:  # where its folder is put in order
        patched.setattr("dr_lab.cli.sweep_job.clear", refuse)
        assert sweep("value=3") == 2
    assert "1 failed, of 1 in all.\n  job 2 (value=3): old.txt: Permission denied" in capsys.readouterr().err
    with monkeypatch.context() as patched:  # before its folder can say so
        patched.setattr("dr_lab.cli.sweep_job.watched", refuse)
        assert sweep("value=2") == 2
    told = capsys.readouterr().err
    assert "1 failed, of 1 in all.\n  job 1 (value=2): PermissionError: [Errno 13] Permission denied: 'old.txt'" in told
    assert "2 is refused" not in told


def test_a_job_that_is_lost_meanwhile_is_told(
    sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sweep("value=1") == 0
    lost = tmp_path / "swept/0/status.json"
    monkeypatch.setattr("dr_lab.cli.sweep_job.clear", lambda folder: lost.unlink())
    assert sweep("value=1,2") == 2
    assert "Not completed: 1 not begun, of 2 in all." in capsys.readouterr().err


def test_a_sweep_of_before_goes_on(sweep: Sweep, tmp_path: Path) -> None:
    assert sweep("value=1") == 0
    path = tmp_path / "swept/sweep.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content.pop("sweeper") == "resume"
    path.write_text(json.dumps(content), encoding="utf-8")
    assert sweep("value=1,2") == 0
    assert [row["status"] for row in table(tmp_path / "swept")] == ["completed"] * 2


def test_other_sweepers_are_refused(sweep: Sweep, capsys: pytest.CaptureFixture[str]) -> None:
    assert sweep("value=1", "hydra/sweeper=basic") == 2
    assert "hydra/sweeper=resume" in capsys.readouterr().err

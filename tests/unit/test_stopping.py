"""Ctrl-C and SIGTERM end a run whatever was made of the exception that they raised."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from dr_lab.stopping import Terminated, signals_unwind, stop_if_asked, until_ctrl_c

PROGRAM = """
import os, signal, sys, types
if {ignored}:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
def view(run, outputs, web, page_port, data_port):
    {body}
module = types.ModuleType("dr_lab.workflows.view")
module.view = view
sys.modules["dr_lab.workflows.view"] = module
sys.argv = ["dr-lab", "view"]
from dr_lab.__main__ import main
sys.exit(main())
"""
PRESS = "os.kill(os.getpid(), signal.{sent})"
DROPPED = "\n    try: " + PRESS + "\n    except BaseException: pass"
REPLACED = "\n    try: " + PRESS + "\n    finally: raise AttributeError('half made')"


def run(folder: Path, body: str, *, ignored: bool = False) -> tuple[int, str]:
    code = PROGRAM.format(body=body, ignored=ignored)
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr.strip()


@pytest.mark.parametrize("body", [PRESS, DROPPED, REPLACED], ids=["raised", "dropped", "replaced"])
@pytest.mark.parametrize(("sent", "code", "told"), [("SIGINT", 130, "interrupted"), ("SIGTERM", 143, "terminated")])
def test_one_line_and_its_code(tmp_path: Path, body: str, sent: str, code: int, told: str) -> None:
    assert run(tmp_path, body.format(sent=sent)) == (code, f"dr-lab: {told}.")


def test_what_a_shell_ignores_stays_ignored(tmp_path: Path) -> None:
    assert run(tmp_path, PRESS.format(sent="SIGINT"), ignored=True) == (0, "")


@pytest.mark.parametrize(("sent", "raised"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)])
def test_a_dropped_signal_is_raised_where_the_next_part_begins(
    sent: signal.Signals, raised: type[BaseException]
) -> None:
    def work() -> None:
        with signals_unwind():
            with contextlib.suppress(raised):
                os.kill(os.getpid(), sent)
            stop_if_asked()
            pytest.fail("the next part began")

    before = signal.getsignal(sent)
    with pytest.raises(raised):
        work()
    assert signal.getsignal(sent) is before
    stop_if_asked()  # nothing is left of it for the next run


def test_work_goes_on_after_a_block_that_ctrl_c_is_meant_to_end() -> None:
    with signals_unwind():
        with until_ctrl_c():
            os.kill(os.getpid(), signal.SIGINT)
            pytest.fail("the block went on")
        stop_if_asked()

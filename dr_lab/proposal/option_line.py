"""Which line of the written MJCF to change for a time step that does not show."""

import re

import mujoco

from dr_lab.physics.model import Model
from dr_lab.proposal.pages import model_xml
from dr_lab.proposal.propose import Proposal

_OPTION = re.compile(r"<option\b[^>]*?(?=\s*/?>)")
_BY_ITSELF = "Where you leave it, close does so by itself, as the other verbs do, and says so."
_TOP = re.compile(r"<mujoco\b[^>]*>")


def in_mjcf(proposal: Proposal, finer: Model) -> str:
    """What to write where in the MJCF that ``init`` writes, and what happens without that.

    Args:
        proposal: what is written.
        finer: a model with the step and integrator that are wanted.
    """
    option, was = finer.spec.option, proposal.spec.option
    wanted = {} if option.timestep == was.timestep else {"timestep": f"{option.timestep:g}"}
    if option.integrator != was.integrator:
        wanted["integrator"] = mujoco.mjtIntegrator(option.integrator).name.removeprefix("mjINT_")
    text, file = model_xml(proposal), f"model/{proposal.robot.name}.xml"
    keys = " ".join(f'{key}="{value}"' for key, value in wanted.items())
    found = _OPTION.search(_without_comments(text))
    if found is None:
        top = _TOP.search(_without_comments(text))
        return f"In {file}, add <option {keys}/> below line {_line(text, top.end() if top else 0)}. {_BY_ITSELF}"
    element = found.group()
    for key, value in wanted.items():
        element = re.sub(rf'\s{key}\s*=\s*("[^"]*"|\'[^\']*\')', "", element) + f' {key}="{value}"'
    end = "/>" if text[found.end() :].lstrip().startswith("/") else ">"
    return f"In {file}, line {_line(text, found.start())}, write {' '.join(element.split())}{end}. {_BY_ITSELF}"


def _without_comments(text: str) -> str:
    """The text with blanks in place of comments, so that places stay."""
    return re.sub(r"<!--.*?-->", lambda each: re.sub(r"[^\n]", " ", each.group()), text, flags=re.DOTALL)


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1

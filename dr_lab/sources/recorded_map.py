"""The configuration that reads recorded logs back: which topic is what, and which logs are held out."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from dr_lab.channel_names import POSITION, VELOCITY
from dr_lab.plants.instruments import Instruments

_NAME = "recorded"
_LOGS_PER_HELD_OUT = 3


@dataclass(frozen=True)
class RecordedMap:
    """A ``measurements`` configuration for logs that lie beside it, log_1, log_2 and so on.

    Attributes:
        model: name of the recorded model.
        count: number of logs; the last third is held out.
        slides: whether it is a slide, by recorded joint.
        actuators: names of the driven actuators.
    """

    model: str
    count: int
    slides: Mapping[str, bool]
    actuators: tuple[str, ...]

    @property
    def file(self) -> str:
        """Path beside the logs."""
        return f"measurements/{_NAME}.yaml"

    def text(self, joint_topic: str, command_topic: str, instruments: Instruments) -> str:
        """The yaml; latencies are known of the bench, noise is estimated."""
        names = [f"log_{index + 1}" for index in range(self.count)]
        fitted = self.count - self.count // _LOGS_PER_HELD_OUT
        measured = {POSITION: ""} | ({} if instruments.velocity is None else {VELOCITY: "/s"})
        content: dict[str, Any] = {
            "defaults": [{"/data_contract@contract": "default"}, "_self_"],
            "_target_": "dr_lab.measurements.read.read",
            "name": _NAME,
            "logs": [f"${{conf:{name}.mcap}}" for name in names],
            "fit": names[:fitted],
            "held_out": names[fitted:],
            "clock": "header",
            "outputs": {
                f"{joint}.{what}": {
                    "topic": joint_topic,
                    "field": f"{what}[{joint}]",
                    "unit": f"{'m' if slide else 'rad'}{each}",
                    "latency": instruments.transport_latency,
                }
                for what, each in measured.items()
                for joint, slide in self.slides.items()
            },
            "commands": {
                actuator: {
                    "topic": f"{command_topic}/{actuator}",
                    "field": "data[0]",
                    "unit": "1",  # a model does not say its commands' units
                    "clock": "log",
                    "latency": -instruments.actuation_latency,
                }
                for actuator in self.actuators
            },
        }
        header = (
            "# logs of a simulated machine\n"
            "#\n"
            f"# dr-lab compare --config-dir FOLDER_OF_THE_LOGS model={self.model} measurements={_NAME}\n"
        )
        return header + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=120)

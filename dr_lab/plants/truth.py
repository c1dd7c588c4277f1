"""What the plant knows and the diagnosis must not: the truth behind a set of logs, as plain data."""

from dataclasses import asdict

from dr_lab.plants.rig import Rig


def truth(bench: Rig, seed: int) -> dict[str, object]:
    """True parameters, hidden effect and clock of the machine that a seed stands for.

    Returns:
        ``seed``; ``parameters`` by the model's names (SI units); ``hidden`` with its label ``name@site`` and its
        magnitudes; ``clock`` of the robot (offset s, drift s/s, epoch s); ``latency`` of transport and actuation in s.
    """
    clock = bench.clock(seed)
    return {
        "seed": seed,
        "parameters": bench.nominal.true_values(seed),
        "hidden": {"effect": bench.hidden.label, "parameters": bench.hidden.parameters},
        "clock": asdict(clock),
        "latency": {
            "transport": bench.instruments.transport_latency,
            "actuation": bench.instruments.actuation_latency,
        },
    }

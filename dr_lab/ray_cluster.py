"""Whether a Ray cluster listens where one is looked for."""

import socket

from dr_lab.errors import ConfigError

HERE = "local"
KNOWN = (HERE, "auto")  # words of Ray's own


def require_cluster(key: str, address: str, patience: float) -> None:
    """Refuse an address at which nothing listens: Ray itself would keep trying for minutes, and say nothing.

    Args:
        key: of the configuration, that holds the address.
        address: ``local``, ``auto``, which Ray looks for itself, or host:port.
        patience: for an answer [s].

    Raises:
        ConfigError: it is no address, or nothing listens there.
    """
    if address in KNOWN:
        return
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise ConfigError(f"{key} is {address}; expected local, auto or host:port, as 192.168.0.1:6379.")
    try:
        socket.create_connection((host.removeprefix("ray://"), int(port)), patience).close()
    except OSError as error:
        raise ConfigError(
            f"No Ray cluster answers at {key}={address} ({error}). Start one, ray start --head --port={port}, or set "
            f"{key}={HERE}, which starts Ray on this machine."
        ) from error

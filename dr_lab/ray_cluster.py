"""What joining or starting a Ray cluster needs beside Ray: does it listen, who is let in, who answers SIGTERM?"""

import os
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from dr_lab.errors import ConfigError

HERE = "local"
KNOWN = (HERE, "auto")  # words of Ray's own
AUTH_MODE, TOKEN, TOKEN_PATH = "RAY_AUTH_MODE", "RAY_AUTH_TOKEN", "RAY_AUTH_TOKEN_PATH"


def prepare(key: str, address: str, patience: float) -> None:
    """Get this process ready for `ray.init`; whoever has no token of the cluster is then refused, on either side.

    Args:
        key: of the configuration, that holds the address.
        address: ``local``, where a token is made for this process and its children alone, ``auto``, the cluster that
            the environment variable RAY_ADDRESS names or else one of this machine, or host:port.
        patience: for an answer [s].

    Raises:
        ConfigError: it is no address, or nothing listens there; Ray itself would keep trying for minutes.
    """
    sought = os.environ.get("RAY_ADDRESS", address) if address == "auto" else address
    if sought not in KNOWN:
        _require_listener(key, str(sought), patience)
    if address != HERE:
        os.environ.setdefault(AUTH_MODE, "token")  # of itself Ray talks to any cluster that lets it in
    elif TOKEN_PATH not in os.environ:
        os.environ.setdefault(TOKEN, os.urandom(32).hex())  # Ray's own would be left in the home folder


@contextmanager
def own_sigterm() -> Iterator[None]:
    """Keep this process's answer to SIGTERM, which Ray replaces by an abort when it begins."""
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        # Only the main thread has answers, here and in Ray; one that Python did not install it cannot install again.
        if before is not None and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, before)


def _require_listener(key: str, address: str, patience: float) -> None:
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise ConfigError(f"{key} is {address}; expected local, auto or host:port, as 192.168.0.1:6379.")
    try:
        socket.create_connection((host.removeprefix("ray://").strip("[]"), int(port)), patience).close()
    except OSError as error:
        raise unanswered(key, address, error) from error


def unanswered(key: str, address: str, error: Exception) -> ConfigError:
    """What is said of a cluster that cannot be joined."""
    return ConfigError(
        f"No Ray cluster at {key}={address} lets this process in: {error} Start one (ray start --head), say where its "
        f"token lies ({TOKEN_PATH}), or set {key}={HERE}, which starts Ray on this machine."
    )

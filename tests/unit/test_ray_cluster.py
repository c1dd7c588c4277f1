"""Where a Ray cluster may be looked for."""

import socket

import pytest

from dr_lab.errors import ConfigError
from dr_lab.ray_cluster import require_cluster


def test_words_of_ray_and_what_listens_pass() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]
        for address in ("local", "auto", f"127.0.0.1:{port}", f"ray://127.0.0.1:{port}"):
            require_cluster("collector.address", address, 10.0)


def test_where_nothing_listens_is_told_at_once() -> None:
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(ConfigError, match=rf"No Ray cluster answers at collector\.address={address} .*ray start"):
            require_cluster("collector.address", address, 10.0)


@pytest.mark.parametrize("address", ["head", "head:", ":6379", "head:port", "127.0.0.1:99999"])
def test_what_is_no_address_is_told(address: str) -> None:
    with pytest.raises(ConfigError, match=rf"key is {address}; expected local, auto or host:port"):
        require_cluster("key", address, 10.0)

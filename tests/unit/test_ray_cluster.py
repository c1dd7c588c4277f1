"""Where a Ray cluster may be looked for."""

import os
import signal
import socket

import pytest

from dr_lab.errors import ConfigError
from dr_lab.ray_cluster import AUTH_MODE, TOKEN, TOKEN_PATH, own_sigterm, prepare


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """None of Ray's own, and none is left behind."""
    for name in (AUTH_MODE, TOKEN, TOKEN_PATH, "RAY_ADDRESS"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)


def test_a_ray_of_this_machine_has_a_token_of_its_own() -> None:
    prepare("key", "local", 10.0)
    assert len(os.environ[TOKEN]) == 64
    assert AUTH_MODE not in os.environ


def test_a_given_token_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN_PATH, "there")
    prepare("key", "local", 10.0)
    assert TOKEN not in os.environ


def test_a_cluster_is_asked_for_a_token() -> None:
    prepare("key", "auto", 10.0)
    assert os.environ[AUTH_MODE] == "token"


def test_words_of_ray_and_what_listens_pass() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]
        for address in ("local", "auto", f"127.0.0.1:{port}", f"ray://127.0.0.1:{port}"):
            prepare("collector.address", address, 10.0)


def test_where_nothing_listens_is_told_at_once() -> None:
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(ConfigError, match=rf"No Ray cluster at collector\.address={address} .*refused.*ray start"):
            prepare("collector.address", address, 10.0)


def test_the_cluster_of_the_environment_is_looked_for_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RAY_ADDRESS", "127.0.0.1:1")
    with pytest.raises(ConfigError, match="refused"):
        prepare("key", "auto", 10.0)
    prepare("key", "local", 10.0)


@pytest.mark.parametrize("address", ["head", "head:", ":6379", "head:port", "127.0.0.1:99999"])
def test_what_is_no_address_is_told(address: str) -> None:
    with pytest.raises(ConfigError, match=rf"key is {address}; expected local, auto or host:port"):
        prepare("key", address, 10.0)


def test_sigterm_is_answered_as_before() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with own_sigterm():
        signal.signal(signal.SIGTERM, signal.SIG_DFL if before is not signal.SIG_DFL else signal.SIG_IGN)
    assert signal.getsignal(signal.SIGTERM) is before

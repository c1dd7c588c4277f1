"""Ports of the viewer."""

import socket

import pytest

from dr_lab.errors import ConfigError
from dr_lab.recorders.rerun_process import LOCAL, free_port


@pytest.mark.parametrize("wanted", [99999, -1])
def test_a_port_that_does_not_exist_is_one_clear_error(wanted: int) -> None:
    with pytest.raises(ConfigError, match=rf"no port {wanted}; give page_port and data_port up to 65535"):
        free_port(wanted)


def test_a_taken_port_is_replaced() -> None:
    with socket.socket() as taken:
        taken.bind((LOCAL, 0))
        taken.listen()
        wanted = taken.getsockname()[1]
        assert free_port(wanted) not in (0, wanted)

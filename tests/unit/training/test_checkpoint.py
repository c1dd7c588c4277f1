"""Checkpoints are whole or refused."""

from pathlib import Path

import numpy as np
import pytest
import torch

from dr_lab.errors import DataError
from dr_lab.training.checkpoint import load, not_finite, save


def test_checkpoints_hold_arrays_and_refuse_code(tmp_path: Path) -> None:
    state = {
        "rng": np.random.default_rng(0).bit_generator.state,
        "array": np.eye(2),
        "empty": np.empty((3, 0)),
        "flags": np.ones(2, bool),
        "n": [1, 2.5, None, "a"],
    }
    save(tmp_path / "c.pt", state)
    read = load(tmp_path / "c.pt")
    assert read["rng"] == state["rng"]
    for name in ("array", "empty", "flags"):
        np.testing.assert_array_equal(read[name], state[name])
    torch.save({"code": print}, tmp_path / "evil.pt")
    with pytest.raises(DataError, match="Cannot read the checkpoint"):
        load(tmp_path / "evil.pt")
    with pytest.raises(DataError, match="Cannot read the checkpoint"):
        load(tmp_path / "missing.pt")


def test_whatever_is_damaged_is_refused(tmp_path: Path) -> None:
    path, rng = tmp_path / "c.pt", np.random.default_rng(0)
    state = {"weights": torch.arange(500.0), "moments": np.arange(300.0), "nested": {"n": [1, 2.5, None, "a"]}}
    save(path, state)
    whole = path.read_bytes()
    assert torch.equal(load(path)["weights"], state["weights"])
    damaged = [whole[: int(cut)] for cut in rng.integers(0, len(whole), 40)]
    middle = whole.index(np.float32(100.0).tobytes() + np.float32(101.0).tobytes())
    for place in [middle, *rng.integers(0, len(whole), 100).tolist()]:
        damaged.append(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
    refused = 0
    for each in damaged:
        path.write_bytes(each)
        try:
            read = load(path)
        except DataError:
            refused += 1
        else:  # a byte that means nothing, such as padding
            assert torch.equal(read["weights"], state["weights"])
            np.testing.assert_array_equal(read["moments"], state["moments"])
            assert read["nested"] == state["nested"]
    assert refused > 100
    path.write_bytes(damaged[40])
    with pytest.raises(DataError, match=r"it is damaged, .*checksum .* does not fit"):
        load(path)


def test_what_a_device_has_written_is_read_without_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.serialization, "location_tag", lambda storage: "cuda:0")
    save(tmp_path / "there.pt", {"weights": torch.arange(3.0)})
    monkeypatch.undo()
    assert torch.equal(load(tmp_path / "there.pt")["weights"], torch.arange(3.0))


def test_what_is_not_finite_is_found_however_deep_it_lies() -> None:
    """Algorithms of many policies list the states of their members."""
    lost, fine = torch.tensor([1.0, torch.nan]), torch.tensor([1.0])
    state = {"members": [{"weight": fine}, {"weight": lost}], "steps": [(fine, torch.tensor([True]), lost)], "n": 3}
    assert list(not_finite(state, "algorithm")) == ["algorithm.members.1.weight", "algorithm.steps.0.2"]

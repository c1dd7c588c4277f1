"""What is said where a library is missing."""

import sys

import pytest

from dr_lab.extras import CHECKOUT, MissingLibraryError, lacking


def test_an_installed_dr_lab_is_installed_with_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "prefix", "/usr")
    told = str(MissingLibraryError("train", "torch"))
    assert told == "train needs torch, which is not installed. Install it: pip install 'dr_lab[train]'"


def test_a_checkout_is_made_whole_by_its_makefile(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "prefix", str(CHECKOUT / ".venv"))
    assert f"make -C {CHECKOUT} install, on every machine" in str(MissingLibraryError("x", "ray", ", on every machine"))


def test_only_a_library_of_an_extra_is_one_that_may_be_missing() -> None:
    assert lacking(ModuleNotFoundError("no", name="torch")) == "torch"
    assert lacking(ModuleNotFoundError("no", name="torch.walk")) is None  # torch is there
    assert lacking(ModuleNotFoundError("no", name="dr_lab.workflows.walk")) is None
    assert lacking(ImportError("cannot import name 'x' from 'torch'", name="torch")) is None

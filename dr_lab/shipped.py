"""Where the configuration lies that comes with dr_lab."""

from pathlib import Path

from dr_lab.errors import ConfigError

PACKAGE = Path(__file__).resolve().parent


def shipped(package: Path = PACKAGE) -> Path:
    """The configuration that comes with dr_lab: inside the package when installed from a wheel, else the checkout's.

    Raises:
        ConfigError: neither exists (a broken installation).
    """
    candidates = (package / "conf", package.parent / "conf")
    for folder in candidates:
        if folder.is_dir():
            return folder
    looked = " and ".join(map(str, candidates))
    raise ConfigError(f"dr_lab's configuration is missing (looked at {looked}). Install dr_lab again.")

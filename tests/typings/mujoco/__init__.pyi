# The mujoco wheel ships no type information for its compiled modules.
from typing import Any

def __getattr__(name: str) -> Any: ...  # noqa: ANN401

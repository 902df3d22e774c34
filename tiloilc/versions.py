"""Which versions of other packages are known not to work."""

BROKEN_MUJOCO = (3, 12)
"""From here on (tried up to 4.0) the Fetch environments die with a bare AssertionError."""


def is_broken_mujoco(version: str) -> bool:
    """Whether this version of mujoco breaks the Fetch environments."""
    numbers = tuple(int(part) for part in version.split(".")[:2] if part.isdigit())
    return numbers >= BROKEN_MUJOCO

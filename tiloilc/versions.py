"""Which versions of other packages are known not to work."""

BROKEN_MUJOCO = (3, 12)
"""From here on (tried up to 4.0) the environments of Gymnasium-Robotics 1.4 die with a bare
AssertionError. Our own Fetch tasks take only its robot and do not."""


def is_broken_mujoco(version: str) -> bool:
    """Whether this version of mujoco breaks the environments of Gymnasium-Robotics."""
    numbers = tuple(int(part) for part in version.split(".")[:2] if part.isdigit())
    return numbers >= BROKEN_MUJOCO

"""Carlo's road and car in numbers, and how far a car can get at all."""

from __future__ import annotations

import math

SIZE = 60.0
"""Metres along a side of the map."""

MIDDLE = 30.0
"""The road goes round (MIDDLE, MIDDLE)."""

DISC, RING = 15.0, 27.5
"""Radius of the disc inside the road, and where the ring around it begins, m."""

CENTER_LINE = (DISC + RING) / 2
"""Radius of the centre line, m."""

REGIONS = ((MIDDLE + CENTER_LINE, MIDDLE), (MIDDLE - CENTER_LINE, MIDDLE))
REGION = 5.0
"""The two regions to be visited: the car's middle is less than REGION m from theirs."""

LENGTH, WIDTH = 4.0, 2.0
"""Of the car, m."""

AXLE = 2.0
"""From the middle of the car to either axle, m."""

FRICTION = 0.06
"""What the throttle loses, m/s²."""

MIN_SPEED, MAX_SPEED = 3.0, 30.0
"""m/s; only at the start a car stands still."""


def farthest(horizon: int, dt: float) -> tuple[float, int]:
    """Upper bounds that no car exceeds: radians about the middle, and rounds between the regions.

    A car that has not crashed is at least r = DISC + WIDTH/2 from the middle, so that a step of d
    metres takes it at most 2 asin(d/2r) about it; d is greatest at full throttle. Each region is
    seen from the middle under an angle of 2 asin(REGION/CENTER_LINE). A round leads to the first
    region, π/4 or more from the start, and then to the other one; which way, nothing says.
    """
    nearest, speed, turn = DISC + WIDTH / 2, 0.0, 0.0
    for _ in range(horizon):
        faster = min(max(speed + (1 - FRICTION) * dt, MIN_SPEED), MAX_SPEED)
        turn += 2 * math.asin(min(1.0, (speed + faster) / 2 * dt / (2 * nearest)))
        speed = faster
    half = math.asin(REGION / CENTER_LINE)
    legs = (turn - (math.pi / 4 - half)) / (math.pi - 2 * half)
    return turn, max(0, math.floor((legs + 1) / 2))

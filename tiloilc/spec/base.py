"""What all models of the task file share: closed frozen models, numbers as people write them."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict


class Model(BaseModel):
    """Frozen, closed: an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def to_number(value: object) -> object:
    """Numbers as people write them: `1/3`, `60_000`, `1e6`; whole ones become integers."""
    if isinstance(value, bool):
        return str(value).lower()  # else `true` would count as 1
    number = value
    if isinstance(value, str):
        text = value.replace("_", "").strip()
        try:
            number = float(Fraction(text)) if "/" in text else float(text)
        except (ValueError, ZeroDivisionError, OverflowError):
            return value
    return int(number) if isinstance(number, float) and number.is_integer() else number


Number = Annotated[float, BeforeValidator(to_number)]
Whole = Annotated[int, BeforeValidator(to_number)]

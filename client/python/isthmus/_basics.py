"""What the generated records are made of."""
from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional, Tuple

Triple = Tuple[float, float, float]


class Word(enum.IntEnum):
    """A word of the API; its number is the API's. One that is not known is read as UNSPECIFIED."""

    @classmethod
    def _missing_(cls, value: object) -> Optional[Word]:
        return cls(0) if isinstance(value, int) and value != 0 else None

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Box:
    """Axis-aligned; metres. `min` must not exceed `max` in any coordinate."""

    min: Triple
    max: Triple

"""Moments: nanoseconds since the Unix epoch, as the server has them, and datetimes.

One rule holds for all records: a moment `x_ns` is also `x`, a datetime in UTC (`Utc`). Arguments
called `x_ns` take either (`to_ns`).
"""
from __future__ import annotations

import datetime
from typing import Any, Optional, Type, Union, overload

from isthmus.errors import InvalidArgument

Moment = Union[int, datetime.datetime]
_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)


def to_ns(moment: Moment) -> int:
    """Of a datetime with a time zone the nanoseconds since the Unix epoch; these as they are.

    `InvalidArgument` for a datetime without a time zone, which is another moment elsewhere.
    """
    if not isinstance(moment, datetime.datetime):
        return int(moment)
    if moment.tzinfo is None:
        raise InvalidArgument(f"{moment} has no time zone: give it one, as in "
                              "datetime.now(timezone.utc)")
    return (moment - _EPOCH) // datetime.timedelta(microseconds=1) * 1000


def to_datetime(ns: int) -> Optional[datetime.datetime]:
    """In UTC, to the microsecond; None for 0, which stands for "never" and "not yet"."""
    return _EPOCH + datetime.timedelta(microseconds=ns // 1000) if ns else None


class Utc:
    """`x = Utc()` in a class: its attribute `x_ns` by `to_datetime`."""

    def __set_name__(self, owner: Type[Any], name: str) -> None:
        self._of = f"{name}_ns"
        self.__doc__ = f"`{self._of}` in UTC, to the microsecond; None for 0."

    @overload
    def __get__(self, record: None, owner: Type[Any]) -> Utc: ...

    @overload
    def __get__(self, record: object, owner: Type[Any]) -> Optional[datetime.datetime]: ...

    def __get__(self, record: Optional[object],
                owner: Type[Any]) -> Union[Utc, Optional[datetime.datetime]]:
        return self if record is None else to_datetime(getattr(record, self._of))

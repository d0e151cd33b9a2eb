"""Moments: nanoseconds since the Unix epoch, as the server has them, and datetimes.

One rule holds for all records: a moment `x_ns` is also `x`, a datetime in UTC (`Utc`). Arguments
called `x_ns` take either, and numpy's datetimes (`to_ns`).
"""
from __future__ import annotations

import datetime
import operator
from typing import Any, Optional, Type, Union, overload

import numpy as np

from isthmus._arguments import wrong
from isthmus.errors import InvalidArgument

Moment = Union[int, datetime.datetime, np.datetime64]
_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)


def to_ns(moment: Moment, what: str = "a moment") -> int:
    """Nanoseconds since the Unix epoch: of a datetime with a time zone, of a numpy.datetime64,
    which is UTC, or these as they are.

    `InvalidArgument`, which calls it `what`, for anything else, such as a datetime without a time
    zone, which is another moment elsewhere, and for what 64 bits of nanoseconds do not hold.
    """
    if isinstance(moment, datetime.datetime) and moment.tzinfo is None:
        raise InvalidArgument(f"{what}, {moment}, has no time zone: give it one, as in "
                              "datetime.now(timezone.utc)")
    ns = _ns_of(moment)
    if ns is None or not -1 << 63 <= ns < 1 << 63:
        raise wrong(what, "nanoseconds since 1970 (a whole number), a datetime with a time zone or "
                    "a numpy.datetime64, within 292 years of 1970", moment)
    return ns


def _ns_of(moment: Any) -> Optional[int]:
    """None for what is no moment."""
    if isinstance(moment, datetime.datetime):
        return (moment - _EPOCH) // datetime.timedelta(microseconds=1) * 1000
    if isinstance(moment, np.datetime64):
        ns = moment.astype("datetime64[ns]")  # Too many of them wrap round: the seconds say so.
        same = ns.astype("datetime64[s]") == moment.astype("datetime64[s]")
        return int(ns.astype(np.int64)) if same else None  # NaT is not the same as itself.
    if isinstance(moment, (float, np.floating)):  # Nanoseconds; a fraction tells of seconds.
        return int(moment) if float(moment).is_integer() else None
    try:
        return operator.index(moment)
    except TypeError:
        return None


def to_datetime(ns: int) -> Optional[datetime.datetime]:
    """In UTC, to the microsecond; None for 0, which stands for "never" and "not yet"."""
    return _EPOCH + datetime.timedelta(microseconds=to_ns(ns) // 1000) if ns else None


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

"""Moments: nanoseconds since the Unix epoch, as the server has them, and datetimes."""
from __future__ import annotations

import datetime
from typing import Optional, Union

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

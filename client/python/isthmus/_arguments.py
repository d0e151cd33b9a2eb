"""What callers give, checked before anything is sent. Private to the package.

All functions raise `InvalidArgument`, which names the argument and says what to give instead of it.
"""
from __future__ import annotations

import math
import operator
import reprlib
from typing import Any, Iterable, List, Tuple, Type, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from isthmus.errors import InvalidArgument

T = TypeVar("T")
N = TypeVar("N")


def wrong(what: str, wanted: str, given: object) -> InvalidArgument:
    """The error of an argument that is something else than was wanted."""
    return InvalidArgument(f"{what} is {wanted}, not {reprlib.repr(given)}")


def request(kind: Type[T], **fields: Any) -> T:
    """A message of the API with these fields."""
    try:
        return kind(**fields)
    except (TypeError, ValueError, OverflowError) as error:
        described: Any = kind
        for name, value in fields.items():
            try:
                kind(**{name: value})
            except (TypeError, ValueError, OverflowError):
                raise wrong(name, _wanted(described.DESCRIPTOR.fields_by_name[name]),
                            value) from None
        raise InvalidArgument(str(error)) from None


def _wanted(field: Any) -> str:
    """What a field of a message takes, in words."""
    words = {field.CPPTYPE_STRING: "text", field.CPPTYPE_BOOL: "True or False",
             field.CPPTYPE_DOUBLE: "a number", field.CPPTYPE_FLOAT: "a number",
             field.CPPTYPE_INT32: "a whole number of 32 bits",
             field.CPPTYPE_INT64: "a whole number of 64 bits",
             field.CPPTYPE_UINT32: "a whole number from 0 to 2^32 - 1",
             field.CPPTYPE_UINT64: "a whole number from 0 to 2^64 - 1"}
    one = words.get(field.cpp_type, field.type)
    return f"a list, each of it {one}" if field.label == field.LABEL_REPEATED else str(one)


def listed(what: str, given: Union[str, Iterable[N]]) -> List[Union[str, N]]:
    """A text is one name, not a list of its letters."""
    try:
        return [given] if isinstance(given, str) else list(given)
    except TypeError:
        raise wrong(what, "a name or a list of them", given) from None


def text(what: str, given: Any) -> str:
    """Text, not bytes; shows what was given by its type alone: it may be a secret."""
    if isinstance(given, str):
        return given
    raise InvalidArgument(f"{what} is text (str), not {type(given).__name__}")


def number(what: str, given: Any, least: float = -math.inf) -> float:
    """A number that is not NaN, `least` at least."""
    try:
        value = float(given)
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if value >= least and not isinstance(given, (str, bytes)):
        return value
    raise wrong(what, "a number" + (f" from {least:g}" if least > -math.inf else ""), given)


def whole(what: str, given: Any, least: int = 0) -> int:
    """A whole number, `least` at least."""
    try:
        value = operator.index(given)
    except TypeError:
        value = least - 1
    if value < least:
        raise wrong(what, f"a whole number from {least}", given)
    return value


def numbers(what: str, given: Any, shape: Tuple[int, ...], wanted: str) -> NDArray[np.float64]:
    """Numbers of that shape, where -1 stands for any length. They may be infinite, not NaN."""
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        values = np.full((), math.nan)
    fits = len(values.shape) == len(shape) and all(
        length in (-1, found) for length, found in zip(shape, values.shape))
    if not fits or np.isnan(values).any():
        raise wrong(what, wanted, given)
    return values


def word(what: str, kind: Any, given: Any) -> int:
    """The number of a word of the API such as isthmus.Tracking, given as one or by its name."""
    names = {one.name.lower().replace("_", "-"): int(one) for one in kind if one != 0}
    if isinstance(given, str):
        found = names.get(given.lower().replace("_", "-"))
    else:
        found = int(given) if isinstance(given, int) and given in (0, *names.values()) else None
    if found is None:
        raise wrong(what, " or ".join((", ".join(list(names)[:-1]), list(names)[-1])), given)
    return found

"""Errors of the client: one class for each of gRPC's codes.

`docs/api.md` says which call fails with which code. The message is the server's, a sentence for a
person. What is wrong before anything was sent is an `InvalidArgument` too.
"""
from __future__ import annotations

from typing import Dict, Optional, Tuple, Type

import grpc


class Error(Exception):
    """Any failure of a call. `code` is the gRPC code, `message` a sentence for a person."""

    code: grpc.StatusCode = grpc.StatusCode.UNKNOWN

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.message = message


class Cancelled(Error):
    """The call was ended before it was through, by either side."""

    code = grpc.StatusCode.CANCELLED


class Unknown(Error):
    """Something that has no code of its own."""


class InvalidArgument(Error, ValueError):
    """What was asked or sent cannot be right."""

    code = grpc.StatusCode.INVALID_ARGUMENT


class DeadlineExceeded(Error, TimeoutError):
    """It took longer than the caller was ready to wait."""

    code = grpc.StatusCode.DEADLINE_EXCEEDED


class NotFound(Error, LookupError):
    """No such robot, session, submap, component or revision."""

    code = grpc.StatusCode.NOT_FOUND


class AlreadyExists(Error):
    """Something else is there under that name."""

    code = grpc.StatusCode.ALREADY_EXISTS


class PermissionDenied(Error):
    """The caller may not do this."""

    code = grpc.StatusCode.PERMISSION_DENIED


class ResourceExhausted(Error):
    """Too large, a full disk, a robot above its quota, or a server with as many calls as it takes.

    `retry_after_s` is not None where the server said after how many seconds to come again: the
    client has waited so long and tried again then, for as long as it keeps trying.
    """

    code = grpc.StatusCode.RESOURCE_EXHAUSTED

    def __init__(self, message: str, retry_after_s: Optional[float] = None) -> None:
        super().__init__(message)
        self.retry_after_s = retry_after_s


class FailedPrecondition(Error):
    """Not in this state: a finished session, robots that nothing connects yet."""

    code = grpc.StatusCode.FAILED_PRECONDITION


class Aborted(Error):
    """The link was lost half way: it is not known whether the call took effect."""

    code = grpc.StatusCode.ABORTED


class OutOfRange(Error):
    """A gap in what was sent, or a revision that is no longer kept."""

    code = grpc.StatusCode.OUT_OF_RANGE


class Unimplemented(Error):
    """This server does not know the call."""

    code = grpc.StatusCode.UNIMPLEMENTED


class Internal(Error):
    """A bug, most likely the server's."""

    code = grpc.StatusCode.INTERNAL


class Unavailable(Error, ConnectionError):
    """No server answers, or it is not ready yet; try again later.

    `retry_after_s` is not None where a server answered, and said when to come again.
    """

    code = grpc.StatusCode.UNAVAILABLE

    def __init__(self, message: str, retry_after_s: Optional[float] = None) -> None:
        super().__init__(message)
        self.retry_after_s = retry_after_s


class DataLoss(Error):
    """What arrived is not what was sent."""

    code = grpc.StatusCode.DATA_LOSS


class Unauthenticated(Error):
    """Not sent by this version of the server."""

    code = grpc.StatusCode.UNAUTHENTICATED


_KINDS: Tuple[Type[Error], ...] = (
    Cancelled, Unknown, InvalidArgument, DeadlineExceeded, NotFound, AlreadyExists,
    PermissionDenied, ResourceExhausted, FailedPrecondition, Aborted, OutOfRange, Unimplemented,
    Internal, Unavailable, DataLoss, Unauthenticated)
_CLASSES: Dict[grpc.StatusCode, Type[Error]] = {kind.code: kind for kind in _KINDS}


LONGEST_WAIT_S = 60.0  # A server may say more; it is not waited for longer.


def asked_to_wait(error: BaseException) -> Optional[float]:
    """The seconds after which a server that refused a call for one of its limits wants it again;
    None for any other error."""
    return error.retry_after_s if isinstance(error, ResourceExhausted) else None


def too_large(error: Error) -> Error:
    """Of a message above the server's limit: what to do about it. Others pass."""
    if not isinstance(error, ResourceExhausted) or "larger than max" not in error.message:
        return error
    return ResourceExhausted(
        f"a scan is larger than the server takes: {error.message}; raise "
        "network.max_receive_bytes there, send fewer fields or points, or set `resolution`")


def _retry_after_s(error: grpc.RpcError) -> Optional[float]:
    for key, value in error.trailing_metadata() or ():
        if key == "retry-after-ms" and isinstance(value, str) and value.isdigit():
            return min(int(value) / 1000, LONGEST_WAIT_S)
    return None


def from_rpc(error: grpc.RpcError) -> Error:
    """The error of ours that a failed call of gRPC stands for."""
    if error.code() == grpc.StatusCode.RESOURCE_EXHAUSTED:
        return ResourceExhausted(error.details() or str(error.code()), _retry_after_s(error))
    if error.code() == grpc.StatusCode.UNAVAILABLE:
        return Unavailable(error.details() or str(error.code()), _retry_after_s(error))
    return _CLASSES.get(error.code(), Unknown)(error.details() or str(error.code()))

"""One channel out of several: to whichever server of a map has it. Private to the package."""
from __future__ import annotations

import threading
from typing import Any, Callable, Dict, List, Tuple

import grpc


def split_addresses(addresses: str) -> List[str]:
    """Those of "a:50051,b:50051"; one at least."""
    return [address.strip() for address in addresses.split(",")]


class Ways(grpc.Channel):  # type: ignore[misc]
    """Calls go over the channel to one address until that does not answer, then to the next.

    Thread safe.
    """

    def __init__(self, addresses: List[str], open_one: Callable[[str], grpc.Channel]) -> None:
        self._addresses, self._open = addresses, open_one
        self._lock = threading.Lock()
        self._at = 0
        self._closed = False
        self._channels: Dict[int, grpc.Channel] = {0: open_one(addresses[0])}

    def current(self) -> Tuple[int, grpc.Channel]:
        """Which one, and its channel."""
        with self._lock:
            if self._closed:
                raise ValueError("the channel was closed")  # As gRPC's own.
            if self._at not in self._channels:
                self._channels[self._at] = self._open(self._addresses[self._at])
            return self._at, self._channels[self._at]

    def leave(self, at: int) -> None:
        """Has later calls go to the address after that one, unless they went on already. Those
        under way stay where they are."""
        with self._lock:
            if at == self._at:
                self._at = (at + 1) % len(self._addresses)

    def close(self) -> None:
        with self._lock:
            self._closed = True
            for channel in self._channels.values():
                channel.close()

    def unary_unary(self, *method: Any, **options: Any) -> Any:
        return _Method(self, "unary_unary", method, options)

    def unary_stream(self, *method: Any, **options: Any) -> Any:
        return _Method(self, "unary_stream", method, options)

    def stream_unary(self, *method: Any, **options: Any) -> Any:
        return _Method(self, "stream_unary", method, options)

    def stream_stream(self, *method: Any, **options: Any) -> Any:
        return _Method(self, "stream_stream", method, options)

    def subscribe(self, callback: Any, try_to_connect: bool = False) -> None:
        self.current()[1].subscribe(callback, try_to_connect)

    def unsubscribe(self, callback: Any) -> None:
        self.current()[1].unsubscribe(callback)

    def __enter__(self) -> Ways:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


class _Method:
    """A method of the API, by the channel that is current when it is called."""

    def __init__(self, ways: Ways, kind: str, method: Any, options: Any) -> None:
        self._ways, self._kind = ways, kind
        self._method, self._options = method, options

    def __call__(self, *request: Any, **options: Any) -> Any:
        at, channel = self._ways.current()
        method = getattr(channel, self._kind)(*self._method, **self._options)
        try:
            answer = method(*request, **options)
        except grpc.RpcError as error:
            self._note(at, error)
            raise
        if not self._kind.endswith("_stream"):
            return answer
        return _Answers(answer, lambda error: self._note(at, error))

    def _note(self, at: int, error: Any) -> None:
        if error.code() == grpc.StatusCode.UNAVAILABLE:
            self._ways.leave(at)


class _Answers:
    """A call with a stream of answers, the failure of which is heard of."""

    def __init__(self, call: Any, on_error: Callable[[Any], None]) -> None:
        self._call, self._on_error = call, on_error

    def __iter__(self) -> _Answers:
        return self

    def __next__(self) -> Any:
        try:
            return next(self._call)
        except grpc.RpcError as error:
            self._on_error(error)
            raise

    def __getattr__(self, name: str) -> Any:
        return getattr(self._call, name)

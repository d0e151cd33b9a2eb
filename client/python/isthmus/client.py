"""The client of an Isthmus server: push a robot's scans or submaps, read the merged map."""
from __future__ import annotations

import logging
import os
from types import TracebackType
from typing import Optional, Type

from isthmus._access import Access
from isthmus._arguments import wrong
from isthmus._changes import Changes
from isthmus._events import Events
from isthmus._files import Files
from isthmus._graph import Graph
from isthmus._localisation import Localising
from isthmus._reading import Reading
from isthmus._sessions import Sessions
from isthmus._tiles import Tiles
from isthmus._uploads import Uploads
from isthmus.errors import InvalidArgument
from isthmus.io.whole import PathLike
from isthmus.link import Link

logging.getLogger("isthmus").addHandler(logging.NullHandler())


class Client(Sessions, Uploads, Localising, Reading, Tiles, Changes, Graph, Files, Access,
             Events):
    """Made by `connect`. Thread safe; a context manager that closes it.

    Errors are subclasses of `isthmus.Error` with the server's code and message, or `Unavailable`,
    saying which address did not answer. What may be repeated without harm is tried again, with
    back-off, while the server does not answer; the rest is not repeated once it was sent. Frames
    and units are those of docs/concepts.md: metres, radians, nanoseconds since the Unix epoch,
    poses named `T_target_source`.
    """

    def __init__(self, link: Link) -> None:
        self._link = link

    @property
    def address(self) -> str:
        """host:port, or unix:PATH."""
        return self._link.address

    def close(self) -> None:
        """Ends the connection, and calls and streams under way."""
        self._link.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()


def connect(address: Optional[str] = None, timeout: float = 10.0, *,
            require_server: bool = True, call_timeout: float = 20.0,
            transfer_timeout: float = 900.0, tls_ca: Optional[PathLike] = None,
            tls_cert: Optional[PathLike] = None, tls_key: Optional[PathLike] = None,
            token: Optional[str] = None, token_file: Optional[PathLike] = None,
            site: Optional[str] = None, max_answer_bytes: int = 64 << 20,
            max_file_bytes: int = 16 << 30) -> Client:
    """A client of the server at `address`: host:port, or unix:PATH; else `InvalidArgument`. Several,
    separated by commas, are those of servers of one map, of which one has it: a call goes to the
    next where that of the last call is not there.

    `timeout`: for how many seconds a server that does not answer is tried again, now and in each
    later call; then it is `Unavailable`. `call_timeout`: for an answer that the server has at hand;
    `transfer_timeout`: for uploads, exports, queries, finishing a session, and what has the map
    placed anew. Without `require_server` it is not asked for a sign of life now.

    `tls_ca`: PEM file of who signed the server's certificate, or "system"; without it the two speak
    plain text. `tls_cert`, `tls_key`: PEM files that a server which asks for them is shown. `token`,
    or what `token_file` holds, is sent with every call; `site` names one of the server's maps.

    What is not given is taken from the environment, as `isthmus` does: ISTHMUS_SERVER (else
    127.0.0.1:50051), ISTHMUS_TLS_CA, ISTHMUS_TLS_CERT, ISTHMUS_TLS_KEY, ISTHMUS_TOKEN_FILE, or else
    ISTHMUS_TOKEN, and ISTHMUS_SITE. An empty `tls_ca`, `token` or `site` is none, whatever the
    environment says. `InvalidArgument`, before anything is sent, for a `token` and a `token_file`,
    and for files that cannot be used.

    `ResourceExhausted` for a list of more than `max_answer_bytes`, and for an exported file of more
    than `max_file_bytes`: no sound server's answer is as long.
    """
    if token and token_file:
        raise InvalidArgument("give a token or a token_file, not both")
    if token_file or token is None:
        path = token_file or os.environ.get("ISTHMUS_TOKEN_FILE")
        token = _token_in(path) if path else os.environ.get("ISTHMUS_TOKEN")
    ca, certificate, key = (
        _given(_path(name, file), f"ISTHMUS_{name.upper()}")
        for name, file in (("tls_ca", tls_ca), ("tls_cert", tls_cert), ("tls_key", tls_key)))
    client = Client(Link(_given(address, "ISTHMUS_SERVER") or "127.0.0.1:50051", timeout,
                         call_timeout, transfer_timeout, ca, certificate, key, token,
                         _given(site, "ISTHMUS_SITE"), max_answer_bytes, max_file_bytes))
    if require_server:
        try:
            client._link.probe()
        except BaseException:
            client.close()
            raise
    return client


def _given(value: Optional[str], variable: str) -> Optional[str]:
    """What was given, or else what the environment says; None for an empty one."""
    return (os.environ.get(variable) if value is None else value) or None


def _path(what: str, path: Optional[PathLike]) -> Optional[str]:
    try:
        return None if path is None else os.fsdecode(path)
    except TypeError:
        raise wrong(what, "the path of a file", path) from None


def _token_in(path: PathLike) -> str:
    try:
        with open(_path("token_file", path) or "", encoding="ascii") as file:
            token = file.read(4096)
        if not token.strip():
            raise InvalidArgument("the token file is empty: `isthmus token create` prints its "
                                  "content")
        return token
    except OSError as error:  # The path may be the token itself, given in its place.
        raise InvalidArgument(f"cannot read the token file: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InvalidArgument("the token file has a character that is not allowed") from None

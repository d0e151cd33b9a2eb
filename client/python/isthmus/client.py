"""The client of an Isthmus server: push a robot's scans or submaps, read the merged map."""
from __future__ import annotations

import logging
from types import TracebackType
from typing import Optional, Type

from isthmus._access import Access
from isthmus._changes import Changes
from isthmus._events import Events
from isthmus._files import Files
from isthmus._graph import Graph
from isthmus._localisation import Localising
from isthmus._reading import Reading
from isthmus._sessions import Sessions
from isthmus._tiles import Tiles
from isthmus._uploads import Uploads
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


def connect(address: str = "127.0.0.1:50051", timeout: float = 10.0, *,
            require_server: bool = True, call_timeout: float = 20.0,
            transfer_timeout: float = 900.0, tls_ca: Optional[str] = None,
            tls_cert: Optional[str] = None, tls_key: Optional[str] = None,
            token: Optional[str] = None, site: Optional[str] = None) -> Client:
    """A client of the server at `address`: host:port, or unix:PATH; else `InvalidArgument`. Several,
    separated by commas, are those of servers of one map, of which one has it: a call goes to the
    next where that of the last call is not there.

    `timeout`: for how many seconds a server that does not answer is tried again, now and in each
    later call; then it is `Unavailable`. `call_timeout`: for an answer that the server has at hand;
    `transfer_timeout`: for uploads, exports, queries, finishing a session, and what has the map
    placed anew. Without `require_server` it is not asked for a sign of life now.

    `tls_ca`: PEM file of who signed the server's certificate, or "system"; without it the two speak
    plain text. `tls_cert`, `tls_key`: PEM files that a server which asks for them is shown. `token`
    is sent with every call; `site` names one of the server's maps.
    """
    client = Client(Link(address, timeout, call_timeout, transfer_timeout, tls_ca, tls_cert,
                         tls_key, token, site))
    if require_server:
        try:
            client._link.probe()
        except BaseException:
            client.close()
            raise
    return client

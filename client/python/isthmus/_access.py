"""The part of Client that makes and revokes tokens, for administrators."""
from __future__ import annotations

from typing import Iterable, List, Tuple, Union

from isthmus import convert
from isthmus._arguments import listed, request, word
from isthmus.link import Link
from isthmus.times import Moment, to_ns
from isthmus.v1 import access_service_pb2 as pb
from isthmus.v1.records import Role, Token


class Access:
    """Part of Client."""

    _link: Link

    def create_token(self, name: str, role: Union[Role, str], robots: Union[str, Iterable[str]] = (),
                     sites: Union[str, Iterable[str]] = (), expires_ns: Moment = 0) -> Tuple[Token, str]:
        """Makes a token, and returns it with its secret, which nobody can ask for again.

        `role`: "robot", "reader", "operator" or "admin"; `robots`: which ones a robot's token may
        feed, one name or a list, with `*` for any characters; `sites`: likewise, the default site if empty,
        an administrator's for all; `expires_ns`: a datetime or since the Unix epoch, 0 for never. Not repeated
        once it was sent.
        """
        wanted = request(pb.Token, name=name, role=word("role", Role, role),
                         robots=listed("robots", robots), sites=listed("sites", sites),
                         expires_ns=to_ns(expires_ns, "expires_ns"))
        response = self._link.call_once(self._link.access.CreateToken,
                                        pb.CreateTokenRequest(token=wanted))
        return convert.record(Token, response.token), str(response.secret)

    def list_tokens(self) -> List[Token]:
        """All tokens, in order of creation."""
        parts = self._link.collect(self._link.access.ListTokens, pb.ListTokensRequest())
        return [convert.record(Token, token) for part in parts for token in part.tokens]

    def revoke_token(self, name: str) -> Token:
        """The token holds no more. `NotFound` if there is none of that name."""
        return convert.record(Token, self._link.call(self._link.access.RevokeToken,
                                      request(pb.RevokeTokenRequest, name=name)))

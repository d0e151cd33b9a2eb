"""Tokens, made and revoked over a real socket."""
import functools
import unittest

import isthmus
from isthmus import Role
from servers import Server


class AccessTest(unittest.TestCase):
    """The first token closes the server; who has it goes on."""

    def setUp(self) -> None:
        self.server = self.enterContext(Server())
        self.client = self.enterContext(isthmus.connect(self.server.address))

    def authorize(self, secret: str) -> None:
        """Has the calls about tokens send it."""
        stub = self.client._link.access
        for name in ("ListTokens", "RevokeToken"):
            call = functools.partial(getattr(stub, name),
                                     metadata=(("authorization", f"Bearer {secret}"),))
            setattr(stub, name, call)

    def test_made_listed_and_revoked(self) -> None:
        self.assertEqual(self.client.list_tokens(), [])
        token, secret = self.client.create_token("chief", "admin")
        self.assertEqual((token.name, token.role, token.sites), ("chief", Role.ADMIN, ("*",)))
        self.assertNotIn(secret, repr(token))
        with self.assertRaises(isthmus.Unauthenticated):
            self.client.list_tokens()
        self.authorize(secret)
        self.assertEqual([token.name for token in self.client.list_tokens()], ["chief"])
        with self.assertRaises(isthmus.NotFound):
            self.client.revoke_token("nobody")
        self.assertGreater(self.client.revoke_token("chief").revoked_ns, 0)
        with self.assertRaises(isthmus.Unauthenticated):
            self.client.list_tokens()

    def test_what_makes_no_sense(self) -> None:
        with self.assertRaises(isthmus.InvalidArgument):
            self.client.create_token("x", "king")
        with self.assertRaises(isthmus.InvalidArgument):
            self.client.create_token("x", Role.ROBOT)
        self.assertEqual(self.client.list_tokens(), [])


if __name__ == "__main__":
    unittest.main()

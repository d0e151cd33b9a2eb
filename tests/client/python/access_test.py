"""Tokens, made and revoked over a real socket."""
import dataclasses
import datetime
import functools
import os
import subprocess
import sys
import textwrap
import unittest
from unittest import mock

import numpy as np

import isthmus
from isthmus import Role
from servers import Server, temporary_folder


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

    def test_a_token_counts_however_it_comes_and_is_never_shown(self) -> None:
        _, secret = self.client.create_token("chief", "admin")
        folder = temporary_folder()
        for end in ("", "\n", "\r\n", "  \n"):
            file = folder / "token"
            file.write_bytes((secret + end).encode())
            ways = [({"token": secret + end}, {}), ({"token_file": str(file)}, {}),
                    ({}, {"ISTHMUS_TOKEN": secret + end}), ({}, {"ISTHMUS_TOKEN_FILE": str(file)})]
            for given, environment in ways:
                environment["ISTHMUS_SERVER"] = self.server.address
                with mock.patch.dict(os.environ, environment):
                    with isthmus.connect(**given) as client:
                        self.assertEqual(len(client.list_tokens()), 1)
        script = textwrap.dedent("""
            import sys, isthmus
            for token in (sys.argv[1] + "\\n" + sys.argv[1], sys.argv[1] + "\\x00",
                          sys.argv[1] + "\\u00e4"):
                for given in ({"token": token}, {"token_file": sys.argv[1]}, {"site": token}):
                    try:
                        isthmus.connect(sys.argv[2], **given)
                    except isthmus.InvalidArgument as error:
                        print(error)
            isthmus.connect(sys.argv[2], token=sys.argv[1] + "\\t" + sys.argv[1])
            """)
        told = subprocess.run([sys.executable, "-c", script, secret, self.server.address],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              check=False)
        self.assertEqual(told.stdout.count("has a character that is not allowed\n")
                         + told.stdout.count("or not ASCII"), 4, told.stdout)
        self.assertEqual(told.stdout.count("cannot name a site"), 3, told.stdout)
        self.assertNotIn(secret[8:], told.stdout)

    def test_what_cannot_name_a_site_is_not_the_default_one(self) -> None:
        for site in (" ", "\t", "default ", "default\n", ".hidden", "\u00e4", "a" * 65):
            with self.assertRaisesRegex(isthmus.InvalidArgument, "cannot name a site"):
                isthmus.connect(self.server.address, site=site)

    def test_moments_are_datetimes_too(self) -> None:
        end = datetime.datetime(2200, 1, 2, 3, 4, 5, tzinfo=datetime.timezone.utc)
        token, secret = self.client.create_token("chief", "admin", expires_ns=end)
        self.assertEqual((token.expires, token.revoked), (end, None))
        self.assertEqual(isthmus.to_datetime(token.expires_ns), end)
        self.assertEqual(isthmus.to_ns(end), token.expires_ns)
        self.assertIsNone(isthmus.to_datetime(token.revoked_ns))
        self.authorize(secret)
        with self.assertRaisesRegex(isthmus.InvalidArgument, "time zone"):
            self.client.create_token("x", "reader", expires_ns=datetime.datetime(2200, 1, 1))

    def test_every_moment_of_a_record_is_a_datetime_by_one_rule(self) -> None:
        durations = {"ack_delay_ns"}
        given = {"OwnSubmap", "Scan"}  # Made by the caller.
        seen = set()
        for name in isthmus.__all__:
            kind = getattr(isthmus, name)
            if not dataclasses.is_dataclass(kind) or name in given:
                continue
            for field in dataclasses.fields(kind):
                if field.name.endswith("_ns") and field.name not in durations:
                    self.assertTrue(hasattr(kind, field.name[:-3]), f"{name}.{field.name}")
                    seen.add(name)
        self.assertLessEqual({"Session", "Event", "Trajectory", "ServerStatus"}, seen)
        first = datetime.datetime(2026, 3, 4, 5, 6, 7, 250000, tzinfo=datetime.timezone.utc)
        rejection = isthmus.Rejection(1, isthmus.to_ns(first), "")
        self.assertEqual(rejection.stamp, first)
        stamps = np.array([isthmus.to_ns(first)])
        ways = isthmus.Trajectory("alice-1", 1, 0, stamps, np.eye(4)[None], np.ones(1, np.uint32))
        self.assertEqual(str(ways.stamps[0]), "2026-03-04T05:06:07.250000000")

    def test_a_text_is_one_name(self) -> None:
        token, _ = self.client.create_token("one", "robot", robots="alice", sites="hall")
        self.assertEqual((token.robots, token.sites), (("alice",), ("hall",)))

    def test_what_makes_no_sense(self) -> None:
        with self.assertRaises(isthmus.InvalidArgument):
            self.client.create_token("x", "king")
        with self.assertRaises(isthmus.InvalidArgument):
            self.client.create_token("x", Role.ROBOT)
        self.assertEqual(self.client.list_tokens(), [])


if __name__ == "__main__":
    unittest.main()

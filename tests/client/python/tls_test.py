"""TLS: to a real server, with certificates of `isthmus certs`."""
import os
import subprocess
import sys
import unittest
from pathlib import Path

import isthmus
from servers import CLI, Server, temporary_folder


class Tls(unittest.TestCase):
    def setUp(self) -> None:
        self.certs = temporary_folder() / "certs"
        subprocess.run([CLI, "certs", "init", str(self.certs), "--host", "127.0.0.1", "--client",
                        "alice"], check=True, stdout=subprocess.DEVNULL)

    def serve(self, *more: str) -> Server:
        settings = self.certs / "server.yaml"
        settings.write_text("\n  ".join([
            "network:", f"tls_certificate: {self.certs}/server.pem",
            f"tls_key: {self.certs}/server.key", *more]) + "\n")
        return self.enterContext(Server(settings=settings))

    def file(self, name: str) -> str:
        return str(self.certs / name)

    def test_reaches_who_is_trusted(self) -> None:
        server = self.serve()
        with isthmus.connect(server.address, tls_ca=self.file("ca.pem")) as client:
            self.assertEqual(client.get_map_info().revision, 0)
        with self.assertRaisesRegex(isthmus.Unavailable, "does it speak TLS.*tls_ca"):
            isthmus.connect(server.address, timeout=0)
        with self.assertRaises(isthmus.Unavailable):
            isthmus.connect(server.address, timeout=0, tls_ca="system")

    def test_shows_its_certificate(self) -> None:
        server = self.serve(f"tls_client_ca: {self.certs}/ca.pem")
        ca = self.file("ca.pem")
        with isthmus.connect(server.address, tls_ca=ca, tls_cert=self.file("alice.pem"),
                             tls_key=self.file("alice.key")) as client:
            client.get_map_info()
        with self.assertRaises(isthmus.Unavailable):
            isthmus.connect(server.address, timeout=0, tls_ca=ca)

    def test_files_that_hold_no_certificate_are_told_at_once(self) -> None:
        (self.certs / "empty.pem").write_text("")
        (self.certs / "token").write_text("isthmus_0123")
        pair = {"tls_ca": self.file("ca.pem"), "tls_cert": self.file("alice.pem"),
                "tls_key": self.file("alice.key")}
        isthmus.connect("127.0.0.1:1", require_server=False, **pair).close()
        for name, file, said in (
                *(("tls_ca", file, f"{file}, given as tls_ca, holds no certificate")
                  for file in ("server.key", "empty.pem", "token")),
                ("tls_cert", "alice.key", "not a certificate and its key"),
                ("tls_key", "server.key", "not a certificate and its key"),
                ("tls_key", "empty.pem", "not a certificate and its key")):
            with self.assertRaisesRegex(isthmus.InvalidArgument, said):
                isthmus.connect("127.0.0.1:1", require_server=False,
                                **{**pair, name: Path(self.file(file))})

    def test_grpc_logs_nothing_beside_the_message(self) -> None:
        server = self.serve()
        script = ("import sys, isthmus\n"
                  "for given in ({}, {'tls_ca': 'system'}):\n"
                  "    try: isthmus.connect(sys.argv[1], timeout=0, **given)\n"
                  "    except isthmus.Unavailable: print('told')\n")
        environment = {key: value for key, value in os.environ.items() if key != "GRPC_VERBOSITY"}
        for more, is_quiet in (({}, True), ({"GRPC_VERBOSITY": "ERROR"}, False)):
            done = subprocess.run([sys.executable, "-c", script, server.address], text=True,
                                  env={**environment, **more}, capture_output=True, check=True)
            self.assertEqual(done.stdout, "told\ntold\n")
            self.assertEqual(done.stderr == "", is_quiet, done.stderr)

    def test_refuses_half_of_a_pair_and_files_that_are_not_there(self) -> None:
        with self.assertRaises(isthmus.InvalidArgument):
            isthmus.connect("127.0.0.1:1", tls_ca="system", tls_cert="a.pem")
        with self.assertRaisesRegex(isthmus.InvalidArgument, "none.pem"):
            isthmus.connect("127.0.0.1:1", tls_ca=str(Path(self.certs) / "none.pem"))


if __name__ == "__main__":
    unittest.main()

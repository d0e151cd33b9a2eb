"""TLS: to a real server, with certificates of `isthmus certs`."""
import subprocess
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
        return Server(settings=settings)

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

    def test_refuses_half_of_a_pair_and_files_that_are_not_there(self) -> None:
        with self.assertRaises(isthmus.InvalidArgument):
            isthmus.connect("127.0.0.1:1", tls_ca="system", tls_cert="a.pem")
        with self.assertRaisesRegex(isthmus.InvalidArgument, "none.pem"):
            isthmus.connect("127.0.0.1:1", tls_ca=str(Path(self.certs) / "none.pem"))


if __name__ == "__main__":
    unittest.main()

"""The server of a soak: its process, its disk, its certificates, and those who ask it."""
import json
import os
import pathlib
import shutil
import subprocess
import time

SITES = ("default", "yard")  # The second keeps raw scans, so that its disk is always needed.
CACHE_MB = 64
BLOCK = 4096
PATIENCE_S = 120  # With any command.


def config(day_s, certs):
    """The settings; what is counted in days is counted in the soak's."""
    return f"""network:
  listen: "127.0.0.1:0"
  tls_certificate: {certs}/server.pem
  tls_key: {certs}/server.key
  require_token: always
storage: {{cache_mb: {CACHE_MB}}}
retention: {{max_age_days: {day_s / 2 / 86400:.9f}}}
sites:
  yard:
    archive: {{mode: full, segment_bytes: 1048576}}
"""


class Disk:
    """The file system of the map: a small one of its own where we may mount one."""

    def __init__(self, folder, size_mb):
        self.folder = folder
        folder.mkdir()
        self._foreign = folder / "foreign"
        self._is_full, self._used_mb = False, 0.0
        mount = ["mount", "-t", "tmpfs", "-o", f"size={size_mb}m", "soak", folder]
        self.is_own = os.geteuid() == 0 and subprocess.run(
            mount, check=False, capture_output=True).returncode == 0

    def fill(self):
        """To the last block. What becomes free meanwhile is taken by the next call."""
        self._is_full = True
        file = os.open(self._foreign, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        try:
            for size in (1 << 20, BLOCK):
                try:
                    while True:
                        os.write(file, bytes(size))
                except OSError:
                    pass
        finally:
            os.close(file)

    def free(self):
        self._foreign.unlink()
        self._is_full = False

    def used_mb(self):
        """Of the map alone; on a disk of its own files without a name count too. While it is
        full, what it was before."""
        if not self.is_own:
            return sum(path.stat().st_blocks * 512 for path in self.folder.rglob("*")) / 1e6
        used = shutil.disk_usage(self.folder).used
        if not self._is_full:
            self._used_mb = used / 1e6
        return self._used_mb

    def release(self):
        if self.is_own:
            subprocess.run(["umount", self.folder], check=True)


class Server:
    """One process, from the first day to the last."""

    def __init__(self, programs, out, disk, day_s):
        self._programs, self.out, self.disk = programs, out, disk
        self.data, self.certs, self.log = disk.folder / "map", out / "certs", out / "server.log"
        self.admin = out / "admin.token"
        # A day and a half, so that each day must renew it; where days are short, not so little that
        # a busy machine is late.
        self._valid_s = max(1.5 * day_s, 120)
        self.data.mkdir()
        self._certs("init", self._valid_s, "--host", "localhost", "--host", "127.0.0.1")
        self.admin.write_text(self._made("--data", self.data, "--role", "admin", "--name", "chief"))
        (out / "server.yaml").write_text(config(day_s, self.certs))
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [programs / "isthmus-server", "--data", self.data, "--config", out / "server.yaml"],
                stdout=subprocess.PIPE, stderr=log, text=True)
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"the server did not come up; see {self.log}")
        self.address = line.split()[-1]

    def _isthmus(self, *args, **kwargs):
        command = [str(self._programs / "isthmus"), *map(str, args)]
        try:
            return subprocess.run(command, text=True, capture_output=True, check=False,
                                  timeout=PATIENCE_S, **kwargs)
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(command, -1, "", f"no answer in {PATIENCE_S} s")

    def _certs(self, what, valid_s, *args):
        done = self._isthmus("certs", what, self.certs, *args, "--days", valid_s / 86400)
        if done.returncode != 0:
            raise SystemExit(done.stderr)

    def renew_certificates(self, valid_s=None):
        self._certs("renew", valid_s or self._valid_s)

    def environment(self, token, site):
        return {**os.environ, "ISTHMUS_SERVER": self.address, "ISTHMUS_TOKEN_FILE": str(token),
                "ISTHMUS_TLS_CA": str(self.certs / "ca.pem"), "ISTHMUS_SITE": site}

    def run(self, *args, token=None, site=SITES[0]):
        """`isthmus ARGS`, with the administrator's token unless told."""
        env = self.environment(token or self.admin, site)
        return self._isthmus("--attempts", 1, *args, env=env)

    def ask(self, *args, site=SITES[0], patience_s=0.0):
        """The answer as JSON, or None."""
        until = time.monotonic() + patience_s
        while True:
            done = self.run(*args, "--json", site=site)
            if done.returncode == 0:
                return json.loads(done.stdout)
            if time.monotonic() >= until:
                return None
            time.sleep(0.2)

    def sessions(self, site, patience_s=0.0):
        """First segments, which have the counts of all; {} without an answer."""
        answer = self.ask("session", "list", site=site, patience_s=patience_s)
        return {one["id"]: one for one in (answer or {"sessions": []})["sessions"]
                if one["segment"] <= 1}

    def problem(self, site):
        """Why it cannot store at the moment, or ""."""
        state = self.ask("status", site=site, patience_s=10)
        if state is None:
            return "no answer"
        return state["storage_problem"] or next(
            (one["archive_problem"] for one in self.sessions(site).values()
             if one["archive_problem"]), "")

    def _made(self, *args):
        done = self._isthmus("token", "create", *args)
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        return done.stdout

    def make_token(self, name, *args):
        """Its secret; by the running server, with the certificate that is valid now or soon."""
        done = self.run("token", "create", "--name", name, *args)
        if done.returncode != 0:
            raise SystemExit(f"token {name}: {done.stderr}")
        return done.stdout

    def figures(self):
        proc = pathlib.Path(f"/proc/{self.process.pid}")
        status = dict(line.split(":", 1) for line in (proc / "status").read_text().splitlines())
        databases = [path for path in self.data.rglob("*.db*") if path.exists()]
        return {"RSS, MB": int(status["VmRSS"].split()[0]) / 1024,
                "files": len(os.listdir(proc / "fd")), "threads": int(status["Threads"]),
                "database, MB": sum(path.stat().st_size for path in databases) / 1e6,
                "disk, MB": self.disk.used_mb()}

    def rotate_log(self, day):
        """As logrotate's copytruncate does it."""
        shutil.copyfile(self.log, f"{self.log}.{day}")
        os.truncate(self.log, 0)

    def check(self, folder):
        """"" if the map there is sound."""
        done = subprocess.run([self._programs / "isthmus-server", "--check", folder], text=True,
                              capture_output=True, check=False)
        return "" if done.returncode == 0 else done.stdout + done.stderr

    def stop(self):
        """Its exit code."""
        self.process.terminate()
        return self.process.wait(timeout=120)

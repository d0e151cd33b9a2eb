#!/usr/bin/env python3
"""Holds what starts a program in a container to what that program takes: flags of the Dockerfile,
the compose files and deploy/ to its --help, a server's settings to --print-config.

Usage: check_deployments.py ROOT SERVER WORKER
ROOT: the tree; SERVER, WORKER: the programs isthmus-server and isthmus-worker. Prints one line per
violation and exits 1 if there is any. Needs no YAML library: a command's flags are all that begin
with --, up to where it ends.
"""
import pathlib
import re
import subprocess
import sys

# A command, in one line or folded over several that are indented or in brackets.
COMMAND = re.compile(r"isthmus-(?:server|worker)\b(?:[^\n\]]|\n +(?=--)|\n +(?=[^\n]*\]))*")
FLAG = re.compile(r"(?<![\w-])--[a-z][a-z-]*")


def files(root):
    yield from sorted([*root.glob("Dockerfile"), *root.glob("docker-compose*.yml")])
    yield from sorted(root.glob("deploy/**/*.yaml"))


def main():
    root, server, worker = pathlib.Path(sys.argv[1]), *sys.argv[2:4]
    known = {}
    for program in (server, worker):
        says = subprocess.run([program, "--help"], check=True, text=True, capture_output=True).stdout
        known[pathlib.Path(program).name] = set(FLAG.findall(says))
    problems, flags, settings = [], 0, 0
    for path in files(root):
        where, text = path.relative_to(root), path.read_text(encoding="utf-8")
        text = re.sub(r"^\s*#.*\n", "", text, flags=re.MULTILINE)
        for command in COMMAND.findall(text):
            program = re.match(r"[a-z-]+", command)[0]
            for flag in FLAG.findall(command):
                flags += 1
                if flag not in known[program]:
                    problems.append(f"{where}: {program} has no {flag}")
        if path.name == "server.yaml":
            settings += 1
            read = subprocess.run([server, "--config", path, "--print-config"], text=True,
                                  capture_output=True)
            if read.returncode != 0:
                problems.append(f"{where}: {read.stderr.strip()}")
    if flags == 0 or settings == 0:
        problems.append("no flags or no settings found: is ROOT the tree?")
    print("\n".join(problems) or f"{flags} flags and {settings} files of settings are known")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()

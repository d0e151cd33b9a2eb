#!/usr/bin/env python3
"""Holds docs/api-reference.md to what api/isthmus/v1/*.proto say, comments included.

Usage: check_api_reference.py ROOT [--write]
Exits 1 if the document says something else. --write: writes it instead. Needs protoc.
"""
import collections
import pathlib
import re
import subprocess
import sys
import tempfile

import check_docs

# In the order of the document.
FILES = ["types", "session_service", "map_service", "edit_service", "localisation_service",
         "admin_service", "access_service"]
CODES = ("ABORTED ALREADY_EXISTS CANCELLED DATA_LOSS DEADLINE_EXCEEDED FAILED_PRECONDITION INTERNAL "
         "INVALID_ARGUMENT NOT_FOUND OUT_OF_RANGE PERMISSION_DENIED RESOURCE_EXHAUSTED "
         "UNAUTHENTICATED UNAVAILABLE UNIMPLEMENTED").split()
CODE = re.compile(rf"(?:^|(?<=[.;] ))({'|'.join(CODES)}): ")
SCALARS = {1: "double", 2: "float", 3: "int64", 4: "uint64", 5: "int32", 6: "fixed64", 7: "fixed32",
           8: "bool", 9: "string", 12: "bytes", 13: "uint32", 15: "sfixed32", 16: "sfixed64",
           17: "sint32", 18: "sint64"}
REPEATED = 3
HEAD = """# API reference

Every service, message and field of [`api/isthmus/v1`](../api/isthmus/v1), as the comments there say
it. How they fit together is in [api.md](api.md), the words are in [concepts.md](concepts.md).

<!-- Written by tests/lint/check_api_reference.py . --write: change the .proto files instead. -->
"""


def varint(data, at):
    value = shift = 0
    while True:
        value |= (data[at] & 0x7F) << shift
        shift += 7
        at += 1
        if data[at - 1] < 0x80:
            return value, at


def fields(data):
    """Number -> values of a message in protobuf's wire format, numbers and bytes as they are."""
    found, at = collections.defaultdict(list), 0
    while at < len(data):
        key, at = varint(data, at)
        kind = key & 7
        if kind == 0:
            value, at = varint(data, at)
        elif kind == 2:
            size, at = varint(data, at)
            value, at = data[at:at + size], at + size
        else:
            size = {1: 8, 5: 4}[kind]
            value, at = data[at:at + size], at + size
        found[key >> 3].append(value)
    return found


def text(message, field_number):
    return message[field_number][0].decode() if message[field_number] else ""


def number(message, field_number):
    return message[field_number][0] if message[field_number] else 0


def comments_of(file):
    """Path in the descriptor -> lines of the comments before and behind it."""
    found = {}
    for location in map(fields, fields(number(file, 9) or b"")[1]):
        path, at = [], 0
        packed = b"".join(location[1])
        while at < len(packed):
            step, at = varint(packed, at)
            path.append(step)
        lines = (text(location, 3) + text(location, 4)).splitlines()
        if lines:
            found[tuple(path)] = [line[1:] if line.startswith(" ") else line for line in lines]
    return found


def anchor(name):
    return name.replace(".", "").lower()


class File:
    """One .proto file, as Markdown."""

    def __init__(self, data):
        self.file = fields(data)
        self.comments = comments_of(self.file)
        self.package = "." + text(self.file, 2) + "."

    def comment(self, path):
        return self.comments.get(tuple(path), [])

    def cell(self, path):
        return " ".join(line.strip() for line in self.comment(path)).replace("|", "\\|")

    def link(self, type_name):
        name = type_name.decode().removeprefix(self.package)
        return f"[{name}](#{anchor(name)})"

    def kind(self, field):
        type_name = self.link(field[6][0]) if field[6] else SCALARS[number(field, 5)]
        if number(field, 4) == REPEATED:
            return "repeated " + type_name
        return ("optional " if number(field, 17) else "") + type_name

    def enum(self, enum, path, outer):
        yield from ["", f"### {outer}{text(enum, 1)}", ""]
        if self.comment(path):
            yield from self.comment(path) + [""]
        yield from ["| number | value | |", "|---|---|---|"]
        for i, value in enumerate(map(fields, enum[2])):
            yield f"| {number(value, 2)} | `{text(value, 1)}` | {self.cell(path + [2, i])} |"

    def message(self, message, path, outer=""):
        name = outer + text(message, 1)
        yield from ["", f"### {name}", ""]
        yield from self.comment(path) or ([] if message[2] else ["Has no fields."])
        if self.comment(path) and message[2]:
            yield ""
        if message[2]:
            yield from ["| number | field | type | |", "|---|---|---|---|"]
        choices = [text(fields(choice), 1) for choice in message[8]]
        for i, field in enumerate(map(fields, message[2])):
            says = self.cell(path + [2, i])
            if field[9] and not number(field, 17):
                says = f"One of `{choices[number(field, 9)]}`. {says}".strip()
            yield f"| {number(field, 3)} | `{text(field, 1)}` | {self.kind(field)} | {says} |"
        for i, enum in enumerate(map(fields, message[4])):
            yield from self.enum(enum, path + [4, i], name + ".")
        for i, nested in enumerate(map(fields, message[3])):
            yield from self.message(nested, path + [3, i], name + ".")

    def method(self, method, path):
        def side(type_field, stream_field):
            stream = "stream of " if number(method, stream_field) else ""
            return stream + self.link(method[type_field][0])

        yield from ["", f"### {text(method, 1)}", ""]
        yield f"{side(2, 5)} → {side(3, 6)}"
        says = " ".join(line.strip() or "\n" for line in self.comment(path))
        plain, *codes = CODE.split(says)
        for paragraph in filter(None, map(str.strip, plain.split("\n"))):
            yield from ["", paragraph]
        if codes:
            yield ""
        for code, meaning in zip(codes[::2], codes[1::2]):
            yield f"- `{code}`: {' '.join(meaning.split())}"

    def services(self):
        for i, service in enumerate(map(fields, self.file[6])):
            yield from ["", f"## {text(service, 1)}", ""] + self.comment([6, i])
            for k, method in enumerate(map(fields, service[2])):
                yield from self.method(method, [6, i, 2, k])

    def types(self):
        for i, enum in enumerate(map(fields, self.file[5])):
            yield from self.enum(enum, [5, i], "")
        for i, message in enumerate(map(fields, self.file[4])):
            yield from self.message(message, [4, i])

    def lines(self, title=None):
        if title:
            yield from ["", f"## {title}", ""] + self.comment([2])
        yield from self.services()
        yield from self.types()


def describe(root):
    """The files, in the order of the document; those it does not name come last."""
    api = root / "api"
    names = sorted((f.stem for f in (api / "isthmus/v1").glob("*.proto")),
                   key=lambda name: (FILES + [name]).index(name))
    with tempfile.NamedTemporaryFile() as out:
        subprocess.run(["protoc", f"-I{api}", "--include_source_info", f"-o{out.name}"] +
                       [f"isthmus/v1/{name}.proto" for name in names], check=True)
        files = {text(fields(data), 1): File(data) for data in fields(out.read())[1]}
    return [files[f"isthmus/v1/{name}.proto"] for name in names]


def document(root):
    lines = HEAD.splitlines()
    for file in describe(root):
        lines += file.lines(None if file.file[6] else "Types that all share")
    return "".join(check_docs.wrapped([line.rstrip() + "\n" for line in lines]))


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    path = root / "docs" / "api-reference.md"
    wanted = document(root)
    if "--write" in sys.argv[2:]:
        path.write_text(wanted, encoding="utf-8")
    elif not path.is_file() or path.read_text(encoding="utf-8") != wanted:
        print("docs/api-reference.md: the .proto files say something else; "
              "run tests/lint/check_api_reference.py . --write")
        sys.exit(1)
    print("docs/api-reference.md says what the .proto files say")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes a C++ source with all files of a folder in it; see embed.cmake.

Usage: embed.py SOURCE FUNCTION FOLDER
FOLDER may be empty: then there are no files.
"""
import gzip
import pathlib
import sys

TYPES = {
    ".css": "text/css; charset=utf-8", ".html": "text/html; charset=utf-8", ".ico": "image/x-icon",
    ".js": "text/javascript; charset=utf-8", ".json": "application/json", ".png": "image/png",
    ".svg": "image/svg+xml", ".txt": "text/plain; charset=utf-8", ".wasm": "application/wasm",
    ".webmanifest": "application/manifest+json", ".woff2": "font/woff2",
}
PER_LINE = 24  # Bytes, of four characters each.


def literals(data):
    """The bytes as lines of string literals; octal, as no digit behind such a one belongs to it."""
    lines = [data[i:i + PER_LINE] for i in range(0, len(data), PER_LINE)]
    return "\n".join('    "' + "".join(f"\\{byte:03o}" for byte in line) + '"'
                     for line in lines or [b""])


def asset(path, name):
    data = path.read_bytes()
    packed = gzip.compress(data, 9, mtime=0)
    if len(packed) >= len(data):
        packed = b""
    kind = TYPES.get(path.suffix, "application/octet-stream")
    content = [f"static constexpr char k{part}{name}[] =\n{literals(part_data)};\n"
               for part, part_data in (("Content", data), ("Gzip", packed))]
    return "".join(content), kind, len(data), len(packed)


def main():
    source, function, folder = sys.argv[1:]
    files = sorted(f for f in pathlib.Path(folder).rglob("*") if f.is_file()) if folder else []
    text, rows = [], []
    for number, path in enumerate(files):
        content, kind, size, packed = asset(path, number)
        text.append(content)
        at = "/" + path.relative_to(folder).as_posix()
        rows.append(f'      {{"{at}", "{kind}", {{kContent{number}, {size}}}, '
                    f"{{kGzip{number}, {packed}}}}},\n")
    pathlib.Path(source).write_text(
        '#include "core/asset.h"\n\nnamespace isthmus {\n\n' + "\n".join(text)
        + f"\nconst Assets& {function}() {{\n  static const Assets assets = {{\n" + "".join(rows)
        + "  };\n  return assets;\n}\n\n}  // namespace isthmus\n", encoding="utf-8")


if __name__ == "__main__":
    main()

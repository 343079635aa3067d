#!/usr/bin/env python3
"""Runs mesotex and records what it writes, so that two builds can be compared over a whole script.

    MESOTEX=old/mesotex RECORD=old.jsonl tools/draw_gallery.py --program tools/compare_outputs.py …
    MESOTEX=target/release/mesotex RECORD=new.jsonl tools/draw_gallery.py --program tools/compare_outputs.py …
    tools/compare_outputs.py --compare old.jsonl new.jsonl

Takes the place of the program in any script that has `--program`. Every command is run as it is, and adds one line of JSON to
RECORD: its arguments, without the folders of their paths, and a digest of every file that it wrote beside its `-o` or `--preview`. An
.npz file has one digest per array. Headers of PLY and OpenEXR files, which name versions and inputs, are left out, as are
JSON reports, which hold times, and caches. `--compare` prints the commands whose digests differ, and exits with 1 if any does.

Needs: Python's standard library
"""

import hashlib
import json
import os
import subprocess
import sys
import time
import zipfile
from pathlib import Path


def main():
    if sys.argv[1:2] == ["--compare"]:
        sys.exit(compare(*map(Path, sys.argv[2:4])))
    words = sys.argv[1:]
    begun = time.time_ns()
    status = subprocess.run([os.environ["MESOTEX"], *words]).returncode
    line = {"command": [Path(word).name if "/" in word else word for word in words], "status": status, "files": written(words, begun)}
    with open(os.environ["RECORD"], "a") as record:
        record.write(json.dumps(line) + "\n")
    sys.exit(status)


def written(words, begun):
    """Digests of the files that have changed beside outputs since the command began."""
    outputs = [Path(after) for word, after in zip(words, words[1:]) if word in ("-o", "--preview")]
    files = {}
    for folder in {output.parent for output in outputs}:
        for path in sorted(folder.rglob("*")):
            kept = path.suffix != ".json" and not any(part.endswith(".mesotex-cache") for part in path.parts)
            if kept and path.is_file() and path.stat().st_mtime_ns >= begun:
                files[str(path.relative_to(folder))] = digests(path)
    return files


def digests(path):
    if path.suffix == ".npz":
        with zipfile.ZipFile(path) as arrays:
            return {name: digest(arrays.read(name)) for name in arrays.namelist()}
    content = path.read_bytes()
    if path.suffix == ".ply":
        content = content[content.find(b"end_header") :]
    if path.suffix == ".exr":
        content = content[first_chunk(content) :]
    return {"": digest(content)}


def first_chunk(content):
    """Where the pixels of an OpenEXR file begin: the first offset of the table that follows its attributes."""
    at = 8
    while content[at]:
        at = content.index(b"\0", content.index(b"\0", at) + 1) + 1
        at += 4 + int.from_bytes(content[at : at + 4], "little")
    return int.from_bytes(content[at + 1 : at + 9], "little")


def digest(content):
    return hashlib.sha256(content).hexdigest()[:24]


def compare(before, after):
    before, after = ([json.loads(line) for line in path.read_text().splitlines()] for path in (before, after))
    parts = different = 0
    for old, new in zip(before, after):
        if (old["command"], old["status"]) != (new["command"], new["status"]):
            print("different commands:", *old["command"], "|", *new["command"])
            return 1
        olds, news = flat(old["files"]), flat(new["files"])
        names = sorted(name for name in olds.keys() | news.keys() if olds.get(name) != news.get(name))
        parts += len(olds.keys() | news.keys())
        different += len(names)
        if names:
            print(*old["command"], "\n   ", *(" ".join(filter(None, name)) for name in names))
    print(f"{len(before)} and {len(after)} commands, {parts} files and arrays, {different} differ")
    return int(bool(different) or len(before) != len(after))


def flat(files):
    return {(file, part): value for file, parts in files.items() for part, value in parts.items()}


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Fetch a CC0 material of ambientCG as a folder that `mesotex bake` recognises.

    python3 data-scripts/fetch_ambientcg.py Bark014
    mesotex bake Bark014 -o bark.sample --size 128

Needs nothing but Python 3.8 or later, and the network.
"""

import argparse
import io
import urllib.request
import zipfile
from pathlib import Path

URL = "https://ambientcg.com/get?file={name}_{size}-PNG.zip"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", help="the material's name, as Bark014")
    parser.add_argument("--size", default="1K", help="1K, 2K, 4K …")
    options = parser.parse_args()
    request = urllib.request.Request(
        URL.format(name=options.name, size=options.size), headers={"User-Agent": "mesotex"}
    )
    with urllib.request.urlopen(request) as answer:
        archive = zipfile.ZipFile(io.BytesIO(answer.read()))
    folder = Path(options.name)
    folder.mkdir(exist_ok=True)
    for member in archive.namelist():
        (folder / Path(member).name).write_bytes(archive.read(member))
    print(f"{folder}: {', '.join(sorted(path.name for path in folder.iterdir()))}")


if __name__ == "__main__":
    main()

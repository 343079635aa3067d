#!/usr/bin/env python3
"""Write the angles.csv that `mesotex import` reads, for image sets that keep angles in file names.

Understands the names of Bonn's UBO2003/ATRIUM sets ("00008 tl000 pl000 tv030 pv030.jpg") and of
UTIA ("tl000_pl000_tv030_pv030.png"): tl/pl are the light's polar angle and azimuth, tv/pv the
view's, in degrees, polar angles from the surface normal.

    unzip UBO_IMPALLA256.zip -d impalla
    python3 data-scripts/angles_from_names.py impalla
    mesotex import impalla/angles.csv -o impalla.sample

Needs nothing but Python 3.8 or later.
"""

import argparse
import csv
import re
import sys
from pathlib import Path

IMAGES = {".jpg", ".jpeg", ".png", ".exr", ".hdr", ".tif", ".tiff"}
COLUMNS = ["file", "view_theta_deg", "view_phi_deg", "light_theta_deg", "light_phi_deg"]


def angle(key, name):
    found = re.search(rf"(?<![a-z]){key}(\d+(?:\.\d+)?)", name)
    return float(found.group(1)) if found else None


def rows(folder):
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() not in IMAGES:
            continue
        angles = [angle(key, path.stem.lower()) for key in ("tv", "pv", "tl", "pl")]
        if None not in angles:
            yield [path.relative_to(folder).as_posix(), *angles]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="the unpacked image set")
    folder = parser.parse_args().folder
    table = list(rows(folder))
    if not table:
        sys.exit(f"{folder}: no image with tl, pl, tv and pv angles in its name")
    seen = {}
    for name, *angles in table:
        if tuple(angles) in seen:
            sys.exit(f"{folder}: {name} and {seen[tuple(angles)]} have the same angles")
        seen[tuple(angles)] = name
    with open(folder / "angles.csv", "w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(COLUMNS)
        writer.writerows(table)
    print(f"{folder / 'angles.csv'}: {len(table)} images")


if __name__ == "__main__":
    main()

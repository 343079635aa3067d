#!/usr/bin/env python3
"""Fetch an example of Columbia's STAF (time-varying surfaces), and convert one time step of it: 1 view x 6 lights, OpenEXR.

    python3 data-scripts/fetch_staf.py tvBTF09 --address https://…/tvBTF09.zip
    python3 data-scripts/fetch_staf.py tvBTF09 --address https://…/tvBTF09.zip --table step01.csv

Examples are called tvBTF09 to tvBTF45. Their files do not say where camera and lamps stood. So the archive is fetched
and unpacked; a table that you write for the images of one time step (columns file, view_theta_deg, view_phi_deg,
light_theta_deg, light_phi_deg) is converted with --table. No address of the archives is known for sure: take it from
the page. Needs nothing but Python 3.8 or later, and the network.
"""

from pathlib import Path

from fetching import convert, fetch, options_of, unpack

PAGE = "https://www1.cs.columbia.edu/CAVE/databases/staf/format.php"
TERMS = (
    "Columbia University publishes the data (Gu et al. 2006); read the terms on the page first. "
    "Size: 6 images per time step of 1280 that were taken."
)


def main():
    parser = options_of(__doc__, TERMS, PAGE)
    parser.add_argument("name", help="what to call the sample, as tvBTF09")
    parser.add_argument("--table", type=Path, help="the directions of the images of one time step, a .csv")
    options = parser.parse_args()
    print(TERMS, PAGE)
    archive = fetch(options.address, options.into, options.size, options.sha256)
    folder = options.into / options.name
    if not folder.exists():
        unpack(archive, folder)
    if options.table is None:
        print(f"{folder}: write a table of the directions of one time step, and convert it with --table")
        return
    convert(options, options.table, options.into / f"{options.name}.sample")


if __name__ == "__main__":
    main()

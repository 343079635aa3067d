#!/usr/bin/env python3
"""Fetch an example of reflectance-transformation imaging and convert it: a .ptm or .rti fit, or a zipped capture.

    python3 data-scripts/fetch_rti.py coin --address https://…/coin.ptm --lights bonn81
    python3 data-scripts/fetch_rti.py lion --address https://…/lion.zip

Examples lie with many museums and laboratories; no address is known for sure. Of an archive, the one list of lights
(.lp) in it is converted; a fit is evaluated at --lights. Needs nothing but Python 3.8 or later, and the network.
"""

import sys
import zipfile

from fetching import convert, fetch, options_of, unpack

PAGE = "https://culturalheritageimaging.org/"
TERMS = "Whoever offers an example states its terms; read them first."


def main():
    parser = options_of(__doc__, TERMS, PAGE)
    parser.add_argument("name", help="what to call the sample")
    parser.add_argument("--lights", default="bonn81", help="the lights that a fit is evaluated at, default bonn81")
    options = parser.parse_args()
    print(TERMS)
    file = fetch(options.address, options.into, options.size, options.sha256)
    sample = options.into / f"{options.name}.sample"
    if not zipfile.is_zipfile(file):
        convert(options, file, sample, "--lights", options.lights)
        return
    folder = options.into / options.name
    unpack(file, folder)
    lists = sorted(folder.rglob("*.lp"))
    if len(lists) != 1:
        sys.exit(f"{folder}: {len(lists)} lists of lights (.lp); import the right one by hand")
    convert(options, lists[0], sample)


if __name__ == "__main__":
    main()

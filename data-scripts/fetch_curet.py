#!/usr/bin/env python3
"""Fetch a material of CUReT and convert it: 205 pictures of one surface under scattered views and lights.

    python3 data-scripts/fetch_curet.py 11

The pictures are not rectified to one texel grid. The address was seen in several programs of others.
Needs nothing but Python 3.8 or later, and the network.
"""

import sys

from fetching import convert, fetch, options_of

ADDRESS = "https://www.cs.columbia.edu/CAVE/exclude/curet/data/zips/sample{number:02}.zip"
PAGE = "https://www.cs.columbia.edu/CAVE/software/curet/html/btfm.html"
TERMS = (
    "Columbia University and Utrecht University publish the data (Dana et al. 1999); read the terms on the page first. "
    "Size: 205 BMP images."
)


def main():
    parser = options_of(__doc__, TERMS, PAGE, ADDRESS)
    parser.add_argument("number", type=int, help="the material's number, 1 to 61")
    options = parser.parse_args()
    if not 1 <= options.number <= 61:
        sys.exit(f"{options.number}: no material's number; expected 1 to 61")
    print(TERMS, PAGE)
    address = options.address or ADDRESS.format(number=options.number)
    archive = fetch(address, options.into, options.size, options.sha256)
    convert(options, archive, options.into / f"curet{options.number:02}.sample")


if __name__ == "__main__":
    main()

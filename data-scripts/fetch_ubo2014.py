#!/usr/bin/env python3
"""Fetch a material of Bonn's UBO2014 and convert it: 151 views x 151 lights of 400 x 400 texels in a .btf file.

    python3 data-scripts/fetch_ubo2014.py felt05
    python3 data-scripts/fetch_ubo2014.py leather04 --resampled

Seven classes of twelve materials, as carpet01 … felt12; a material's class is its name without the number. The
address was seen to answer in others' programs. Needs nothing but Python 3.8 or later, and the network.
"""

import sys

from fetching import convert, fetch, options_of

ADDRESS = "https://cg.cs.uni-bonn.de/btf/UBO2014/{kind}/{name}{resampled}_W400xH400_L151xV151.btf"
PAGE = "https://cg.cs.uni-bonn.de/en/projects/btfdbb/download/ubo2014/"
TERMS = "The University of Bonn states its terms on the page; read them first. Size: about 84 MB per material."
# Bytes of the files that others have published; those of all other materials are not known.
SIZES = {
    "carpet02": 83570143,
    "carpet07": 83619582,
    "carpet09": 83747666,
    "carpet12": 83747666,
    "fabric02": 83553711,
    "fabric04": 83553711,
    "fabric09": 82878555,
    "fabric11": 82878555,
    "felt01": 84349585,
    "felt03": 84349585,
    "felt05": 83841579,
    "felt10": 83601338,
}


def main():
    parser = options_of(__doc__, TERMS, PAGE, ADDRESS)
    parser.add_argument("name", help="the material's name, as felt05")
    parser.add_argument("--resampled", action="store_true", help="the file that has `resampled` in its name")
    options = parser.parse_args()
    name = options.name.lower()
    kind = name.rstrip("0123456789")
    if kind == name or not kind.isalpha():
        sys.exit(f"{options.name}: no name and number, as felt05")
    print(TERMS, PAGE)
    resampled = "_resampled" if options.resampled else ""
    size = options.size
    if size is None and options.address is None and not options.resampled:
        size = SIZES.get(name)
    address = options.address or ADDRESS.format(kind=kind, name=name, resampled=resampled)
    file = fetch(address, options.into, size, options.sha256)
    convert(options, file, options.into / f"{name}.sample")


if __name__ == "__main__":
    main()

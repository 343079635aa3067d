#!/usr/bin/env python3
"""Fetch a material of Bonn's UBO2003 and convert it: 81 views x 81 lights, 6561 JPEG images in a zip archive.

    python3 data-scripts/fetch_ubo2003.py IMPALLA

Names that were seen: IMPALLA, WOOL, CORDUROY. The address was seen in others' programs and may have moved;
--address takes another. Needs nothing but Python 3.8 or later, and the network.
"""

from fetching import convert, fetch, options_of

ADDRESS = "http://cg.cs.uni-bonn.de/fileadmin/btf/UBO2003/{name}/ONEFILE/UBO_{name}{side}.zip"
PAGE = "https://cg.cs.uni-bonn.de/en/projects/btfdbb/download/ubo2003/"
TERMS = "The University of Bonn states its terms on the page; read them first. Size: 6561 images of 256 x 256."


def main():
    parser = options_of(__doc__, TERMS, PAGE, ADDRESS)
    parser.add_argument("name", help="the material's name, as IMPALLA")
    parser.add_argument("--side", type=int, default=256, help="texels of a side: 256, or 64 for some")
    options = parser.parse_args()
    name = options.name.upper()
    print(TERMS, PAGE)
    address = options.address or ADDRESS.format(name=name, side=options.side)
    archive = fetch(address, options.into, options.size, options.sha256)
    convert(options, archive, options.into / f"{name.lower()}.sample")


if __name__ == "__main__":
    main()

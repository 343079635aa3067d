#!/usr/bin/env python3
"""Fetch a material of UTIA's BTF database and convert it: PNG (sRGB) or OpenEXR (XYZ) images in an archive.

    python3 data-scripts/fetch_utia.py wool --address https://…/wool.zip

No address is known for sure: take it from the page. UTIA's data may not be passed on.
Needs nothing but Python 3.8 or later, and the network.
"""

from fetching import fetch_archive

PAGE = "http://btf.utia.cas.cz/"
TERMS = (
    "UTIA's data may not be redistributed; read the terms on the page first. "
    "Size: 6561 images and more, by the material."
)

if __name__ == "__main__":
    fetch_archive(__doc__, TERMS, PAGE)

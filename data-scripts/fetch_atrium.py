#!/usr/bin/env python3
"""Fetch a material of Bonn's ATRIUM and convert it: 81 views x 81 lights, JPEG or Radiance HDR in a zip archive.

    python3 data-scripts/fetch_atrium.py CEILING --address https://…/CEILING.zip

Names that were seen: CEILING. No address is known for sure: take it from the page.
Needs nothing but Python 3.8 or later, and the network.
"""

from fetching import fetch_archive

PAGE = "https://cg.cs.uni-bonn.de/en/projects/btfdbb/download/atrium/"
TERMS = (
    "The University of Bonn states its terms on the page; read them first. "
    "Size: 6561 images, JPEG of 800 x 800 or HDR of 256 x 256."
)

if __name__ == "__main__":
    fetch_archive(__doc__, TERMS, PAGE, "what to call the sample, as CEILING")

#!/usr/bin/env python3
"""Fetch a material of Bonn's SPECTRAL set and convert it: spectral OpenEXR images of every view and light.

    python3 data-scripts/fetch_spectral.py red_fabric --address https://…/red_fabric.zip

No address is known for sure: take it from the page. The file may be an archive of the images; a folder that was
unpacked by hand is converted by `mesotex import FOLDER`.
Needs nothing but Python 3.8 or later, and the network.
"""

from fetching import fetch_archive

PAGE = "https://cg.cs.uni-bonn.de/btfdb"
TERMS = "The University of Bonn states its terms on the page; read them first. Size: 6561 images of many bands."

if __name__ == "__main__":
    fetch_archive(__doc__, TERMS, PAGE)

#!/usr/bin/env python3
"""Draws the picture of docs/bake.md: flat texture and relief of every preset.

    tools/draw_presets.py --program target/release/mesotex -o docs/images/presets.png

Bakes each preset at 96 × 96 texels under one view and one light, and lays the upper parts of the previews side by
side at half their size, in the order of the table in docs/bake.md, column by column.

Needs: pip install pillow
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

PRESETS = ("weave", "corduroy", "knit", "wicker", "cobbles", "bricks", "scales", "leather", "hammered", "bark")
# Rows of a preview that show texture and relief; below them is its sheet of views and lights.
ROWS = 220
GAP = 8


def preview(program, preset, folder):
    """Texture and relief of a preset."""
    picture = folder / f"{preset}.png"
    words = (program, "bake", "--preset", preset, "--size", 96, "--views", "fibonacci:1", "--lights", "fibonacci:1",
             "-o", folder / f"{preset}.sample", "--preview", picture, "--quiet")
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)
    image = Image.open(picture).convert("RGB")
    return image.crop((0, 0, image.width, ROWS)).reduce(2)


def sheet(pictures):
    """The pictures in two columns."""
    (width, height), rows = pictures[0].size, len(pictures) // 2
    page = Image.new("RGB", (2 * width + GAP, rows * (height + GAP) - GAP), "white")
    for at, picture in enumerate(pictures):
        page.paste(picture, (at // rows * (width + GAP), at % rows * (height + GAP)))
    return page


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=Path("target/release/mesotex"))
    parser.add_argument("-o", "--output", type=Path, default=Path("presets.png"))
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        sheet([preview(args.program, preset, Path(folder)) for preset in PRESETS]).save(args.output, optimize=True)


if __name__ == "__main__":
    main()

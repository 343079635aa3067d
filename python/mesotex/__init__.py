"""Reads the files of mesotex as NumPy arrays, and runs its commands.

Directions are unit vectors: +x along texture s (image right), +y along texture t (image up), +z out of the
surface. Arrays are row-major with row 0 at the top. Texture coordinates are in texels: s = column + 0.5,
t = H - row - 0.5 at a texel's centre. Values are linear Rec. 709 radiance for a light of unit irradiance: a
white Lambertian plane has cos(theta)/pi.

    import mesotex
    mesotex.run("bake", "--preset", "weave", "--size", 64, "-o", "weave.sample")
    sample = mesotex.read_sample("weave.sample")
    image = sample.image(view=0, light=5)          # [H, W, 3]
    surface = mesotex.read_map("bunny.map.ply")
    rows, columns = surface.texels()
"""

from mesotex._archives import (
    NeighborTable,
    TextonSpace,
    Vocabulary,
    read_space,
    read_table,
    read_vocabulary,
)
from mesotex._errors import DataError
from mesotex._maps import AtlasMap, FaceMap, SurfaceTextonMap, read_atlas, read_faces, read_map
from mesotex._program import CommandError, run
from mesotex._sample import Sample, read_sample

__all__ = [
    "AtlasMap",
    "CommandError",
    "DataError",
    "FaceMap",
    "NeighborTable",
    "Sample",
    "SurfaceTextonMap",
    "TextonSpace",
    "Vocabulary",
    "read_atlas",
    "read_faces",
    "read_map",
    "read_sample",
    "read_space",
    "read_table",
    "read_vocabulary",
    "run",
]

"""What was synthesized: surface texton maps, face maps and atlases."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Optional, Tuple

import numpy as np

from mesotex._errors import check, check_format
from mesotex._ply import columns, read_ply


@dataclass(frozen=True)
class Header:
    """What every map says of itself.

    Attributes:
        exemplar: columns and rows of the sample.
        texel: mesh units per texel of the sample.
        origin: what positions count from, [3].
        seed, method: of the synthesis.
        sample, space: ids of what the map was made from, or None.
    """

    exemplar: Tuple[int, int]
    texel: float
    origin: np.ndarray
    seed: Optional[int]
    method: str
    sample: Optional[str]
    space: Optional[str]


@dataclass(frozen=True)
class SurfaceTextonMap:
    """Texton label and texture coordinate per vertex.

    Attributes:
        header: see Header.
        positions, normals, orientation: [N, 3].
        scale: [N], multiplies `texel`; ones where the file has none.
        coordinates: [N, 2], s and t in texels.
        texton: [N], 65535 where there is none.
        transition, mask: [N], or None.
        faces: [F, 3] vertex indices.
    """

    header: Header
    positions: np.ndarray
    normals: np.ndarray
    orientation: np.ndarray
    scale: np.ndarray
    coordinates: np.ndarray
    texton: np.ndarray
    transition: Optional[np.ndarray]
    mask: Optional[np.ndarray]
    faces: np.ndarray

    def texels(self):
        """Row and column of each vertex's texel, [N] each."""
        return _texels(self.coordinates, self.header.exemplar)

    def uv(self):
        """Texture coordinates over the sample's size, [N, 2]; v points upwards."""
        return self.coordinates / np.array(self.header.exemplar)


@dataclass(frozen=True)
class FaceMap:
    """A colour and a source triangle per face.

    Attributes:
        header: see Header.
        positions: [N, 3].
        faces: [F, 3] vertex indices.
        colors: [F, 3] linear, or None.
        source, phase: [F], see docs/formats.md.
        channels: further columns by name, [F] each.
    """

    header: Header
    positions: np.ndarray
    faces: np.ndarray
    colors: Optional[np.ndarray]
    source: np.ndarray
    phase: np.ndarray
    channels: Dict[str, np.ndarray]


@dataclass(frozen=True)
class AtlasMap:
    """Texture coordinates of the sample per texel of an atlas; row 0 is at the top.

    Attributes:
        header: see Header.
        coordinates: [H, W, 2], s and t in texels of the sample, NaN outside charts.
        texton: [H, W], 65535 outside charts, or None.
        position, normal, orientation: [H, W, 3].
        chart: [H, W], -1 outside.
        vertices, triangles, corner_uvs: the mesh.
        description: atlas.json.
    """

    header: Header
    coordinates: np.ndarray
    texton: Optional[np.ndarray]
    position: np.ndarray
    normal: np.ndarray
    orientation: np.ndarray
    chart: np.ndarray
    vertices: np.ndarray
    triangles: np.ndarray
    corner_uvs: np.ndarray
    description: dict


def _texels(coordinates, exemplar):
    width, height = exemplar
    columns_of = np.floor(coordinates[..., 0]).astype(int)
    rows = np.floor(height - coordinates[..., 1]).astype(int)
    return np.clip(rows, 0, height - 1), np.clip(columns_of, 0, width - 1)


def _header(path, comments):
    for word in ("mesotex", "exemplar", "texel"):
        check(word in comments, path, f"comment {word}", "not there", "a map of mesotex")
    first = {word: (rest or [None])[0] for word, rest in comments.items()}
    return Header(
        exemplar=tuple(int(side) for side in comments["exemplar"][:2]),
        texel=float(first["texel"]),
        origin=np.array([float(x) for x in comments.get("origin", ["0"] * 3)[:3]]),
        seed=int(first["seed"]) if "seed" in first else None,
        method=first.get("method", "k-coherence"),
        sample=first.get("sample"),
        space=first.get("space"),
    )


def read_map(path):
    """Reads NAME.map.ply."""
    comments, vertex, face = read_ply(path)
    names = vertex.dtype.names or ()
    check("texton" in names, path, "vertex", f"properties {names}", "a surface texton map")
    return SurfaceTextonMap(
        header=_header(path, comments),
        positions=columns(vertex, "xyz"),
        normals=columns(vertex, ("nx", "ny", "nz")),
        orientation=columns(vertex, ("sx", "sy", "sz")),
        scale=vertex["scale"] if "scale" in names else np.ones(len(vertex), np.float32),
        coordinates=columns(vertex, "st"),
        texton=vertex["texton"],
        transition=vertex["transition"] if "transition" in names else None,
        mask=vertex["mask"] if "mask" in names else None,
        faces=face["vertex_indices"],
    )


def read_faces(path):
    """Reads NAME.faces.ply."""
    comments, vertex, face = read_ply(path)
    names = face.dtype.names or ()
    check("source" in names, path, "face", f"properties {names}", "a face map")
    own = {"corners", "vertex_indices", "r", "g", "b", "red", "green", "blue", "source", "phase"}
    return FaceMap(
        header=_header(path, comments),
        positions=columns(vertex, "xyz"),
        faces=face["vertex_indices"],
        colors=columns(face, "rgb") if "r" in names else None,
        source=face["source"],
        phase=face["phase"],
        channels={name: face[name] for name in names if name not in own},
    )


def read_atlas(path):
    """Reads NAME.atlas."""
    folder = Path(path)
    description_path = folder / "atlas.json"
    check(description_path.is_file(), folder, "atlas.json", "not there", "a folder NAME.atlas")
    description = json.loads(description_path.read_text(encoding="utf-8"))
    check_format(description_path, description, "mesotex-atlas")
    sides = (description["height"], description["width"])
    coordinates = np.load(folder / "coords.npy")
    check(coordinates.shape == (*sides, 2), folder / "coords.npy", "shape", coordinates.shape, (*sides, 2))
    texton_path = folder / "texton.npy"
    with np.load(folder / "surface.npz") as surface:
        parts = {
            name: surface[name]
            for name in ("position", "normal", "orientation", "chart", "vertices", "triangles", "corner_uvs")
        }
    header = Header(
        exemplar=tuple(description["exemplar"]),
        texel=description["texel"],
        origin=np.array(description.get("origin", [0, 0, 0]), float),
        seed=description.get("seed"),
        method=description.get("method", "k-coherence"),
        sample=description.get("sample"),
        space=description.get("space"),
    )
    return AtlasMap(
        header=header,
        coordinates=coordinates,
        texton=np.load(texton_path) if texton_path.is_file() else None,
        description=description,
        **parts,
    )

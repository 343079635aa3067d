"""Archives of texton analysis: vocabularies, spaces and neighbour tables."""

import json
from dataclasses import dataclass
from typing import List, Optional

import numpy as np

from mesotex._errors import check, check_format


@dataclass(frozen=True)
class VocabularyLevel:
    """One pyramid level: labels [H, W], centroids [nt, D] (appearance vectors), counts [nt]."""

    labels: np.ndarray
    centroids: np.ndarray
    counts: np.ndarray


@dataclass(frozen=True)
class Vocabulary:
    """The 3D textons of a sample, finest level first.

    Attributes:
        levels: one VocabularyLevel each.
        representatives: indices of the images that appearance vectors are made of.
        filters: the filter bank, [48, 49, 49].
        factor_basis: the basis of the centroids of a factored sample, or None.
        meta: options, seed, inertia, ids.
    """

    levels: List[VocabularyLevel]
    representatives: np.ndarray
    filters: np.ndarray
    factor_basis: Optional[np.ndarray]
    meta: dict


@dataclass(frozen=True)
class SpaceLevel:
    """One pyramid level: labels [H, W] and gram [nt + 1, nt + 1], or features [H, W, d]; controls where there are."""

    labels: Optional[np.ndarray]
    gram: Optional[np.ndarray]
    features: Optional[np.ndarray]
    mask: Optional[np.ndarray]
    transition: Optional[np.ndarray]
    orientation: Optional[np.ndarray]


@dataclass(frozen=True)
class TextonSpace:
    """A surface texton space: `kind` is "textons" or "features"; levels finest first."""

    kind: str
    levels: List[SpaceLevel]
    meta: dict


@dataclass(frozen=True)
class TableLevel:
    """One pyramid level: neighbors [H*W, k], flat indices row * W + column, nearest first; distances [H*W, k]."""

    neighbors: np.ndarray
    distances: np.ndarray


@dataclass(frozen=True)
class NeighborTable:
    """The k nearest texels of every texel; levels finest first."""

    levels: List[TableLevel]
    meta: dict


class _Archive:
    """An open .npz with its meta.json."""

    def __init__(self, path, format_name):
        self.path = path
        self.file = np.load(path)
        check("meta.json" in self.file.files, path, "members", "no meta.json", "an archive of mesotex")
        self.meta = json.loads(bytes(self.file["meta.json"]).decode("utf-8"))
        check_format(path, self.meta, format_name)

    def levels(self, member):
        """How many levels hold the member."""
        count = 0
        while f"L{count}/{member}" in self.file.files:
            count += 1
        check(count > 0, self.path, f"L0/{member}", "not there", "at least one level")
        return range(count)

    def __getitem__(self, name):
        return self.file[name]

    def get(self, name):
        """A member, or None."""
        return self.file[name] if name in self.file.files else None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()


def read_vocabulary(path):
    """Reads NAME.textons.npz."""
    with _Archive(path, "mesotex-textons") as archive:
        levels = [
            VocabularyLevel(*(archive[f"L{at}/{part}"] for part in ("labels", "centroids", "counts")))
            for at in archive.levels("labels")
        ]
        return Vocabulary(
            levels=levels,
            representatives=archive["representatives"],
            filters=archive["filters"],
            factor_basis=archive.get("factor_basis"),
            meta=archive.meta,
        )


def read_space(path):
    """Reads NAME.space.npz."""
    with _Archive(path, "mesotex-space") as archive:
        kind = archive.meta["kind"]
        check(kind in ("textons", "features"), path, "kind", repr(kind), "'textons' or 'features'")
        parts = ("labels", "gram", "features", "mask", "transition", "orientation")
        levels = [
            SpaceLevel(**{part: archive.get(f"L{at}/{part}") for part in parts})
            for at in archive.levels("labels" if kind == "textons" else "features")
        ]
        return TextonSpace(kind=kind, levels=levels, meta=archive.meta)


def read_table(path):
    """Reads NAME.knn.npz."""
    with _Archive(path, "mesotex-knn") as archive:
        levels = [
            TableLevel(archive[f"L{at}/neighbors"], archive[f"L{at}/distances"])
            for at in archive.levels("neighbors")
        ]
        return NeighborTable(levels=levels, meta=archive.meta)

"""BTF samples: folders NAME.sample."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import numpy as np

from mesotex._errors import check, check_format


@dataclass(frozen=True)
class Sample:
    """One image per (view, light) pair, all on one texel grid.

    Attributes:
        name: what the material is called.
        views, lights: unit vectors, [V, 3] and [L, 3].
        pairs: [P, 2] indices (view, light) of the images, in their order; None where every view has every light.
        layout: "product", "pairs" or "factored".
        width, height: texels per row, rows.
        texel_mm: side of a texel in millimetres, or None.
        tileable: whether opposite borders continue each other.
        id: what later files name the sample by.
        source: where it comes from; free.
        radiance: mapped array, [V, L, H, W, 3] or [P, H, W, 3]; None with layout "factored".
        heights: [H, W] texels above z = 0, or None where the sample has none.
    """

    name: str
    views: np.ndarray
    lights: np.ndarray
    pairs: Optional[np.ndarray]
    layout: str
    width: int
    height: int
    texel_mm: Optional[float]
    tileable: bool
    id: str
    source: dict
    radiance: Optional[np.ndarray]
    heights: Optional[np.ndarray]
    _factors: Optional["_Factors"] = None

    @property
    def image_count(self):
        """How many images the sample has."""
        if self.pairs is not None:
            return len(self.pairs)
        return len(self.views) * len(self.lights)

    def index(self, view, light):
        """The number of an image; KeyError where the sample has no such pair."""
        if self.pairs is None:
            if not (0 <= view < len(self.views) and 0 <= light < len(self.lights)):
                raise KeyError((view, light))
            return view * len(self.lights) + light
        found = np.flatnonzero((self.pairs == (view, light)).all(axis=1))
        if len(found) == 0:
            raise KeyError((view, light))
        return int(found[0])

    def image(self, view, light):
        """One image, float32 [H, W, 3]."""
        number = self.index(view, light)
        if self._factors is not None:
            return self._factors.image(number).reshape(self.height, self.width, 3)
        images = self.radiance.reshape(-1, self.height, self.width, 3)
        return np.asarray(images[number], np.float32)

    def angles(self):
        """Polar angle and azimuth of views and of lights in degrees, [V, 2] and [L, 2]."""
        return _angles(self.views), _angles(self.lights)


def _angles(directions):
    x, y, z = directions.T
    theta = np.degrees(np.arccos(np.clip(z, -1, 1)))
    return np.stack([theta, np.degrees(np.arctan2(y, x)) % 360], axis=1)


@dataclass(frozen=True)
class _Factors:
    """Image i has the value T v + m at texel x, v_c = U_c[i] . E_c[x], and 0 where that is below 0."""

    directions: np.ndarray
    eigentextures: np.ndarray
    transform: np.ndarray
    mean: np.ndarray

    def image(self, number):
        rows = np.asarray(self.directions[:, number], np.float32)
        eigentextures = np.asarray(self.eigentextures, np.float32)
        # Shared eigentextures serve all three channels.
        planes = np.broadcast_to(eigentextures, (3, *eigentextures.shape[1:]))
        values = np.einsum("cxk,ck->xc", planes, rows)
        return np.maximum(values @ self.transform.T + self.mean, 0).astype(np.float32)


def read_sample(path):
    """Opens a sample. Its images are mapped, not read; those of a factored sample are computed on demand."""
    folder = Path(path)
    description_path = folder / "btf.json"
    check(description_path.is_file(), folder, "btf.json", "not there", "a folder NAME.sample")
    description = json.loads(description_path.read_text(encoding="utf-8"))
    check_format(description_path, description, "mesotex-btf")
    layout = description["layout"]
    known = ("product", "pairs", "factored")
    check(layout in known, description_path, "layout", repr(layout), f"one of {known}")
    views, lights = (np.array(description[key], float).reshape(-1, 3) for key in ("views", "lights"))
    pairs = description.get("pairs")
    pairs = None if pairs is None else np.array(pairs, int).reshape(-1, 2)
    height, width = description["height"], description["width"]
    images = (len(views), len(lights)) if pairs is None else (len(pairs),)
    radiance = factors = None
    if layout == "factored":
        factors = _read_factors(folder, description, int(np.prod(images)), height * width)
    else:
        radiance_path = folder / "radiance.npy"
        radiance = np.load(radiance_path, mmap_mode="r")
        shape = (*images, height, width, 3)
        check(radiance.shape == shape, radiance_path, "shape", radiance.shape, shape)
    return Sample(
        name=description["name"],
        views=views,
        lights=lights,
        pairs=pairs,
        layout=layout,
        width=width,
        height=height,
        texel_mm=description.get("texel_mm"),
        tileable=description["tileable"],
        id=description["id"],
        source=description.get("source", {}),
        radiance=radiance,
        heights=_read_heights(folder, (height, width)),
        _factors=factors,
    )


def _read_factors(folder, description, images, texels):
    rank = description["rank"]
    sets = 1 if description.get("shared_eigentextures") else 3
    arrays = {}
    for name, shape in (("directions", (3, images, rank)), ("eigentextures", (sets, texels, rank))):
        path = folder / f"{name}.npy"
        arrays[name] = np.load(path, mmap_mode="r")
        check(arrays[name].shape == shape, path, "shape", arrays[name].shape, shape)
    transform = np.array(description.get("color_transform", np.eye(3)), float).reshape(3, 3)
    mean = np.array(description.get("color_mean", np.zeros(3)), float)
    return _Factors(arrays["directions"], arrays["eigentextures"], transform, mean)


def _read_heights(folder, shape):
    path = folder / "height.npy"
    if not path.is_file():
        return None
    heights = np.load(path, mmap_mode="r")
    check(heights.shape == shape, path, "shape", heights.shape, shape)
    return heights

"""Decorated surfaces in scenes of Mitsuba 3: a sample on a surface texton map as a BSDF.

    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    import mesotex.mitsuba

    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path"},
        "sensor": {...},
        "sky": {"type": "constant"},
        "bunny": mesotex.mitsuba.shape("weave.sample", "bunny.map.ply"),
    })

The plugin is called `mesotex`. It evaluates what `mesotex render --shading pixel --weights continuous --mip off
--parallax off` does: at a point, each vertex of the triangle continues its own texture coordinate, takes the view and the
light in its own frame, and blends the nearest images; the three are blended by barycentric weights. Both sides of a surface
are shown. Light is taken as red, green and blue, so the variants that work are `llvm_ad_rgb` and `cuda_ad_rgb`.

Needs: pip install mitsuba; for `llvm_ad_rgb` LLVM's library of version 16 or later (Debian 12: apt-get install libllvm19).
"""

import math
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi  # First: without it, this is the module that is missing.
import drjit as dr
import numpy as np

from mesotex._errors import check
from mesotex._maps import read_map
from mesotex._sample import read_sample

NAME = "mesotex"

# Older ones end the process: they lack an instruction that Mitsuba uses.
_LLVM = (16,)
# Directions that are nearer to each other count as one, in radians.
_SAME_DIRECTION = 1e-4
# The reach of a blend is this many times the angle to the direction of this rank.
_REACH, _RANK = 1.05, 5
# Of the linear fit: what is added to the diagonal, over its mean.
_RIDGE = 1e-3
# Values are scaled to the wanted light by the ratio of cosines, at most this.
_LARGEST_RATIO = 2.0
# How fast negative weights come in below the lowest sampled light.
_EXTRAPOLATION = 4.0
# Cells per side of the map of directions; even, so that no cell lies on a fold of the octahedron.
_CELLS = 32
# Views below the horizon are lifted to this angle above it, in radians.
_LIFT = 1e-3


def register():
    """Makes the plugin known to the current variant of Mitsuba. Call it again after `set_variant`."""
    variant = mi.variant()
    if variant is None or not (variant.endswith("_rgb") and "_ad_" in variant):
        raise RuntimeError(f"Mitsuba's variant is {variant}; expected llvm_ad_rgb or cuda_ad_rgb (mitsuba.set_variant)")
    if variant.startswith("llvm") and dr.detail.llvm_version() < _LLVM:
        found = ".".join(map(str, dr.detail.llvm_version()))
        raise RuntimeError(f"LLVM's library is of version {found}; expected {_LLVM[0]} or later: set DRJIT_LIBLLVM_PATH to the path of one")
    mi.register_bsdf(NAME, _plugin())


def shape(sample, surface, to_world=None, texels="bilinear"):
    """A decorated mesh, an object for `mitsuba.load_dict`. It has the texture coordinates of the map, over the sample's size.

    `sample` and `surface` are paths, NAME.sample and NAME.map.ply; `to_world` is a `mitsuba.ScalarTransform4f` that
    moves, turns and scales evenly; `texels` is "bilinear" or "nearest".
    """
    register()
    to_world = mi.ScalarTransform4f() if to_world is None else to_world
    bsdf = {"type": NAME, "sample": str(sample), "map": str(surface), "to_world": to_world, "texels": texels}
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    found = read_map(surface)
    counts = (len(found.positions), len(found.faces))
    mesh = mi.Mesh(Path(surface).name, *counts, properties, has_vertex_normals=True, has_vertex_texcoords=True)
    parameters = mi.traverse(mesh)
    matrix = np.array(to_world.matrix, float)
    parameters["vertex_positions"] = _flat(found.positions @ matrix[:3, :3].T + matrix[:3, 3])
    normals = found.normals @ np.linalg.inv(matrix[:3, :3])
    parameters["vertex_normals"] = _flat(normals / np.linalg.norm(normals, axis=1, keepdims=True))
    parameters["vertex_texcoords"] = _flat(found.uv())
    parameters["faces"] = _flat(found.faces, mi.UInt32)
    parameters.update()
    return mesh


def _plugin():
    """The class, made for the current variant: its base and all types depend on it."""

    class DecoratedSurface(mi.BSDF):
        """See the module. Properties: sample, map, to_world, texels. The shape must be the map's own mesh."""

        def __init__(self, properties):
            mi.BSDF.__init__(self, properties)
            flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            flags |= mi.BSDFFlags.SpatiallyVarying
            self.m_components = [flags]
            self.m_flags = flags
            self.path = properties["map"]
            self.surface = _Surface(self.path, properties.get("to_world", mi.ScalarTransform4f()))
            self.blend = _Blend(properties["sample"], self.surface, properties.get("texels", "bilinear"))

        def sample(self, context, si, component, point, active):
            """Directions by the cosine, on the side of the facet that is seen."""
            found = mi.BSDFSample3f()
            side = self.side(si)
            local = mi.warp.square_to_cosine_hemisphere(point)
            found.wo = mi.Vector3f(local.x, local.y, local.z * side)
            found.pdf = mi.warp.square_to_cosine_hemisphere_pdf(local)
            found.eta = 1.0
            found.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
            found.sampled_component = mi.UInt32(0)
            active &= found.pdf > 0
            value = self.eval(context, si, found.wo, active) / found.pdf
            return found, dr.select(active, value, 0)

        def eval(self, context, si, wo, active):
            """The sample's value, in which the cosine is."""
            surface = self.surface
            place, corners, shares, facet = surface.at(si, active)
            viewer, light = (surface.direction(si.to_world(d)) for d in (si.wi, wo))
            is_inside = dr.dot(facet, viewer) < 0
            value = mi.Color3f(0)
            for corner, share in zip(corners, shares):
                frame = surface.frame(corner, is_inside, active)
                coordinate = surface.continued(corner, frame, place, active)
                value += share * self.blend.at(coordinate, frame.to_local(viewer), frame.to_local(light), active)
            return dr.select(active, value, 0)

        def pdf(self, context, si, wo, active):
            """The density of `sample`."""
            density = mi.warp.square_to_cosine_hemisphere_pdf(mi.Vector3f(wo.x, wo.y, wo.z * self.side(si)))
            return dr.select(active & (wo.z * self.side(si) > 0), density, 0)

        def eval_pdf(self, context, si, wo, active):
            """Both."""
            return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

        def side(self, si):
            """1 where the outside of the surface is seen, -1 where the inside is."""
            return dr.select(dr.dot(si.n, si.to_world(si.wi)) < 0, mi.Float(-1), mi.Float(1))

        def to_string(self):
            return f"DecoratedSurface[map = {self.path}]"

    return DecoratedSurface


class _Surface:
    """A surface texton map on the device: frames and texture coordinates per vertex, triangles."""

    def __init__(self, path, to_world):
        surface = read_map(path)
        self.header, self.path = surface.header, path
        check(len(surface.faces) > 0, path, "face", "none", "triangles")
        self.faces = _flat(surface.faces, mi.UInt32)
        self.positions, self.normals, self.orientation, self.coordinates = (
            _flat(table)
            for table in (surface.positions, surface.normals, surface.orientation, surface.coordinates)
        )
        self.texel = _flat(surface.scale * surface.header.texel)
        self.from_world = mi.Transform4f(to_world.inverse().matrix)

    def direction(self, in_world):
        """A unit direction of the world in the map's space."""
        return dr.normalize(self.from_world @ in_world)

    def at(self, si, active):
        """A point in the map's space, its triangle's vertices, barycentric weights and facet normal."""
        place = self.from_world @ si.p
        corners = dr.gather(mi.Vector3u, self.faces, si.prim_index, active)
        a, b, c = (dr.gather(mi.Point3f, self.positions, corner, active) for corner in corners)
        facet = dr.cross(b - a, c - a)
        whole = dr.rcp(dr.maximum(dr.squared_norm(facet), dr.smallest(mi.Float)))
        of_b = dr.dot(dr.cross(place - a, c - a), facet) * whole
        of_c = dr.dot(dr.cross(b - a, place - a), facet) * whole
        return place, corners, (1 - of_b - of_c, of_b, of_c), facet

    def frame(self, vertex, is_inside, active):
        """s, t and n of a vertex; n is turned where the inside is seen."""
        n = dr.gather(mi.Normal3f, self.normals, vertex, active)
        s = dr.gather(mi.Vector3f, self.orientation, vertex, active)
        return mi.Frame3f(s, dr.cross(n, s), dr.select(is_inside, -n, n))

    def continued(self, vertex, frame, place, active):
        """The vertex's texture coordinate, continued to a point."""
        offset = place - dr.gather(mi.Point3f, self.positions, vertex, active)
        along = mi.Point2f(dr.dot(offset, frame.s), dr.dot(offset, frame.t))
        texel = dr.gather(mi.Float, self.texel, vertex, active)
        return dr.gather(mi.Point2f, self.coordinates, vertex, active) + along / texel


class _Blend:
    """A sample on the device, and the blend of its nearest images."""

    def __init__(self, path, surface, texels):
        sample = read_sample(path)
        is_product = sample.pairs is None
        check(is_product, path, "layout", "pairs", "a product of views and lights; `mesotex render` draws scattered pairs")
        check(texels in ("bilinear", "nearest"), path, "texels", repr(texels), "bilinear or nearest")
        header, size = surface.header, (sample.width, sample.height)
        check(header.exemplar == size, surface.path, "exemplar", header.exemplar, f"{size}, the size of {path}")
        check(header.sample in (None, sample.id), surface.path, "sample", header.sample, f"{sample.id}, the id of {path}")
        self.width, self.height = size
        self.is_tileable, self.is_bilinear = sample.tileable, texels == "bilinear"
        views, lights = _distinct(sample.views), _distinct(sample.lights)
        self.views = _Directions(sample.views[views])
        self.lights = _Directions(sample.lights[lights])
        self.table = _flat(_texel_table(sample, views, lights))

    def at(self, coordinate, view, light, active):
        """The blended value at a texture coordinate; view and light in the vertex's frame."""
        light = dr.normalize(light)
        active = active & (light.z > 0)
        # Lanes that are dark or see nothing are computed for directions that exist, and dropped at the end.
        overhead = mi.Vector3f(0, 0, 1)
        light = dr.select(active, light, overhead)
        rows = self.views.fit(dr.select(active, _lifted(dr.normalize(view)), overhead))
        columns = self.lights.fit(light, are_lights=True)
        texels = self.texels(coordinate)
        values = self.sums([texel for texel, _ in texels], rows, columns, active)
        total = mi.Color3f(0)
        for value, (_, share) in zip(values, texels):
            total += share * dr.maximum(value, 0)
        return dr.select(active, total, 0)

    def texels(self, coordinate):
        """The texels round a coordinate as flat indices, each with its share."""
        column, row = coordinate.x, self.height - coordinate.y
        if not self.is_bilinear:
            return [(self.texel(dr.floor(row), dr.floor(column)), mi.Float(1))]
        top, left = dr.floor(row - 0.5), dr.floor(column - 0.5)
        down, right = row - 0.5 - top, column - 0.5 - left
        return [
            (self.texel(top + i, left + j), (down if i else 1 - down) * (right if j else 1 - right))
            for i in (0, 1)
            for j in (0, 1)
        ]

    def texel(self, row, column):
        """The flat index of a texel, wrapped where the sample is tileable, else clamped."""

        def kept(index, length):
            if self.is_tileable:
                index = index - length * dr.floor(index / length)
            return mi.UInt32(dr.clip(index, 0, length - 1))

        return kept(row, self.height) * self.width + kept(column, self.width)

    @dr.syntax
    def sums(self, texels, rows, columns, active):
        """The images' values at texels, summed by weight."""
        totals = [mi.Color3f(0) for _ in texels]
        i = mi.UInt32(rows.start)
        while active & (i < rows.end):
            row, row_weight = self.views.weight(rows, i)
            j = mi.UInt32(columns.start)
            while (row_weight != 0) & (j < columns.end):
                column, weight = self.lights.weight(columns, j)
                weight *= row_weight
                image = row * self.lights.count + column
                totals = self.added(totals, texels, image, weight)
                j += 1
            i += 1
        return totals

    def added(self, totals, texels, image, weight):
        """Sums with one more image."""
        images = self.views.count * self.lights.count
        value = [dr.gather(mi.Color3f, self.table, texel * images + image, weight != 0) for texel in texels]
        return [total + weight * more for total, more in zip(totals, value)]


@dataclass
class _Fit:
    """The weights of directions about a wanted one: near * (1 - place . tilt) * scale, with negative ones times `negative`."""

    frame: object
    start: object
    end: object
    nearest: object
    reach: object
    tilt: object
    negative: object
    scale: object
    are_lights: bool


class _Directions:
    """Distinct directions and the weights of those near a wanted one.

    A linear function is fitted to the values at directions nearer than 1.05 times the 5th nearest, weighted by nearness
    ((R - d)/(R d))^2, and read off at the wanted direction (docs/rendering.md).
    """

    def __init__(self, directions):
        self.count = len(directions)
        self.table = _flat(directions)
        self.lowest = float(directions[:, 2].min())
        starts, lists = _candidates(directions)
        self.starts, self.lists = _flat(starts, mi.UInt32), _flat(lists, mi.UInt32)

    def fit(self, wanted, are_lights=False):
        """The fit about a unit direction above the horizon."""
        plane = mi.Vector2f(wanted.x, wanted.y) / (dr.abs(wanted.x) + dr.abs(wanted.y) + wanted.z)
        column, row = (mi.UInt32(dr.clip((0.5 + 0.5 * at) * _CELLS, 0, _CELLS - 1)) for at in plane)
        cell = row * _CELLS + column
        start, end = (dr.gather(mi.UInt32, self.starts, cell + more) for more in (0, 1))
        nearest, reach = self.reach(wanted, start, end)
        negative = mi.Float(0)
        if are_lights:
            negative = dr.clip(_EXTRAPOLATION * (1 - wanted.z / self.lowest), 0, 1)
        level, one = mi.Vector2f(0), mi.Float(1)
        fit = _Fit(mi.Frame3f(wanted), start, end, nearest, reach, level, negative, one, are_lights)
        fit.tilt = self.tilt(fit)
        fit.scale = dr.rcp(self.whole(fit))
        return fit

    def seen_from(self, wanted, candidate):
        """A candidate's index, direction and angle from the wanted one."""
        index = dr.gather(mi.UInt32, self.lists, candidate)
        found = dr.gather(mi.Vector3f, self.table, index)
        return index, found, 2 * dr.asin(dr.minimum(0.5 * dr.norm(found - wanted), 1))

    def near(self, fit, candidate):
        """A candidate's index, direction, nearness and log-map coordinates over R."""
        index, found, angle = self.seen_from(fit.frame.n, candidate)
        # A direction that is the wanted one takes all the weight.
        is_only = fit.nearest < _SAME_DIRECTION
        angle_or_more = dr.maximum(angle, 1e-9)
        fading = (fit.reach - angle) / (fit.reach * angle_or_more)
        near = dr.select(angle < fit.reach, fading * fading, 0)
        near = dr.select(is_only, dr.select(angle <= fit.nearest, mi.Float(1), mi.Float(0)), near)
        along = mi.Vector2f(dr.dot(found, fit.frame.s), dr.dot(found, fit.frame.t))
        place = along * (angle / (fit.reach * dr.maximum(dr.norm(along), 1e-9)))
        return index, found, near, dr.select(is_only, mi.Vector2f(0), place)

    def weight(self, fit, candidate):
        """A candidate's index and weight."""
        index, found, near, place = self.near(fit, candidate)
        weight = near * (1 - dr.dot(place, fit.tilt)) * fit.scale
        weight = dr.select(weight < 0, weight * fit.negative, weight)
        if fit.are_lights:
            weight *= dr.minimum(fit.frame.n.z / dr.maximum(found.z, 1e-9), _LARGEST_RATIO)
        return index, weight

    @dr.syntax
    def reach(self, wanted, start, end):
        """The angle to the nearest direction, and the one within which directions count."""
        ranked = [mi.Float(dr.inf) for _ in range(_RANK)]
        i = mi.UInt32(start)
        while i < end:
            _, _, angle = self.seen_from(wanted, i)
            ranked = _inserted(ranked, angle)
            i += 1
        return ranked[0], dr.minimum(_REACH * ranked[-1], dr.pi)

    @dr.syntax
    def tilt(self, fit):
        """The slope of the fit."""
        whole, i = mi.Float(0), mi.UInt32(fit.start)
        mean, squares, product = mi.Vector2f(0), mi.Vector2f(0), mi.Float(0)
        while i < fit.end:
            _, _, near, place = self.near(fit, i)
            whole += near
            mean += near * place
            squares += near * place * place
            product += near * place.x * place.y
            i += 1
        scale = dr.rcp(whole)
        mean, squares, product = mean * scale, squares * scale, product * scale
        squares += _RIDGE * (1 + squares.x + squares.y) / 3
        determinant = squares.x * squares.y - product * product
        return mi.Vector2f(
            (squares.y * mean.x - product * mean.y) / determinant,
            (squares.x * mean.y - product * mean.x) / determinant,
        )

    @dr.syntax
    def whole(self, fit):
        """The sum of the weights before they are scaled, without the ratios of cosines."""
        whole, i = mi.Float(0), mi.UInt32(fit.start)
        while i < fit.end:
            _, _, near, place = self.near(fit, i)
            weight = near * (1 - dr.dot(place, fit.tilt))
            whole += dr.select(weight < 0, weight * fit.negative, weight)
            i += 1
        return whole


def _candidates(directions):
    """For each cell of an octahedral map of the hemisphere all directions that count somewhere in it.

    Returns where each cell's list begins, and the lists, one behind the other.
    """
    edges = np.linspace(-1, 1, _CELLS + 1)

    def lifted(u, v):
        points = np.stack([u, v, 1 - abs(u) - abs(v)], -1)
        return points / np.linalg.norm(points, axis=-1, keepdims=True)

    # Edges of cells are great circles, so that a corner is the farthest point from the middle.
    middle = (edges[1:] + edges[:-1]) / 2
    centres = lifted(*np.meshgrid(middle, middle)).reshape(-1, 1, 3)
    corners = lifted(*np.meshgrid(edges, edges))
    corners = np.stack([corners[i : i + _CELLS, j : j + _CELLS].reshape(-1, 3) for i in (0, 1) for j in (0, 1)], 1)
    radius = _angles(corners, centres).max(axis=1)
    angles = _angles(directions[None], centres)
    if len(directions) < _RANK:
        counts = np.ones(angles.shape, bool)
    else:
        reach = _REACH * (np.partition(angles, _RANK - 1, axis=1)[:, _RANK - 1] + radius)
        counts = angles <= (reach + radius + 1e-5)[:, None]
    starts = np.concatenate([[0], np.cumsum(counts.sum(axis=1))])
    return starts, np.nonzero(counts)[1]


def _angles(a, b):
    return 2 * np.arcsin(np.minimum(np.linalg.norm(a - b, axis=-1) / 2, 1))


def _inserted(ranked, number):
    """A rising list with a number put in and the largest left out."""
    kept = []
    for known in ranked:
        kept.append(dr.minimum(known, number))
        number = dr.maximum(known, number)
    return kept


def _lifted(view):
    """A view, not below the horizon."""
    level = dr.normalize(mi.Vector2f(view.x, view.y) + mi.Vector2f(1e-20, 0))
    lifted = mi.Vector3f(level.x * math.cos(_LIFT), level.y * math.cos(_LIFT), math.sin(_LIFT))
    return dr.select(view.z < 0, lifted, view)


def _distinct(directions):
    """The first of each cluster of directions that are the same, as indices."""
    kept = []
    for index, direction in enumerate(directions):
        if not (_angles(directions[kept], direction) < _SAME_DIRECTION).any():
            kept.append(index)
    return kept


def _texel_table(sample, views, lights):
    """All images texel by texel, float32 [H, W, V, L, 3]."""
    table = np.empty((sample.height, sample.width, len(views), len(lights), 3), np.float32)
    for row, view in enumerate(views):
        for column, light in enumerate(lights):
            table[:, :, row, column] = sample.image(view, light)
    return table


def _flat(array, kind=None):
    """A NumPy array as a flat array of the device."""
    kind = kind or mi.Float
    return kind(np.ascontiguousarray(array).ravel().astype(np.uint32 if kind is mi.UInt32 else np.float32))

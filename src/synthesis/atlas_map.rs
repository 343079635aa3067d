//! The atlas map of a target that is an atlas: what its sites hold, texel by texel.

use glam::Vec3;

use crate::index::TextonLabel;
use crate::maps::atlas_map::AtlasMap;
use crate::maps::header::MapHeader;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::reading::varying;
use crate::sites::atlas::preparation::AtlasSurface;

/// The atlas map of a surface whose sites hold what the vertices of `map` do, in the same order; `tileable`
/// says whether the borders of the sample continue each other.
pub fn atlas_map(surface: &AtlasSurface, map: &SurfaceTextonMap, tileable: bool) -> AtlasMap {
    // Find the texel of each site.
    let points = &surface.points;
    let texels = Texels {
        texels: &surface.texels,
        count: points.triangle.len(),
    };
    let charts: Vec<i32> = surface.charts.iter().map(|&chart| chart as i32).collect();
    let coords: Vec<_> = map.coords.iter().copied().map(Some).collect();
    // Spread what the sites hold over the image.
    AtlasMap {
        mesh: surface.mesh.clone(),
        vertex_normals: surface.vertex_normals.clone(),
        corner_uvs: surface.atlas.corner_uvs.clone(),
        chart_of: surface.atlas.chart_of.clone(),
        width: points.width,
        height: points.height,
        chart: texels.spread(&charts, -1),
        position: texels.spread(&surface.positions, Vec3::ZERO),
        normal: texels.spread(&surface.normals, Vec3::ZERO),
        orientation: texels.spread(&surface.orientations, Vec3::ZERO),
        scale: varying(surface.scale.as_deref()).map(|scale| texels.spread(scale, 1.0)),
        coords: texels.spread(&coords, None),
        textons: texels.spread(&map.textons, TextonLabel::NONE),
        tileable,
        header: MapHeader {
            origin: map.header.origin,
            exemplar: map.header.exemplar,
            texel: map.header.texel,
            seed: map.header.seed,
            method: map.header.method.clone(),
            polish: map.header.polish,
            sample: map.header.sample.clone(),
            space: map.header.space.clone(),
        },
    }
}

/// The texels that are sites.
struct Texels<'a> {
    texels: &'a [u32],
    count: usize,
}

impl Texels<'_> {
    /// A list per site as one per texel.
    fn spread<T: Copy>(&self, of_sites: &[T], elsewhere: T) -> Vec<T> {
        let mut all = vec![elsewhere; self.count];
        for (&texel, &value) in self.texels.iter().zip(of_sites) {
            all[texel as usize] = value;
        }
        all
    }
}

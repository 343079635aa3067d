//! What pixel shading finds of the view alone: the points of the surface that pixels see.
//!
//! In: what the samples of an image see. Out: for each piece of surface in a pixel its point, and
//! the point's place in the frame and on the sample of each vertex of its triangle. Found band by
//! band of the image; while the view stays, and memory allows, kept.

use glam::Vec3;
use macro_rules_attribute::apply;
use rayon::prelude::*;

use crate::grid::TexCoord;
use crate::lanes::vectorized;
use crate::render::fragment::{Pieces, SampleSet, point};
use crate::render::nearest::{Scratch, Weight, lifted};
use crate::render::raster::{Hit, SurfaceBuffer};
use crate::render::vertex_frame::Axes;
use crate::render::vertex_shading::ShadingScene;

/// Pixels whose points are kept at most: a quarter of a kilobyte each.
const KEPT: usize = 1 << 20;

/// A point that a pixel sees.
#[derive(Clone, Copy, Debug)]
pub struct SeenPoint {
    /// The triangle and the place on it.
    pub hit: Hit,
    /// The samples of its pixel that it stands for; none where it is of no pixel.
    pub samples: SampleSet,
    /// Where it is.
    pub place: Vec3,
    /// Whether the [inside](crate::render::sides) of the triangle is seen.
    pub turned: bool,
    /// As the triangle's three vertices see it.
    pub corners: [SeenCorner; 3],
}

/// A vertex of a point's triangle, continued to the point.
#[derive(Clone, Copy, Debug, Default)]
pub struct SeenCorner {
    /// The view in the vertex's frame, above its horizon.
    pub view: Vec3,
    /// Its weights: where their list begins and ends.
    weights: [u32; 2],
    /// The texture coordinate at the point.
    pub coord: TexCoord,
    /// How many pyramid levels up the pixel's footprint is as large as a texel.
    pub detail: f32,
}

/// Points and the lists of their views' weights.
#[derive(Debug, Default)]
pub struct SeenPoints {
    /// Each with the pixel that sees it, counted from the band's first, and its share of it.
    points: Vec<(u32, f32, SeenPoint)>,
    weights: Vec<Weight>,
    scratch: Scratch,
    found: Vec<Weight>,
}

/// The points of an image, band by band.
#[derive(Debug)]
pub struct KeptPoints {
    /// In the order of the surface's bands.
    pub bands: Vec<SeenPoints>,
}

impl KeptPoints {
    /// Finds all points, if they are not too many to be kept.
    pub fn find(scene: &ShadingScene, surface: &SurfaceBuffer) -> Option<Self> {
        let find = |band: usize| {
            let mut points = SeenPoints::default();
            points.find_band(scene, surface, band);
            points
        };
        let is_little = surface.covered_pixels() <= KEPT;
        is_little.then(|| Self {
            bands: (0..surface.bands()).into_par_iter().map(find).collect(),
        })
    }
}

impl SeenPoints {
    /// Drops all points.
    pub fn forget(&mut self) {
        self.points.clear();
        self.weights.clear();
    }

    /// Finds the points of a band in place of those known.
    pub fn find_band(&mut self, scene: &ShadingScene, surface: &SurfaceBuffer, band: usize) {
        self.forget();
        let order = surface.by_distance();
        surface.visit_band(band, |pixel, hits| {
            if scene.progress.is_interrupted() {
                return;
            }
            let pieces = Pieces::of_pixel(&scene.map.mesh, scene.view, hits, order);
            for (piece, hit) in pieces.hits().iter().enumerate() {
                let point = SeenPoint {
                    samples: pieces.samples(piece),
                    ..self.see(scene, hit)
                };
                let share = pieces.share(piece);
                self.points.push((pixel as u32, share, point));
            }
        });
    }

    /// The points, each with its pixel and its share of it.
    pub fn points(&self) -> &[(u32, f32, SeenPoint)] {
        &self.points
    }

    /// The view's weights at a corner.
    #[inline(always)]
    pub fn weights(&self, corner: &SeenCorner) -> &[Weight] {
        let [start, end] = corner.weights;
        &self.weights[start as usize..end as usize]
    }

    /// Finds what the view has to do with a point; the lists join those known.
    pub fn see(&mut self, scene: &ShadingScene, hit: &Hit) -> SeenPoint {
        see(self, scene, hit)
    }
}

#[apply(vectorized!)]
fn see(known: &mut SeenPoints, scene: &ShadingScene, hit: &Hit) -> SeenPoint {
    // Find the point and its frame.
    let map = scene.map;
    let place = point(&map.mesh, hit);
    let viewer = scene.view.towards_viewer(place.as_dvec3());
    let turned = scene.turns(hit.triangle, place);
    // Weight the views at each corner of the triangle.
    let mut corners = [SeenCorner::default(); 3];
    let triangle = &map.mesh.triangles[hit.triangle as usize];
    for (corner, &vertex) in corners.iter_mut().zip(triangle) {
        let vertex = vertex as usize;
        let axes = Axes::of_vertex(map, vertex).turned(turned);
        let view = axes.local(viewer);
        let above = lifted(view);
        let (scratch, found) = (&mut known.scratch, &mut known.found);
        scene.lookup.view_weights(above, scratch, found);
        let start = known.weights.len() as u32;
        known.weights.extend_from_slice(found);
        let texel = map.texel_at(vertex);
        let (along_s, along_t) = axes.offset(place - map.mesh.positions[vertex]);
        *corner = SeenCorner {
            view: above.as_vec3(),
            weights: [start, known.weights.len() as u32],
            coord: TexCoord {
                s: map.coords[vertex].s + (along_s / texel) as f32,
                t: map.coords[vertex].t + (along_t / texel) as f32,
            },
            detail: scene.detail(place, view.z, texel),
        };
    }
    SeenPoint {
        hit: *hit,
        samples: SampleSet::default(),
        place,
        turned,
        corners,
    }
}

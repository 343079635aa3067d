//! The weights of lights' images at vertices: found once for all pixels that blend the vertices,
//! and kept while the lights stay.
//!
//! In: lights, and the vertices that a view sees. Out: a list of weights for each light and vertex.
//! A directional light stands in the same direction of a vertex's frame whatever the pixel. Point
//! lights have no lists, nor have scattered samples, whose weights depend on the view as well.

use rayon::prelude::*;

use crate::render::known_weights::{KnownWeights, Lists, UNKNOWN};
use crate::render::light::{Light, Origin};
use crate::render::nearest::{Scratch, Weight};
use crate::render::vertex_frame::Axes;
use crate::render::vertex_shading::{ShadingScene, Site};

/// Vertices of one task.
const CHUNK: usize = 1 << 12;
/// Lights that have lists, at most: it bounds the memory.
const LISTED: usize = 8;

/// Lists of weights, by light and vertex, of the lights asked for last.
#[derive(Debug, Default)]
pub struct VertexLights {
    origins: Vec<Origin>,
    of_lights: Vec<Option<Lists>>,
    /// Whether all vertices have lists, not only those that a view saw.
    is_whole: bool,
}

impl VertexLights {
    /// Finds the weights of a scene's lights at the vertices it will need: those it `needs` when
    /// the lights are new, `all` when they stay, since then the view moves.
    pub fn refresh(&mut self, scene: &ShadingScene, needs: &[Site], all: &[Site]) {
        let origins = scene.lights.iter().map(|light| light.origin);
        let stay = self.origins.iter().copied().eq(origins.clone());
        if stay && self.is_whole {
            return;
        }
        let sites = if stay { all } else { needs };
        *self = Self {
            origins: origins.collect(),
            of_lights: lists_of(scene, sites),
            is_whole: stay,
        };
    }

    /// What is known of all lights.
    pub fn all(&self) -> KnownWeights<'_> {
        KnownWeights(&self.of_lights)
    }
}

fn lists_of(scene: &ShadingScene, sites: &[Site]) -> Vec<Option<Lists>> {
    if scene.lookup.is_scattered() || sites.is_empty() {
        return Vec::new();
    }
    let listed = scene.lights.iter().take(LISTED);
    let lists = listed.map(|light| match light.origin {
        Origin::Directional { .. } => Some(find(scene, light, sites)),
        Origin::Point { .. } => None,
    });
    lists.collect()
}

/// The lists of a light at some vertices.
fn find(scene: &ShadingScene, light: &Light, sites: &[Site]) -> Lists {
    let chunks: Vec<(Vec<u32>, Vec<Weight>)> = sites
        .par_chunks(CHUNK)
        .map(|sites| weights_of(scene, light, sites))
        .collect();
    let mut lists = Lists {
        of_vertex: vec![UNKNOWN; scene.map.mesh.positions.len()],
        weights: Vec::with_capacity(chunks.iter().map(|(_, weights)| weights.len()).sum()),
    };
    for (sites, (ends, weights)) in sites.chunks(CHUNK).zip(chunks) {
        let first = lists.weights.len() as u32;
        let mut start = first;
        for (site, end) in sites.iter().zip(ends) {
            lists.of_vertex[site.vertex as usize] = [start, first + end];
            start = first + end;
        }
        lists.weights.extend(weights);
    }
    lists
}

/// The lists of some vertices, one after another, and where each ends.
fn weights_of(scene: &ShadingScene, light: &Light, sites: &[Site]) -> (Vec<u32>, Vec<Weight>) {
    let (mut ends, mut weights) = (Vec::with_capacity(sites.len()), Vec::new());
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    for site in sites {
        let towards = light.at(site.point).towards.as_dvec3();
        let local = Axes::of_vertex(scene.map, site.vertex as usize).local(towards);
        if local.z > 0.0 {
            scene.lookup.light_weights(local, &mut scratch, &mut found);
            weights.extend_from_slice(&found);
        }
        ends.push(weights.len() as u32);
    }
    (ends, weights)
}

//! Whether the elements of a texture stay whole (Zhang 2003 §5): the connected components of its mask, and how
//! many of them are mere fragments.

use serde::Serialize;

use crate::exemplar::space::Space;
use crate::grid::TexCoord;
use crate::index::TexelIndex;
use crate::mesh::topology::{find, join};
use crate::sites::level::SiteEdge;

/// A component is a fragment when it is smaller than this share of the median.
const FRAGMENT: f64 = 0.1;

/// The components of a mask; label 0 is what lies between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fragments {
    /// Connected components on the surface.
    pub components: usize,
    /// Those smaller than a tenth of the median one.
    pub fragments: usize,
    /// Their share of the components.
    pub fragment_share: f64,
    /// The same share in the exemplar.
    pub exemplar_fragment_share: f64,
}

/// Measures a map whose exemplar has a mask.
pub fn measure(
    space: &Space,
    coords: &[TexCoord],
    edges: &[SiteEdge],
    areas: &[f32],
) -> Option<Fragments> {
    // Count the elements of the map.
    let mask = space.controls.first()?.mask.as_ref()?.as_slice()?;
    let grid = space.levels[0].grid;
    let labels = coords
        .iter()
        .map(|&at| mask[grid.texel_nearest(at).index()]);
    let labels: Vec<u8> = labels.collect();
    let pairs = edges.iter().map(|edge| [edge.from, edge.to]);
    let (components, fragments) = fragments(&labels, pairs, areas);
    // Count those of the exemplar.
    let of_exemplar = (0..grid.len() as u32).flat_map(|texel| {
        let beside =
            [(0, 1), (1, 0)].map(|(drow, dcol)| grid.offset(TexelIndex(texel), drow, dcol));
        beside
            .into_iter()
            .flatten()
            .map(move |other| [texel, other.0])
    });
    let (in_exemplar, of_them) = self::fragments(mask, of_exemplar, &vec![1.0; mask.len()]);
    let share = |part: usize, all: usize| part as f64 / all.max(1) as f64;
    Some(Fragments {
        components,
        fragments,
        fragment_share: share(fragments, components),
        exemplar_fragment_share: share(of_them, in_exemplar),
    })
}

/// How many components there are, and how many of them are fragments.
fn fragments(
    labels: &[u8],
    pairs: impl Iterator<Item = [u32; 2]>,
    areas: &[f32],
) -> (usize, usize) {
    let mut root: Vec<u32> = (0..labels.len() as u32).collect();
    for [a, b] in pairs {
        if labels[a as usize] == labels[b as usize] {
            join(&mut root, a, b);
        }
    }
    let mut sizes = vec![0.0; labels.len()];
    for (site, &label) in labels.iter().enumerate() {
        if label != 0 {
            sizes[find(&mut root, site as u32) as usize] += f64::from(areas[site]);
        }
    }
    sizes.retain(|&size| size > 0.0);
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or_default();
    let small = sizes.partition_point(|&size| size < FRAGMENT * median);
    (sizes.len(), small)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_smaller_than_a_tenth_of_the_median_are_fragments() {
        // Runs of labels on a line: 12, 1, 15 and 11 sites of label 1, then 12 of label 2 beside them.
        let mut labels = Vec::new();
        for (length, label) in [
            (12, 1),
            (3, 0),
            (1, 1),
            (2, 0),
            (15, 1),
            (4, 0),
            (11, 1),
            (12, 2),
        ] {
            labels.extend(std::iter::repeat_n(label, length));
        }
        let pairs = || (1..labels.len() as u32).map(|site| [site - 1, site]);
        let areas = vec![0.5; labels.len()];
        assert_eq!(fragments(&labels, pairs(), &areas), (5, 1));
        assert_eq!(fragments(&vec![0; labels.len()], pairs(), &areas), (0, 0));
    }
}

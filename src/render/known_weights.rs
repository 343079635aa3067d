//! What is known of the weights of lights' images at vertices ([`vertex_lights`](crate::render::vertex_lights)
//! finds them): a list for each light and vertex.

use crate::render::nearest::Weight;

/// No list.
pub(super) const UNKNOWN: [u32; 2] = [u32::MAX; 2];

/// What is known of a scene's lights, in their order.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownWeights<'a>(pub(super) &'a [Option<Lists>]);

/// The lists of one light.
#[derive(Debug)]
pub(super) struct Lists {
    /// Where each vertex's list begins and ends, or [`UNKNOWN`].
    pub of_vertex: Vec<[u32; 2]>,
    pub weights: Vec<Weight>,
}

impl<'a> KnownWeights<'a> {
    /// What is known of the lights from a number on.
    pub fn from(self, first: usize) -> Self {
        Self(self.0.get(first..).unwrap_or_default())
    }

    /// The weights of a light at a vertex whose horizon it is above.
    #[inline(always)]
    pub fn of(self, light: usize, vertex: usize) -> Option<&'a [Weight]> {
        let lists = self.0.get(light)?.as_ref()?;
        match lists.of_vertex[vertex] {
            UNKNOWN => None,
            [start, end] => Some(&lists.weights[start as usize..end as usize]),
        }
    }
}

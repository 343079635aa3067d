//! The choice among candidates: the smallest distance, ties to the smaller flat index; with a
//! coherence κ above 1, the distances of candidates that are not coherent count κ times
//! (after Hertzmann 2001).

use crate::synthesis::candidates::Candidate;

/// The texel chosen, and its distance times κ where it is not coherent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Flat index of the texel.
    pub texel: u32,
    /// Its score.
    pub score: f64,
}

impl Pick {
    /// Whether this pick is to be preferred: smaller score, then smaller index.
    #[inline(always)]
    pub fn beats(&self, other: &Self) -> bool {
        self.score < other.score || (self.score == other.score && self.texel < other.texel)
    }
}

/// The best candidate. `distance(texel, limit)` may return infinity once it knows
/// the distance to be above `limit`.
#[inline(always)]
pub fn smallest(
    candidates: &[Candidate],
    coherence: f64,
    mut distance: impl FnMut(u32, f64) -> f64,
) -> Option<Pick> {
    let mut best: Option<Pick> = None;
    for candidate in candidates {
        let factor = if candidate.coherent { 1.0 } else { coherence };
        let limit = best.map_or(f64::INFINITY, |best| best.score / factor);
        let pick = Pick {
            texel: candidate.texel,
            score: factor * distance(candidate.texel, limit),
        };
        if best.is_none_or(|best| pick.beats(&best)) {
            best = Some(pick);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates(list: &[(u32, bool)]) -> Vec<Candidate> {
        list.iter()
            .map(|&(texel, coherent)| Candidate { texel, coherent })
            .collect()
    }

    #[test]
    fn ties_go_to_the_smaller_index() {
        let list = candidates(&[(5, true), (3, false), (9, false)]);
        let pick = smallest(&list, 1.0, |_, _| 2.0).unwrap();
        assert_eq!(pick.texel, 3);
    }

    #[test]
    fn coherence_prefers_the_coherent() {
        let list = candidates(&[(5, true), (3, false)]);
        let distance = |texel: u32, _: f64| if texel == 5 { 1.1 } else { 1.0 };
        assert_eq!(smallest(&list, 1.0, distance).unwrap().texel, 3);
        assert_eq!(smallest(&list, 1.2, distance).unwrap().texel, 5);
    }

    #[test]
    fn nothing_is_chosen_of_nothing() {
        assert_eq!(smallest(&[], 1.0, |_, _| 0.0), None);
    }
}

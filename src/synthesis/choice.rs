//! The choice among candidates: the smallest distance times the candidate's factor, ties to the
//! smaller flat index. The factor is how coherent candidates are preferred (Hertzmann 2001's κ), and
//! those not used too often already.

use crate::synthesis::candidates::Candidate;

/// The texel chosen, and its distance times its factor.
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
    mut distance: impl FnMut(u32, f64) -> f64,
) -> Option<Pick> {
    let mut best: Option<Pick> = None;
    for candidate in candidates {
        let factor = candidate.factor;
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

    fn candidates(list: &[(u32, f64)]) -> Vec<Candidate> {
        list.iter()
            .map(|&(texel, factor)| Candidate { texel, factor })
            .collect()
    }

    #[test]
    fn ties_go_to_the_smaller_index() {
        let list = candidates(&[(5, 1.0), (3, 1.0), (9, 1.0)]);
        let pick = smallest(&list, |_, _| 2.0).unwrap();
        assert_eq!(pick.texel, 3);
    }

    #[test]
    fn a_smaller_factor_is_preferred() {
        let distance = |texel: u32, _: f64| if texel == 5 { 1.1 } else { 1.0 };
        let of = |factor| smallest(&candidates(&[(5, 1.0), (3, factor)]), distance);
        assert_eq!(of(1.0).unwrap().texel, 3);
        assert_eq!(of(1.2).unwrap().texel, 5);
    }

    #[test]
    fn nothing_is_chosen_of_nothing() {
        assert_eq!(smallest(&[], |_, _| 0.0), None);
    }
}

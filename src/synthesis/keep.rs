//! What a search keeps: the best, or several within a margin.
//!
//! The best has the smallest score, factor · (distance + floor), ties to the smaller flat index. The factor is
//! how coherent candidates are preferred (Hertzmann 2001's κ), and those not used too often already. The
//! distance floor keeps differences between tiny distances from outweighing it.

use crate::synthesis::candidates::forward::Candidate;

/// What a search keeps of the texels that it compares.
pub trait Keep {
    /// The distance above which no further texel is kept.
    fn limit(&self) -> f64;

    /// Offers a texel; its distance may be infinite where it is above the limit.
    fn offer(&mut self, texel: u32, distance: f64);
}

/// Keeps the best.
#[derive(Clone, Copy, Debug)]
pub struct Best {
    /// The best so far.
    pub pick: Option<Pick>,
    /// What is preferred to the texels that are offered.
    pub preference: Preference,
}

/// Keeps the nearest few, of those within a factor of the smallest distance.
#[derive(Clone, Debug)]
pub struct Nearest {
    most: usize,
    factor: f64,
    /// Distances and texels, ascending.
    list: Vec<(f64, u32)>,
}

/// What a choice prefers beside small distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preference {
    /// What the distances of texels count that no neighbour leads to (1 for no preference).
    pub coherence: f64,
    /// What is added to all distances before.
    pub floor: f64,
}

/// The texel chosen, and what it was chosen for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Flat index of the texel.
    pub texel: u32,
    /// The distance of its neighbourhood.
    pub distance: f64,
    /// Its score.
    pub score: f64,
}

impl Preference {
    /// The smallest distance alone.
    pub const NONE: Self = Self {
        coherence: 1.0,
        floor: 0.0,
    };
}

impl Pick {
    /// A texel whose distance counts `factor` times.
    #[inline(always)]
    pub fn new(texel: u32, distance: f64, factor: f64, floor: f64) -> Self {
        Self {
            texel,
            distance,
            score: factor * (distance + floor),
        }
    }

    /// The distance from which on a texel of some factor loses against `best`; a hair more, against
    /// rounding.
    #[inline(always)]
    pub fn limit(best: Option<Self>, factor: f64, floor: f64) -> f64 {
        const HAIR: f64 = 1.0 + 1e-12;
        best.map_or(f64::INFINITY, |best| HAIR * best.score / factor - floor)
    }

    /// Whether this pick is to be preferred: smaller score, then smaller index.
    #[inline(always)]
    pub fn beats(&self, other: &Self) -> bool {
        self.score < other.score || (self.score == other.score && self.texel < other.texel)
    }
}

impl Keep for Best {
    #[inline(always)]
    fn limit(&self) -> f64 {
        let Preference { coherence, floor } = self.preference;
        Pick::limit(self.pick, coherence, floor)
    }

    #[inline(always)]
    fn offer(&mut self, texel: u32, distance: f64) {
        let Preference { coherence, floor } = self.preference;
        let pick = Pick::new(texel, distance, coherence, floor);
        if self.pick.is_none_or(|best| pick.beats(&best)) {
            self.pick = Some(pick);
        }
    }
}

impl Nearest {
    /// Nothing yet, of `most` texels at distances of at most `factor` times the smallest.
    pub fn new(most: usize, factor: f64) -> Self {
        Self {
            most,
            factor,
            list: Vec::with_capacity(most + 1),
        }
    }

    /// The distances and texels that are kept, nearest first, ties to the smaller index.
    pub fn kept(&self) -> &[(f64, u32)] {
        let least = self.list.first().map_or(0.0, |&(least, _)| least);
        let within = |&(distance, _): &(f64, u32)| distance <= self.factor * least;
        &self.list[..self.list.partition_point(within)]
    }
}

impl Keep for Nearest {
    #[inline(always)]
    fn limit(&self) -> f64 {
        let within = self
            .list
            .first()
            .map_or(f64::INFINITY, |&(least, _)| self.factor * least);
        match self.list.get(self.most - 1) {
            Some(&(last, _)) => within.min(last),
            None => within,
        }
    }

    fn offer(&mut self, texel: u32, distance: f64) {
        if distance > self.limit() {
            return;
        }
        let place = self
            .list
            .partition_point(|&listed| listed < (distance, texel));
        self.list.insert(place, (distance, texel));
        self.list.truncate(self.most);
    }
}

/// The best of `first` and some candidates, with `floor` added to all distances. `distance(texel, limit)` may return
/// infinity once it knows the distance to be above `limit`.
#[inline(always)]
pub fn smallest(
    candidates: &[Candidate],
    first: Option<Pick>,
    floor: f64,
    mut distance: impl FnMut(u32, f64) -> f64,
) -> Option<Pick> {
    let mut best = first;
    let (mut limit, mut limited) = (f64::INFINITY, f64::NAN);
    for candidate in candidates {
        let factor = candidate.factor;
        // Most candidates count alike, and few are the best so far.
        if factor != limited {
            (limit, limited) = (Pick::limit(best, factor, floor), factor);
        }
        let distance = distance(candidate.texel, limit);
        let pick = Pick::new(candidate.texel, distance, factor, floor);
        if best.is_none_or(|best| pick.beats(&best)) {
            (best, limited) = (Some(pick), f64::NAN);
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
        let pick = smallest(&list, None, 0.0, |_, _| 2.0).unwrap();
        assert_eq!(pick.texel, 3);
    }

    #[test]
    fn a_smaller_factor_is_preferred() {
        let distance = |texel: u32, _: f64| if texel == 5 { 1.1 } else { 1.0 };
        let of = |factor| smallest(&candidates(&[(5, 1.0), (3, factor)]), None, 0.0, distance);
        assert_eq!(of(1.0).unwrap().texel, 3);
        assert_eq!(of(1.2).unwrap().texel, 5);
    }

    #[test]
    fn distances_below_the_floor_do_not_outweigh_a_factor() {
        // The other is nearer, 0 against 0.1; with κ 1.5 that counts only without floor.
        let distance = |texel: u32, _: f64| if texel == 5 { 0.1 } else { 0.0 };
        let of = |floor| smallest(&candidates(&[(5, 1.0), (3, 1.5)]), None, floor, distance);
        assert_eq!(of(0.0).unwrap().texel, 3);
        assert_eq!(of(0.1).unwrap().texel, 3);
        assert_eq!(of(0.3).unwrap().texel, 5);
        assert_eq!(of(0.3).unwrap().distance, 0.1);
    }

    #[test]
    fn a_limit_lets_ties_through() {
        let best = Pick::new(7, 0.1, 1.3, 0.37);
        assert!(Pick::limit(Some(best), 1.3, 0.37) >= 0.1);
        assert_eq!(Pick::limit(None, 1.3, 0.37), f64::INFINITY);
    }

    #[test]
    fn the_nearest_few_are_kept_within_the_factor() {
        let kept = |most, factor, offered: &[(f64, u32)]| {
            let mut nearest = Nearest::new(most, factor);
            for &(distance, texel) in offered {
                nearest.offer(texel, distance);
            }
            let texels = nearest.kept().iter().map(|&(_, texel)| texel);
            (texels.collect::<Vec<_>>(), nearest.limit())
        };
        let offered = [(3.0, 9), (1.5, 4), (1.0, 7), (1.5, 2), (1.1, 8), (1.0, 3)];
        assert_eq!(kept(8, 1.5, &offered), (vec![3, 7, 8, 2, 4], 1.5));
        assert_eq!(kept(4, 1.5, &offered), (vec![3, 7, 8, 2], 1.5));
        assert_eq!(kept(3, 1.5, &offered), (vec![3, 7, 8], 1.1));
        assert_eq!(kept(8, 1.05, &offered), (vec![3, 7], 1.05));
        assert_eq!(kept(1, 9.0, &offered), (vec![3], 1.0));
        assert_eq!(
            kept(8, 1.2, &[(0.0, 5), (0.1, 4), (0.0, 6)]),
            (vec![5, 6], 0.0)
        );
        assert_eq!(kept(8, 1.2, &[]), (vec![], f64::INFINITY));
    }

    #[test]
    fn nothing_is_chosen_of_nothing() {
        assert_eq!(smallest(&[], None, 0.0, |_, _| 0.0), None);
    }
}

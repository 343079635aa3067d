//! The order in which the texels of an atlas are visited one by one (Ying 2001 §4): chart after chart, breadth
//! first across borders, and inside a chart along its rows, from one beside finished texels on.

use std::collections::VecDeque;

/// Where the sites of a level stand.
pub struct ScanLines<'a> {
    /// The texel of each site, ascending.
    pub texels: &'a [u32],
    /// Columns of the atlas.
    pub width: u32,
    /// The chart of each site.
    pub charts: &'a [u32],
}

/// A row of a chart: its sites, left to right.
type Line = Vec<u32>;

impl ScanLines<'_> {
    /// All sites in the order of their visit; `neighbors` are the sites beside one, in its chart and in others.
    /// The chart of the most texels comes first, and again wherever no border leads on.
    pub fn order<I: Iterator<Item = u32>>(&self, neighbors: impl Fn(u32) -> I) -> Vec<u32> {
        // Sort the charts by size.
        let lines = self.lines();
        let size = |chart: usize| lines[chart].iter().map(Vec::len).sum::<usize>();
        let mut by_size: Vec<usize> = (0..lines.len()).collect();
        by_size.sort_by_key(|&chart| std::cmp::Reverse(size(chart)));
        let mut is_finished = vec![false; self.texels.len()];
        let mut is_reached = vec![false; lines.len()];
        let mut order = Vec::with_capacity(self.texels.len());
        let mut front = VecDeque::new();
        // Visit a chart line by line, then those that its border leads to.
        for first in by_size {
            if std::mem::replace(&mut is_reached[first], true) {
                continue;
            }
            front.push_back(first);
            while let Some(chart) = front.pop_front() {
                let begin = first_line(&lines[chart], &is_finished, &neighbors);
                let (above, below) = lines[chart].split_at(begin);
                for &site in below.iter().chain(above.iter().rev()).flatten() {
                    is_finished[site as usize] = true;
                    order.push(site);
                    for near in neighbors(site) {
                        let other = self.charts[near as usize] as usize;
                        if !std::mem::replace(&mut is_reached[other], true) {
                            front.push_back(other);
                        }
                    }
                }
            }
        }
        order
    }

    /// The rows of every chart, from the top.
    fn lines(&self) -> Vec<Vec<Line>> {
        let charts = self
            .charts
            .iter()
            .max()
            .map_or(0, |&last| last as usize + 1);
        let mut lines: Vec<Vec<Line>> = vec![Vec::new(); charts];
        let mut rows = vec![u32::MAX; charts];
        for (site, (&texel, &chart)) in (0_u32..).zip(self.texels.iter().zip(self.charts)) {
            let (chart, row) = (chart as usize, texel / self.width);
            if std::mem::replace(&mut rows[chart], row) != row {
                lines[chart].push(Vec::new());
            }
            if let Some(line) = lines[chart].last_mut() {
                line.push(site);
            }
        }
        lines
    }
}

/// The line with the most sites beside finished ones, the first of equal ones.
fn first_line<I: Iterator<Item = u32>>(
    lines: &[Line],
    is_finished: &[bool],
    neighbors: &impl Fn(u32) -> I,
) -> usize {
    let is_beside = |&&site: &&u32| neighbors(site).any(|near| is_finished[near as usize]);
    let beside = |line: &Line| line.iter().filter(is_beside).count();
    let most = lines.iter().map(beside).enumerate();
    let most = most.max_by_key(|&(at, count)| (count, std::cmp::Reverse(at)));
    most.map_or(0, |(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_begins_at_its_border_with_the_one_before() {
        // A chart of 3 × 3 texels on the left of a 7 × 3 atlas and one of 2 × 3 on the right; their lowest rows
        // touch on the surface.
        let texels: Vec<u32> = (0..21)
            .filter(|texel| ![3, 4].contains(&(texel % 7)))
            .collect();
        let charts: Vec<u32> = texels
            .iter()
            .map(|texel| u32::from(texel % 7 > 3))
            .collect();
        let lines = ScanLines {
            texels: &texels,
            width: 7,
            charts: &charts,
        };
        let neighbors = |site: u32| {
            let across = match site {
                12 => Some(13),
                13 => Some(12),
                _ => None,
            };
            across.into_iter()
        };
        let order = lines.order(neighbors);
        assert_eq!(order, [0, 1, 2, 5, 6, 7, 10, 11, 12, 13, 14, 8, 9, 3, 4]);
    }

    #[test]
    fn charts_that_nothing_leads_to_come_too() {
        let lines = ScanLines {
            texels: &[0, 2, 3, 9],
            width: 4,
            charts: &[0, 2, 2, 1],
        };
        assert_eq!(lines.order(|_| std::iter::empty()), [1, 2, 0, 3]);
    }
}

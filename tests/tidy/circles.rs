//! Circles among files that use each other.

use std::collections::{BTreeMap, BTreeSet};

/// A circle of files, from the first by name back to it; `None` where there is none.
pub fn find<'a>(uses: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> Option<Vec<&'a str>> {
    uses.keys().find_map(|start| shortest(uses, start))
}

/// The shortest way from a file back to itself.
fn shortest<'a>(
    uses: &BTreeMap<&'a str, BTreeSet<&'a str>>,
    start: &'a str,
) -> Option<Vec<&'a str>> {
    let mut came_from: BTreeMap<&str, &str> = BTreeMap::new();
    let mut reached = vec![start];
    let mut next = 0;
    while next < reached.len() {
        let file = reached[next];
        next += 1;
        for &used in uses.get(file).into_iter().flatten() {
            if used == start {
                let mut circle = vec![start, file];
                while circle[circle.len() - 1] != start {
                    circle.push(came_from[circle[circle.len() - 1]]);
                }
                circle.reverse();
                return Some(circle);
            }
            if !came_from.contains_key(used) {
                came_from.insert(used, file);
                reached.push(used);
            }
        }
    }
    None
}

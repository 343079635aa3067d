//! Tests of the counted tree: against a full search, and its formula.

use super::*;
use crate::random;
use rand::Rng;

/// Points in clusters, some of them equal, and queries near them.
fn points(count: usize, dimensions: usize, purpose: &str) -> Vec<f32> {
    let mut stream = random::stream(7, purpose, 0, 0);
    let mut point = || {
        let cluster = stream.gen_range(0..20);
        let exact = stream.gen_range(0..4) == 0;
        let mut number = |at: usize| {
            let base = ((cluster * 7 + at * 3) % 11) as f32 / (1 + at) as f32;
            let jitter: f32 = stream.gen_range(-0.3..0.3);
            if exact {
                base
            } else {
                base + jitter / (1 + at) as f32
            }
        };
        (0..dimensions).map(&mut number).collect::<Vec<f32>>()
    };
    (0..count).flat_map(|_| point()).collect()
}

#[test]
fn the_tree_chooses_what_a_full_search_chooses_while_counts_grow() {
    for (count, dimensions) in [(1, 3), (9, 1), (500, 20), (777, 13), (6000, 20)] {
        let numbers = points(count, dimensions, "points");
        let queries = points(3 * 1500, dimensions, "queries");
        let mut tree = CountedTree::new(&numbers, dimensions, 0.01);
        for (number, turned) in queries.chunks(3 * dimensions).enumerate() {
            let [mut found, mut all, mut slow] = [Choice::NONE; 3];
            for (phase, numbers) in turned.chunks(dimensions).enumerate() {
                if number % 3 == 0 {
                    let guess = (number % count) as u32;
                    found.offer(tree.compared(numbers, guess, phase as u8));
                }
                tree.search(numbers, phase as u8, &mut found);
                tree.search_all(numbers, phase as u8, &mut all);
                for item in 0..count as u32 {
                    slow.offer(tree.compared(numbers, item, phase as u8));
                }
            }
            assert_eq!(
                (found, all),
                (slow, slow),
                "query {number} of {count} points"
            );
            tree.count_use(found.item);
            assert_eq!(tree.uses(found.item), slow.count + 1);
        }
        let uses = (0..count as u32).map(|item| tree.uses(item));
        assert_eq!(uses.clone().sum::<u32>(), 1500);
        assert_eq!(uses.min().unwrap(), tree.smallest());
        tree.forget_uses();
        assert_eq!((tree.smallest(), tree.uses(0)), (0, 0));
    }
}

#[test]
fn scores_follow_the_formula() {
    let mut tree = CountedTree::new(&[0.0, 0.0, 3.0, 4.0], 2, 0.5);
    let query = [0.0, 0.0];
    assert_eq!(tree.compared(&query, 1, 2).score, 25.5);
    tree.count_use(1);
    tree.count_use(1);
    assert_eq!(tree.compared(&query, 1, 2).score, 25.5 * 64.0);
    tree.count_use(0);
    assert_eq!(tree.compared(&query, 1, 2).score, 25.5 * 8.0);
    assert_eq!(penalty(3, 3), 1.0);
    assert!(penalty(u32::MAX, 0).is_finite());
}

#[test]
fn uses_are_shared_among_equal_points() {
    let mut tree = CountedTree::new(&[1.0; 40], 1, 0.0);
    for _ in 0..80 {
        let mut found = Choice::NONE;
        tree.search(&[1.0], 0, &mut found);
        tree.count_use(found.item);
    }
    assert!((0..40).all(|item| tree.uses(item) == 2));
}

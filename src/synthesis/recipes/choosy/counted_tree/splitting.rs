//! How the points of a tree are split in halves, level after level.

/// Points that are ordered by one thread.
const FEW: usize = 1 << 12;

/// Orders points so that on every one of some levels the two halves lie apart in the direction of their largest
/// variance.
pub fn halve<'a>(items: &mut [u32], point: &(impl Fn(u32) -> &'a [f32] + Sync), levels: u32) {
    if levels == 0 || items.len() < 2 {
        return;
    }
    let direction = widest(items, point);
    let along = |item: u32| point(item)[direction];
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |&a, &b| {
        along(a).total_cmp(&along(b)).then(a.cmp(&b))
    });
    let is_long = items.len() > FEW;
    let (left, right) = items.split_at_mut(middle);
    if is_long {
        rayon::join(
            || halve(left, point, levels - 1),
            || halve(right, point, levels - 1),
        );
    } else {
        halve(left, point, levels - 1);
        halve(right, point, levels - 1);
    }
}

/// The direction in which points vary most.
fn widest<'a>(items: &[u32], point: &impl Fn(u32) -> &'a [f32]) -> usize {
    let dimensions = point(items[0]).len();
    let mut sums = vec![(0.0f64, 0.0f64); dimensions];
    for &item in items {
        for (sum, &number) in sums.iter_mut().zip(point(item)) {
            let number = f64::from(number);
            *sum = (sum.0 + number, sum.1 + number * number);
        }
    }
    let count = items.len() as f64;
    let variance = |&(sum, squares): &(f64, f64)| squares - sum * sum / count;
    let widest = sums.iter().map(variance).enumerate();
    let widest = widest.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    widest.map_or(0, |(direction, _)| direction)
}

/// Where leaves begin when a range is halved on every level as [`halve`] does.
pub fn leaf_starts(first: usize, count: usize, levels: u32, starts: &mut Vec<u32>) {
    if levels == 0 {
        starts.push(first as u32);
        return;
    }
    let middle = count / 2;
    leaf_starts(first, middle, levels - 1, starts);
    leaf_starts(first + middle, count - middle, levels - 1, starts);
}

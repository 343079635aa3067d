//! Features that become narrower or wider along an axis as shares of their own width: "progressively shrinking
//! the stripes horizontally but not vertically" (Zhang 2003, fig. 5), several labels together (fig. 6).
//!
//! A feature's width is that of its run along the axis. Its labels are scaled about the run's middle; what a run
//! leaves takes the label beyond its end. A run that ends at the image's border continues mirrored there, so that it
//! stays at the border; one from border to border is left as it is.

use ndarray::{Array2, ArrayView1, ArrayViewMut1, Axis as Dimension};

use crate::vary::label_set::LabelSet;
use crate::vary::nearest_pixel::Axis;

/// Factors below this leave nothing.
const NOTHING: f64 = 1e-6;

/// The mask with its features scaled along axes by the factor at each pixel (row, column).
pub fn scaled(
    mask: &Array2<u8>,
    labels: LabelSet,
    along: Axis,
    factor: impl Fn(usize, usize) -> f64,
) -> Array2<u8> {
    let mut found = mask.clone();
    if along != Axis::Vertical {
        for (row, mut line) in found.axis_iter_mut(Dimension(0)).enumerate() {
            scale_line(mask.row(row), &mut line, labels, |col| factor(row, col));
        }
    }
    if along != Axis::Horizontal {
        let before = found.clone();
        for (col, mut line) in found.axis_iter_mut(Dimension(1)).enumerate() {
            scale_line(before.column(col), &mut line, labels, |row| {
                factor(row, col)
            });
        }
    }
    found
}

/// A run of features along a line.
struct Run {
    /// Its first place, and the one behind its last.
    places: [usize; 2],
    middle: f64,
    half: f64,
}

fn runs(line: ArrayView1<'_, u8>, labels: LabelSet) -> Vec<Run> {
    let side = line.len();
    let mut found = Vec::new();
    let mut at = 0;
    while at < side {
        let begin = at;
        while at < side && labels.has(line[at]) {
            at += 1;
        }
        if at > begin && at - begin < side {
            let (first, last) = (begin as f64, at as f64);
            let (middle, half) = match (begin == 0, at == side) {
                (true, _) => (0.0, last),
                (_, true) => (last, last - first),
                _ => ((first + last) / 2.0, (last - first) / 2.0),
            };
            found.push(Run {
                places: [begin, at],
                middle,
                half,
            });
        }
        at += usize::from(at == begin);
    }
    found
}

fn scale_line(
    line: ArrayView1<'_, u8>,
    out: &mut ArrayViewMut1<'_, u8>,
    labels: LabelSet,
    factor: impl Fn(usize) -> f64,
) {
    let runs = runs(line, labels);
    for (place, slot) in out.iter_mut().enumerate() {
        let (at, factor) = (place as f64 + 0.5, factor(place));
        let mut nearest: Option<(f64, &Run)> = None;
        for run in runs.iter().filter(|_| factor > NOTHING) {
            let share = (at - run.middle) / (run.half * factor);
            let inside = (-1.0..1.0).contains(&share);
            if inside && nearest.is_none_or(|(least, _)| share.abs() < least) {
                nearest = Some((share.abs(), run));
            }
        }
        if let Some((_, run)) = nearest {
            let source = (run.middle + (at - run.middle) / factor).floor();
            let [begin, end] = run.places;
            *slot = line[(source.max(0.0) as usize).clamp(begin, end - 1)];
        } else if let Some(run) = runs
            .iter()
            .find(|run| (run.places[0]..run.places[1]).contains(&place))
        {
            *slot = line[beyond(run, at, line.len())];
        }
    }
}

/// The place beyond the end of a run that is nearer to `at`.
fn beyond(run: &Run, at: f64, side: usize) -> usize {
    let [begin, end] = run.places;
    match begin > 0 && (end == side || at < run.middle) {
        true => begin - 1,
        false => end,
    }
}

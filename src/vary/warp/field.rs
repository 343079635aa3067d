//! Field warping (Beier and Neely 1992): the contours' lines draw the pixels near them along.
//!
//! A pixel's way back is the mean of what all lines say, each keeping the pixel's share along the line and its
//! distance from it; a line of length l at distance d weighs l/(1 + d)⁴, so that features packed closely do not
//! hold each other.

use glam::DVec2;

use crate::vary::warp::motion::Moved;

/// Lines of a feature.
const LINES: usize = 12;
/// Lines shorter than this say nothing, in pixels.
const SHORTEST: f64 = 0.5;

/// A line before and after.
struct Line {
    source: [DVec2; 2],
    target: [DVec2; 2],
}

/// The source of every point.
pub fn sources(moved: &[Moved]) -> impl Fn(DVec2) -> DVec2 + use<> {
    let lines: Vec<Line> = moved.iter().flat_map(lines_of).collect();
    move |point: DVec2| {
        let (mut sum, mut weights) = (DVec2::ZERO, 0.0);
        for line in &lines {
            let (source, weight) = line.source_of(point);
            sum += weight * (source - point);
            weights += weight;
        }
        if weights > 0.0 {
            point + sum / weights
        } else {
            point
        }
    }
}

/// The sides of a feature's polygon; of a feature too small for one, a line through its centre.
fn lines_of(feature: &Moved) -> Vec<Line> {
    let polygon: Vec<DVec2> = feature.contour_points(LINES).collect();
    let line = |a: DVec2, b: DVec2| Line {
        source: [a, b],
        target: [feature.target_of(a), feature.target_of(b)],
    };
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let mut lines: Vec<Line> = sides.map(|(&a, &b)| line(a, b)).collect();
    lines.retain(Line::is_long);
    if lines.is_empty() {
        let through = line(feature.centre - DVec2::X, feature.centre + DVec2::X);
        lines.extend(through.is_long().then_some(through));
    }
    lines
}

impl Line {
    fn is_long(&self) -> bool {
        let ends = [self.source, self.target];
        ends.iter().all(|[a, b]| a.distance(*b) >= SHORTEST)
    }

    /// Where a point came from if this line alone spoke, and how much it weighs.
    fn source_of(&self, point: DVec2) -> (DVec2, f64) {
        let ([from, to], [source, end]) = (self.target, self.source);
        let (along, before) = (to - from, end - source);
        let share = (point - from).dot(along) / along.length_squared();
        let across = (point - from).dot(along.perp()) / along.length();
        let at = source + share * before + across * before.perp() / before.length();
        let distance = match share {
            share if share < 0.0 => point.distance(from),
            share if share > 1.0 => point.distance(to),
            _ => across.abs(),
        };
        (at, along.length() / (1.0 + distance).powi(4))
    }
}

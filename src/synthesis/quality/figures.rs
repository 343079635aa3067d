//! The quality figures as people read them: each with its name, value and good range, and what it means. The ranges are
//! those of docs/synthesis.md.

use serde::Serialize;

use crate::synthesis::quality::Quality;

/// A quality figure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct QualityFigure {
    /// Its name in reports.
    pub name: &'static str,
    /// What was found.
    pub value: String,
    /// What is good.
    pub range: &'static str,
    /// Whether what was found is good.
    pub is_good: bool,
    /// What it says.
    pub meaning: &'static str,
}

impl QualityFigure {
    /// A figure: its name and value, its good range and whether it lies in it, what it means.
    fn new(
        (name, value): (&'static str, String),
        (range, is_good): (&'static str, bool),
        meaning: &'static str,
    ) -> Self {
        Self {
            name,
            value,
            range,
            is_good,
            meaning,
        }
    }
}

/// The figures that were measured of a map; `is_polished` says whether it ended with polish.
pub fn figures(found: &Quality, is_polished: bool) -> Vec<QualityFigure> {
    let [[a, b], [c, d]] = found.drift;
    let from_identity = [a - 1.0, b, c, d - 1.0]
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max);
    // Tell how the texture follows the surface.
    let mut figures = vec![
        QualityFigure::new(
            ("coherence_half", format!("{:.3}", found.coherence_half)),
            ("above 0.4", found.coherence_half > 0.4),
            "share of edges whose texture offset is within half a texel of their own: inside copied patches",
        ),
        QualityFigure::new(
            ("coherence_one", format!("{:.3}", found.coherence_one)),
            ("above 0.7, best 1", found.coherence_one > 0.7),
            "the same within one texel",
        ),
        QualityFigure::new(
            ("drift", format!("[[{a:.3}, {b:.3}], [{c:.3}, {d:.3}]]")),
            ("within 0.1 of the identity", from_identity < 0.1),
            "the matrix that best maps edge offsets to texture offsets: the identity keeps scale and handedness",
        ),
    ];
    // Tell how well neighbourhoods fit, where it was measured.
    if let Some(energies) = found.energies {
        figures.push(QualityFigure::new(
            ("energy", format!("{:.3}", energies.energy)),
            ("below 0.3, best 0", energies.energy < 0.3),
            "mean neighbourhood distance over that of a random map",
        ));
        let ratio = energies.energy_ratio_full;
        figures.push(QualityFigure::new(
            ("energy_ratio_full", format!("{ratio:.3}")),
            ratio_range(ratio, is_polished),
            "the same over that of the best texel at each site, the rest of the map fixed",
        ));
    }
    // Tell how often textons are used, where there are textons.
    if let Some(chi2) = found.histogram_chi2 {
        figures.push(QualityFigure::new(
            ("histogram_chi2", format!("{chi2:.4}")),
            ("below 0.01", chi2 < 0.01),
            "distance of the texton histograms: the surface by area against the sample",
        ));
    }
    figures
}

/// The good range of `energy_ratio_full`, and whether it lies in it. Polish lays whole patches, whose sites need not
/// have the best texel each; docs/synthesis-measured.md has 1.6 to 2.8 for maps polished all over.
fn ratio_range(ratio: f64, is_polished: bool) -> (&'static str, bool) {
    match is_polished {
        true => ("1.00 to 3.00 after polish", ratio < 3.0),
        false => ("1.00 to 1.10", ratio < 1.1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::quality::MeanEnergies;

    /// A map with everything that is measured, whose ratio of energies is that of a polished map.
    fn measured() -> Quality {
        Quality {
            coherence_half: 0.5,
            coherence_one: 0.9,
            drift: [[1.0, 0.05], [0.0, 0.95]],
            edges: 100,
            mean_edge: 1.0,
            energies: Some(MeanEnergies {
                energy: 0.1,
                energy_ratio_full: 2.0,
                energy_sites: 50,
            }),
            histogram_chi2: Some(0.001),
            fragments: None,
        }
    }

    fn poor(figures: &[QualityFigure]) -> Vec<&'static str> {
        let poor = figures.iter().filter(|figure| !figure.is_good);
        poor.map(|figure| figure.name).collect()
    }

    #[test]
    fn the_range_of_the_energy_ratio_is_that_of_the_maps_polish() {
        assert!(ratio_range(1.05, false).1 && ratio_range(1.05, true).1);
        assert!(!ratio_range(2.0, false).1 && ratio_range(2.0, true).1);
        assert!(!ratio_range(3.5, true).1);
        assert!(ratio_range(2.0, true).0.contains("polish"));
    }

    #[test]
    fn figures_outside_their_ranges_are_poor() {
        let mut found = measured();
        assert!(poor(&figures(&found, true)).is_empty());
        assert_eq!(poor(&figures(&found, false)), ["energy_ratio_full"]);
        found.drift = [[1.0, 0.0], [0.0, -1.0]];
        assert_eq!(poor(&figures(&found, true)), ["drift"]);
    }

    #[test]
    fn what_was_not_measured_has_no_figure() {
        let found = Quality {
            energies: None,
            histogram_chi2: None,
            ..measured()
        };
        let names: Vec<_> = figures(&found, false)
            .iter()
            .map(|figure| figure.name)
            .collect();
        assert_eq!(names, ["coherence_half", "coherence_one", "drift"]);
    }

    #[test]
    fn the_page_states_every_range() {
        let page = include_str!("../../../docs/synthesis.md");
        for figure in [true, false]
            .map(|is_polished| figures(&measured(), is_polished))
            .concat()
        {
            let begin = format!("| `{}` |", figure.name);
            let row = page.lines().find(|line| line.starts_with(&begin));
            assert!(
                row.is_some_and(|row| row.contains(figure.range)),
                "{figure:?}"
            );
        }
    }
}

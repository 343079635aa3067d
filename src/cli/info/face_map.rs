//! A face map: its size, what its sources are, and whether it belongs to a space or a sample.

use std::path::Path;

use crate::cli::info::map::check_belongs_to;
use crate::cli::info::map::with_header;
use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::maps::face_map::{FaceMap, Square};

/// Reads a whole map and describes its content.
pub fn describe(path: &Path, against: Option<&Path>) -> Result<Outcome> {
    let map = FaceMap::read(path)?;
    let [width, height] = map.header.exemplar;
    let Square { left, top, side } = map.square;
    let faces = map.mesh.triangles.len();
    // Count sources and phases.
    let mut sources = map.sources.clone();
    sources.sort_unstable();
    sources.dedup();
    let mut phases = [0; 3];
    for &phase in &map.phases {
        phases[usize::from(phase)] += 1;
    }
    let names: Vec<&str> = map.channels.iter().map(|of| of.name.as_str()).collect();
    // Tell what the map holds.
    let outcome = Outcome::default()
        .line(format!(
            "face map: {faces} faces, {} levels, sample of {width} × {height} texels",
            map.subdivisions + 1
        ))
        .line(format!(
            "its square of {side} × {side} texels begins at row {top}, column {left}; {} triangles of it are used",
            sources.len()
        ))
        .line(format!(
            "a texel covers {:.6} mesh units; method {}, seed {}",
            map.header.texel, map.header.method, map.header.seed
        ))
        .line(format!("phases 0, 1 and 2: {}, {} and {} faces", phases[0], phases[1], phases[2]))
        .line(match (map.colors.is_some(), names.is_empty()) {
            (true, true) => "it has colours".into(),
            (true, false) => format!("it has colours and {}", names.join(", ")),
            (false, true) => "it has no colours: render it with its sample".into(),
            (false, false) => format!("it has {}", names.join(", ")),
        })
        .figure("kind", "face map")
        .figure("faces", faces)
        .figure("levels", map.subdivisions + 1)
        .figure("exemplar", vec![width, height])
        .figure("square", vec![left, top, side])
        .figure("sources", sources.len())
        .figure("phases", phases.to_vec())
        .figure("has_colors", map.colors.is_some())
        .figure("channels", names);
    let mut outcome = with_header(outcome, &map.header);
    // Check whether it belongs to the other file.
    if let Some(other) = against {
        let stated = (map.header.exemplar, &map.header.sample, &map.header.space);
        check_belongs_to(stated, other).map_err(|error| error.in_file(path))?;
        outcome = outcome.line(format!("it belongs to {}", other.display()));
    }
    Ok(outcome)
}

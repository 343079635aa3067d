//! The chapter of the vocabulary: what textons look like, and where they lie.

use std::path::Path;

use crate::btf::sample::Sample;
use crate::error::Result;
use crate::report::embedded::Embedded;
use crate::report::summary::Chapter;
use crate::texton::montage::{label_map, montage};
use crate::texton::vocabulary::StoredVocabulary;

/// What is known of the vocabulary.
pub(super) fn chapter(path: Option<&Path>, sample: Option<&Sample>) -> Result<Chapter> {
    let mut chapter = Chapter::default();
    let Some(path) = path else {
        chapter.note("no textons are there: mesotex textons finds them, plain images have none");
        return Ok(chapter);
    };
    // State the facts.
    let vocabulary = StoredVocabulary::open(path)?;
    chapter.fact("images analysed", vocabulary.representatives.len());
    for (at, level) in vocabulary.levels.iter().enumerate() {
        let (width, height) = (level.grid.width, level.grid.height);
        let textons = format!("{width} × {height} texels, {} textons", level.counts.len());
        chapter.fact(&format!("level {at}"), textons);
    }
    chapter.fact("id", &vocabulary.id);
    // Draw the texton map.
    let finest = &vocabulary.levels[0];
    let labels = label_map(finest.grid, &finest.labels);
    chapter
        .pictures
        .push(Embedded::new(&labels, "the texton map: a colour per texton")?.of_texels());
    // Draw the montage, which needs the sample.
    let grid = sample.map(Sample::grid);
    match sample.filter(|_| grid.is_some_and(|grid| grid.len() == finest.grid.len())) {
        Some(sample) => {
            let patches = montage(sample, &finest.labels, &finest.counts)?;
            chapter.pictures.push(
                Embedded::new(
                    &patches,
                    "what each texton looks like, the most frequent first",
                )?
                .of_texels(),
            );
        }
        None => chapter.note("no montage of the textons: the sample they were found in is missing"),
    }
    Ok(chapter)
}

//! Whether a level of a space is sound.

use crate::error::{Error, Result};
use crate::exemplar::space::{Features, SpaceLevel};

/// Checks that a level has the features of its texels.
pub fn space_level(level: &SpaceLevel, index: usize) -> Result<()> {
    let texels = level.grid.len();
    let place = format!("space, L{index}");
    match &level.features {
        Features::Textons { labels, gram } => {
            let textons = gram.nrows();
            if labels.len() != texels || textons < 2 || gram.ncols() != textons {
                return Err(Error::data(
                    place,
                    format!("{} labels and a Gram matrix {:?}", labels.len(), gram.dim()),
                )
                .expected(format!("{texels} labels and a square Gram matrix")));
            }
            match labels
                .iter()
                .find(|&&label| usize::from(label) >= textons - 1)
            {
                Some(label) => Err(Error::data(place, format!("label {label}"))
                    .expected(format!("labels below {}", textons - 1))),
                None => Ok(()),
            }
        }
        Features::Plain(vectors) => {
            let (height, width, dimensions) = vectors.dim();
            if height * width == texels && dimensions > 0 && texels > 0 {
                return Ok(());
            }
            Err(Error::data(place, format!("features {:?}", vectors.dim()))
                .expected(format!("{texels} vectors of one number or more")))
        }
    }
}

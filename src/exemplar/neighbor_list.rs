//! The rows of a level's neighbour table, as the searches find them in any order.

use ndarray::Array2;

use crate::index::TexelIndex;

/// A neighbour: its distance and its flat index.
pub type Near = (f32, u32);

/// A texel's neighbours, nearest first and itself before all; or how many there are where they are
/// too few.
pub type Row = Result<Vec<Near>, usize>;

/// A level's neighbours and their distances.
pub type Rows = (Array2<u32>, Array2<f32>);

/// The table of a level of `texels`, `k` neighbours each; the number found at the first texel that has
/// too few.
pub fn assemble(
    texels: usize,
    k: usize,
    found: impl IntoIterator<Item = (TexelIndex, Row)>,
) -> Result<Rows, usize> {
    let (mut neighbors, mut distances) = (Array2::zeros((texels, k)), Array2::zeros((texels, k)));
    let mut short: Option<(TexelIndex, usize)> = None;
    for (texel, row) in found {
        match row {
            Ok(row) => {
                for (column, (distance, neighbor)) in row.into_iter().enumerate() {
                    neighbors[[texel.index(), column]] = neighbor;
                    distances[[texel.index(), column]] = distance;
                }
            }
            Err(count) if short.is_none_or(|(first, _)| texel.0 < first.0) => {
                short = Some((texel, count));
            }
            Err(_) => {}
        }
    }
    short.map_or(Ok((neighbors, distances)), |(_, count)| Err(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_at_their_texels() {
        let row = |texel: u32| (TexelIndex(texel), Ok(vec![(0.0, texel), (1.5, 7)]));
        let (neighbors, distances) = assemble(2, 2, vec![row(1), row(0)]).unwrap();
        assert_eq!(neighbors, ndarray::arr2(&[[0, 7], [1, 7]]));
        assert_eq!(distances[[1, 1]], 1.5);
    }

    #[test]
    fn the_first_short_texel_tells() {
        let found = vec![(TexelIndex(5), Err(4)), (TexelIndex(2), Err(3))];
        assert_eq!(assemble(9, 6, found), Err(3));
    }
}

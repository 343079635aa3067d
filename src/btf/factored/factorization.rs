//! What `btf.json` says of a factored sample's arrays.
//!
//! With U_c the directions' factors [images, K] of channel c and E_c the eigentextures [H·W, K] (the
//! singular values in them), the channel's value of image i at texel x is v_c = U_c\[i\] · E_c\[x\], and
//! RGB = T v + m: T the colour transform, m the colour mean. A component below 0 is read as 0.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// The channels of a factored sample.
pub const CHANNELS: usize = 3;
/// T that changes no colour.
pub const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
/// The largest number of a colour step: with factors up to
/// [`LARGEST_FACTOR`](super::factors::LARGEST_FACTOR), products stay below the largest `f32`.
const LARGEST_COLOR: f64 = 1e6;
/// The largest rank: so many numbers per texel and channel are more than the images of any set.
const LARGEST_RANK: u32 = 1 << 16;

/// The factors of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Factorization {
    /// K, eigentextures per channel.
    pub rank: u32,
    /// Whether the channels share one set of eigentextures.
    #[serde(default, skip_serializing_if = "is_false")]
    pub shared_eigentextures: bool,
    /// T, row-major: linear Rec. 709 from the channels.
    #[serde(default = "identity")]
    pub color_transform: [f64; 9],
    /// m, added last; linear radiance.
    #[serde(default)]
    pub color_mean: [f64; 3],
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
fn is_false(flag: &bool) -> bool {
    !flag
}

fn identity() -> [f64; 9] {
    IDENTITY
}

impl Factorization {
    /// Factors of R, G and B themselves.
    pub fn of_rank(rank: u32) -> Self {
        Self {
            rank,
            shared_eigentextures: false,
            color_transform: IDENTITY,
            color_mean: [0.0; 3],
        }
    }

    /// Sets of eigentextures: one per channel, or one.
    pub fn sets(&self) -> usize {
        match self.shared_eigentextures {
            true => 1,
            false => CHANNELS,
        }
    }

    /// Whether the channels are R, G and B as they stand.
    pub fn is_plain_color(&self) -> bool {
        self.color_transform == IDENTITY && self.color_mean == [0.0; 3]
    }

    /// Sides of `directions.npy`: [C, images, K].
    pub fn directions_shape(&self, images: usize) -> Vec<usize> {
        vec![CHANNELS, images, self.rank as usize]
    }

    /// Sides of `eigentextures.npy`: [C, H·W, K], or [1, H·W, K] where they are shared.
    pub fn eigentextures_shape(&self, texels: usize) -> Vec<usize> {
        vec![self.sets(), texels, self.rank as usize]
    }

    /// Refuses ranks and colour steps that no sample of this many images and texels can have.
    pub fn check(&self, images: usize, texels: usize) -> Result<()> {
        // A shared set stands for the images of all channels.
        let rows = images.saturating_mul(CHANNELS / self.sets());
        let largest = rows.min(texels).min(LARGEST_RANK as usize);
        if self.rank == 0 || self.rank as usize > largest {
            return Err(Error::data("rank", self.rank.to_string()).expected(format!(
                "1 to {largest}: no more than {rows} images, {texels} texels and {LARGEST_RANK}"
            )));
        }
        let named = [
            ("color_transform", &self.color_transform[..]),
            ("color_mean", &self.color_mean[..]),
        ];
        for (field, numbers) in named {
            let sound = |number: &f64| number.abs() <= LARGEST_COLOR;
            if let Some(at) = numbers.iter().position(|number| !sound(number)) {
                return Err(
                    Error::data(format!("{field}[{at}]"), numbers[at].to_string()).expected(
                        format!("numbers from −{LARGEST_COLOR:e} to {LARGEST_COLOR:e}"),
                    ),
                );
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_and_colours_out_of_range_are_refused() {
        let refused = |factors: Factorization| factors.check(7, 20).unwrap_err().to_string();
        Factorization::of_rank(7).check(7, 20).unwrap();
        for rank in [0, 8] {
            assert!(refused(Factorization::of_rank(rank)).contains("rank"));
        }
        let shared = Factorization {
            shared_eigentextures: true,
            ..Factorization::of_rank(20)
        };
        shared.check(7, 20).unwrap();
        assert!(refused(Factorization { rank: 21, ..shared }).contains("1 to 20"));
        let mut odd = Factorization::of_rank(1);
        odd.color_transform[4] = f64::NAN;
        assert!(refused(odd).contains("color_transform[4]: NaN"));
    }
}

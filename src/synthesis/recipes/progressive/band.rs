//! Which texels may stand at a site: those whose transition value is near the site's (Zhang 2003 eq. 1).

/// The whole texels of a level by their transition value.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// The value of each texel.
    values: Vec<f32>,
    /// Whole texels by value, then by number.
    ordered: Vec<u32>,
    /// A texel may stand where the values differ by less than this.
    tolerance: f32,
}

impl Band {
    /// Orders the whole texels of a level by their values.
    pub fn new(values: Vec<f32>, whole: &[u32], tolerance: f32) -> Self {
        let mut ordered = whole.to_vec();
        let value = |texel: u32| values[texel as usize];
        ordered.sort_by(|&a, &b| value(a).total_cmp(&value(b)).then(a.cmp(&b)));
        Self {
            values,
            ordered,
            tolerance,
        }
    }

    /// Whether a texel may stand where the surface has some value.
    #[inline(always)]
    pub fn admits(&self, texel: u32, value: f32) -> bool {
        (self.values[texel as usize] - value).abs() < self.tolerance
    }

    /// The smallest and the largest value of a whole texel.
    pub fn range(&self) -> [f32; 2] {
        let value =
            |texel: Option<&u32>| texel.map_or(f32::NAN, |&texel| self.values[texel as usize]);
        [self.ordered.first(), self.ordered.last()].map(value)
    }

    /// Moves values that lie beyond those of all whole texels to the nearest of these.
    pub fn clamp(&self, values: &mut [f32]) {
        let [least, most] = self.range();
        values
            .iter_mut()
            .for_each(|value| *value = value.max(least).min(most));
    }

    /// Texels may stand where the values differ by less than this.
    pub fn tolerance(&self) -> f32 {
        self.tolerance
    }

    /// All whole texels that may stand where the surface has some value.
    pub fn texels(&self, value: f32) -> &[u32] {
        let below =
            |texel: &u32| self.values[*texel as usize] <= value && !self.admits(*texel, value);
        let begin = self.ordered.partition_point(below);
        let within = |texel: &u32| self.admits(*texel, value);
        let count = self.ordered[begin..].partition_point(within);
        &self.ordered[begin..begin + count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_texels_of_a_value_are_those_that_it_admits() {
        let values: Vec<f32> = (0..50).map(|at| ((at * 37) % 50) as f32 / 49.0).collect();
        let whole: Vec<u32> = (0..50).filter(|at| at % 7 != 3).collect();
        let band = Band::new(values, &whole, 0.1);
        for value in [0.0, 0.03, 0.5, 0.98, 1.0] {
            let mut found = band.texels(value).to_vec();
            found.sort_unstable();
            let admitted = whole.iter().copied().filter(|&at| band.admits(at, value));
            assert_eq!(found, admitted.collect::<Vec<_>>());
        }
        assert!(band.texels(2.0).is_empty());
    }
}

//! Errors of predictions, whole and by angle.

/// Degrees of a bin of angles.
const BIN: f64 = 15.0;
/// Bins from directly above to the horizon.
const BINS: usize = 6;

/// Squared errors and squared values, summed; of reflectance times the light's cosine, 1 for white facing the light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorSum {
    /// Squared errors.
    pub errors: f64,
    /// Squared values.
    pub values: f64,
    /// How many numbers.
    pub count: u64,
}

impl ErrorSum {
    /// Adds the error of one number.
    pub fn add(&mut self, predicted: f32, measured: f32) {
        let error = f64::from(predicted - measured);
        self.errors += error * error;
        self.values += f64::from(measured).powi(2);
        self.count += 1;
    }

    /// Adds all of another sum.
    pub fn join(&mut self, other: &Self) {
        self.errors += other.errors;
        self.values += other.values;
        self.count += other.count;
    }

    /// Peak signal-to-noise ratio in dB, the peak being white that faces the light; infinite without any error.
    pub fn psnr(&self) -> f64 {
        -10.0 * (self.errors / self.count as f64).log10()
    }

    /// The root mean square error over that of the values; 0 where all is black and predicted so.
    pub fn relative(&self) -> f64 {
        match self.errors > 0.0 {
            true => (self.errors / self.values).sqrt(),
            false => 0.0,
        }
    }
}

/// The errors of directions in one bin of angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngleError {
    /// Degrees from the normal: from here, up to 15° more.
    pub from_deg: f64,
    /// Directions that were left out.
    pub directions: usize,
    /// Their errors.
    pub sum: ErrorSum,
}

impl AngleError {
    /// The bin's other end, in degrees from the normal.
    pub fn to_deg(&self) -> f64 {
        self.from_deg + BIN
    }
}

/// The errors of all directions that were left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeldOutErrors {
    bins: [AngleError; BINS],
}

impl HeldOutErrors {
    /// Adds the errors of a direction at this angle from the normal, in radians.
    pub fn add(&mut self, theta: f64, sum: &ErrorSum) {
        // Directions on a bin's border belong to it, whatever their rounding.
        let bin = (((theta.to_degrees() + 1e-6) / BIN) as usize).min(BINS - 1);
        self.bins[bin].directions += 1;
        self.bins[bin].sum.join(sum);
    }

    /// All errors.
    pub fn whole(&self) -> ErrorSum {
        let mut whole = ErrorSum::default();
        self.bins.iter().for_each(|bin| whole.join(&bin.sum));
        whole
    }

    /// The bins in which directions were left out.
    pub fn by_angle(&self) -> impl Iterator<Item = AngleError> {
        let numbered = self.bins.iter().enumerate();
        let filled = numbered.filter(|(_, bin)| bin.directions > 0);
        filled.map(|(number, bin)| AngleError {
            from_deg: number as f64 * BIN,
            ..*bin
        })
    }
}

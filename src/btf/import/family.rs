//! Families of measured image sets: what is known of their images beside what the files say.

/// Whose images they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Family {
    /// Nobody's in particular.
    #[default]
    Any,
    /// UBO2003 and ATRIUM of the University of Bonn: JPEG, and Radiance HDR whose size line is wrong.
    Bonn,
    /// UTIA BTF of the Czech Academy of Sciences: PNG in sRGB, OpenEXR in XYZ.
    Utia,
    /// SPECTRAL of the University of Bonn: OpenEXR with a channel per wavelength, without the light's cosine.
    Spectral,
    /// CUReT of Columbia University: BMP.
    Curet,
}

impl Family {
    /// Its name in `btf.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Any => "images with angles",
            Self::Bonn => "ubo2003",
            Self::Utia => "utia",
            Self::Spectral => "spectral",
            Self::Curet => "curet",
        }
    }
}

//! Colour models: what the channels of a factored file stand for, and the way to RGB and back.
//!
//! Numbers and names are those of btflib (`undecorrelate`). ε = 10⁻⁵ keeps logarithms finite.
//!
//! Deviation: btflib turns L*a*b* to sRGB and leaves sRGB's curve on, while all other models give values in
//! proportion to light. Here model 2 gives linear Rec. 709 as well.

use glam::{DMat3, DVec3};

use crate::btf::bonn::lab;
use crate::error::{Error, Result};

/// What is added before a logarithm is taken.
pub const EPSILON: f64 = 1e-5;

/// How three channels stand for a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorModel {
    /// 0: red, green, blue.
    Rgb,
    /// 1: Y, U, V.
    Yuv,
    /// 2: L*, a*, b* with the white of D50.
    Lab,
    /// 3: principal components, with a mean and a matrix in the file.
    Pca,
    /// 4: Y, Co, Cg.
    YCoCg,
    /// 5: the sum, and each other channel over the sum.
    Spectral,
    /// 9: ln(Y + ε), U, V.
    LogYUv,
    /// 10: ln(Y + ε), ± ln(|U| / ε), ± ln(|V| / ε).
    LogYuv,
    /// 11: ln(Y + ε), U / (Y + ε), V / (Y + ε).
    LogYRatios,
    /// 12: ln(R + ε), ln(G + ε), ln(B + ε).
    LogRgb,
}

/// All models with their numbers and names.
const MODELS: [(i32, ColorModel, &str); 10] = [
    (0, ColorModel::Rgb, "RGB"),
    (1, ColorModel::Yuv, "YUV"),
    (2, ColorModel::Lab, "LAB"),
    (3, ColorModel::Pca, "PCA"),
    (4, ColorModel::YCoCg, "YCoCg"),
    (5, ColorModel::Spectral, "SPECTRAL"),
    (9, ColorModel::LogYUv, "logY U V"),
    (10, ColorModel::LogYuv, "logY logU logV"),
    (11, ColorModel::LogYRatios, "logY U/Y V/Y"),
    (12, ColorModel::LogRgb, "logR logG logB"),
];

impl ColorModel {
    /// The model of a number in a file.
    pub(super) fn of_number(number: i32) -> Result<Self> {
        if let Some((_, model, _)) = MODELS.iter().find(|(known, ..)| *known == number) {
            return Ok(*model);
        }
        let known: Vec<String> = MODELS
            .iter()
            .map(|(number, _, name)| format!("{number} ({name})"))
            .collect();
        let fault = match number {
            6 => Error::data("color_model", "6 (SPECTRAL_LINEAR)").advice(
                "the only public description of this model is not invertible; convert the file to \
                 another model with the program that made it",
            ),
            other => Error::data("color_model", other.to_string()),
        };
        Err(fault.expected(known.join(", ")))
    }

    /// Its number in a file.
    pub fn number(self) -> i32 {
        let found = MODELS.iter().find(|(_, model, _)| *model == self);
        found.map_or(0, |(number, ..)| *number)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        let found = MODELS.iter().find(|(_, model, _)| *model == self);
        found.map_or("", |(.., name)| name)
    }
}

/// A model with the numbers that a file gives for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color {
    /// The model.
    pub model: ColorModel,
    /// The mean of [`ColorModel::Pca`].
    pub mean: [f32; 3],
    /// The matrix of [`ColorModel::Pca`], row-major: RGB = v M + mean with a row v.
    pub transform: [f32; 9],
}

/// RGB from Y, U, V, as columns.
const RGB_FROM_YUV: DMat3 = DMat3::from_cols(
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(0.0, -0.394_65, 2.032_11),
    DVec3::new(1.139_83, -0.580_6, 0.0),
);

/// RGB from Y, Co, Cg, as columns.
const RGB_FROM_YCOCG: DMat3 = DMat3::from_cols(
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 0.0, -1.0),
    DVec3::new(-1.0, 1.0, -1.0),
);

impl Color {
    /// A model without numbers of its own.
    pub fn of(model: ColorModel) -> Self {
        Self {
            model,
            mean: [0.0; 3],
            transform: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        }
    }

    /// T and m of RGB = T v + m, where the model is linear.
    pub fn linear(&self) -> Option<(DMat3, DVec3)> {
        match self.model {
            ColorModel::Rgb => Some((DMat3::IDENTITY, DVec3::ZERO)),
            ColorModel::Yuv => Some((RGB_FROM_YUV, DVec3::ZERO)),
            ColorModel::YCoCg => Some((RGB_FROM_YCOCG, DVec3::ZERO)),
            ColorModel::Pca => {
                // The rows of M are the columns of T.
                let matrix = DMat3::from_cols_array(&self.transform.map(f64::from));
                Some((matrix, DVec3::from_array(self.mean.map(f64::from))))
            }
            _ => None,
        }
    }

    /// The RGB of channels.
    pub fn to_rgb(&self, channels: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = channels;
        let ratio = |luma: f64, part: f64| part * (luma + EPSILON);
        let unfold = |part: f64| match part == 0.0 {
            true => 0.0,
            false => part.signum() * EPSILON * part.abs().exp(),
        };
        match self.model {
            ColorModel::Rgb | ColorModel::Yuv | ColorModel::YCoCg | ColorModel::Pca => self
                .linear()
                .map_or(channels, |(matrix, mean)| matrix * channels + mean),
            ColorModel::Lab => lab::to_rgb(channels),
            ColorModel::Spectral => DVec3::new((1.0 - y - z) * x, y * x, z * x),
            ColorModel::LogYUv => RGB_FROM_YUV * DVec3::new(unlog(x), y, z),
            ColorModel::LogYuv => RGB_FROM_YUV * DVec3::new(unlog(x), unfold(y), unfold(z)),
            ColorModel::LogYRatios => {
                let luma = unlog(x);
                RGB_FROM_YUV * DVec3::new(luma, ratio(luma, y), ratio(luma, z))
            }
            ColorModel::LogRgb => DVec3::new(unlog(x), unlog(y), unlog(z)),
        }
    }

    /// The channels of an RGB, none of it negative; `None` where the file's matrix cannot be undone.
    pub fn of_rgb(&self, rgb: DVec3) -> Option<DVec3> {
        let yuv = || RGB_FROM_YUV.inverse() * rgb;
        let fold = |part: f64| match part.abs() > EPSILON {
            true => part.signum() * (part.abs() / EPSILON).ln(),
            false => 0.0,
        };
        // Undo the model; those with a matrix share one way.
        Some(match self.model {
            ColorModel::Rgb | ColorModel::Yuv | ColorModel::YCoCg | ColorModel::Pca => {
                let (matrix, mean) = self.linear()?;
                let inverse = matrix.inverse();
                inverse.is_finite().then(|| inverse * (rgb - mean))?
            }
            ColorModel::Lab => lab::of_rgb(rgb),
            ColorModel::Spectral => match rgb.element_sum() {
                0.0 => DVec3::ZERO,
                sum => DVec3::new(sum, rgb.y / sum, rgb.z / sum),
            },
            ColorModel::LogYUv => {
                let DVec3 { x, y, z } = yuv();
                DVec3::new(log(x), y, z)
            }
            ColorModel::LogYuv => {
                let DVec3 { x, y, z } = yuv();
                DVec3::new(log(x), fold(y), fold(z))
            }
            ColorModel::LogYRatios => {
                let DVec3 { x, y, z } = yuv();
                DVec3::new(log(x), y / (x + EPSILON), z / (x + EPSILON))
            }
            ColorModel::LogRgb => DVec3::new(log(rgb.x), log(rgb.y), log(rgb.z)),
        })
    }
}

/// Undoes [`log`]: also the dynamic range reduction of an FMF.
pub(super) fn unlog(value: f64) -> f64 {
    value.exp() - EPSILON
}

/// ln(v + ε).
pub(super) fn log(value: f64) -> f64 {
    (value.max(0.0) + EPSILON).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pca() -> Color {
        Color {
            model: ColorModel::Pca,
            mean: [0.1, 0.2, 0.3],
            transform: [0.5, 0.5, 0.7, -0.7, 0.7, 0.0, 0.1, -0.3, 0.9],
        }
    }

    #[test]
    fn every_model_is_undone() {
        let colors = [
            DVec3::new(0.2, 0.5, 0.1),
            DVec3::new(1.5, 0.01, 0.7),
            DVec3::splat(0.3),
            DVec3::ZERO,
        ];
        for (number, model, name) in MODELS {
            assert_eq!(ColorModel::of_number(number).unwrap(), model);
            assert_eq!((model.number(), model.name()), (number, name));
            let color = match model {
                ColorModel::Pca => pca(),
                model => Color::of(model),
            };
            for rgb in colors {
                let back = color.to_rgb(color.of_rgb(rgb).unwrap());
                assert!((back - rgb).length() < 5e-5, "{name}: {rgb} {back}");
            }
        }
    }

    #[test]
    fn known_values() {
        let of = |model, v: [f64; 3]| Color::of(model).to_rgb(DVec3::from_array(v));
        let near = |found: DVec3, wanted: [f64; 3]| {
            assert!(
                (found - DVec3::from_array(wanted)).length() < 1e-7,
                "{found}"
            );
        };
        near(
            of(ColorModel::Yuv, [0.5, 0.1, 0.2]),
            [
                0.5 + 1.13983 * 0.2,
                0.5 - 0.39465 * 0.1 - 0.5806 * 0.2,
                0.5 + 2.03211 * 0.1,
            ],
        );
        near(of(ColorModel::YCoCg, [0.5, 0.1, 0.2]), [0.4, 0.7, 0.2]);
        let luma = 0.5 + EPSILON;
        near(
            of(ColorModel::LogYRatios, [luma.ln(), 0.0, 0.1]),
            [0.5 + 1.13983 * 0.1 * luma, 0.5 - 0.5806 * 0.1 * luma, 0.5],
        );
        // v M + mean, M row-major.
        near(
            pca().to_rgb(DVec3::new(1.0, 0.0, 2.0)),
            [0.5 + 0.2 + 0.1, 0.5 - 0.6 + 0.2, 0.7 + 1.8 + 0.3].map(|v| (v * 1e9f64).round() / 1e9),
        );
    }

    #[test]
    fn unknown_models_are_refused_with_the_known_ones() {
        for (number, says) in [(7, "11 (logY U/Y V/Y)"), (6, "SPECTRAL_LINEAR"), (-1, "-1")] {
            let text = ColorModel::of_number(number).unwrap_err().to_string();
            assert!(text.contains(says), "{text}");
        }
    }
}

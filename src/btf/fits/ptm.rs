//! Polynomial texture maps, `.ptm` (Malzbender 2001; HP Labs' file format 1.1 and 1.2).
//!
//! A header in text: `PTM_1.2`, a format, width and height, six scales, six biases; then bytes, rows from the
//! bottom to the top. A coefficient is (byte − bias) · scale. `PTM_FORMAT_LRGB`: six coefficients per texel, then
//! red, green and blue per texel (1.1: nine bytes per texel); a texel is its colour times its sum over 255.
//! `PTM_FORMAT_RGB`: a block of six coefficients per texel for red, one for green, one for blue. Colours are those
//! of displays.

use std::io::{self, Write};
use std::path::Path;

use crate::btf::fits::basis::Basis;
use crate::btf::fits::fit::{Colors, Fit};
use crate::btf::fits::header::{Header, take};
use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::guard::guarded;
use crate::format::ours::PTM_MARK;

/// Coefficients of a sum.
const TERMS: usize = 6;
/// What is read, for errors.
const READ: &str = "PTM_FORMAT_LRGB or PTM_FORMAT_RGB";

/// Reads a `.ptm` file.
pub fn read(path: &Path) -> Result<Fit> {
    let bytes = std::fs::read(path).map_err(Error::io(path, "read"))?;
    guarded(path, || parse(&bytes))
}

/// The fit in the bytes of a `.ptm` file.
fn parse(bytes: &[u8]) -> Result<Fit> {
    let mut header = Header::new(bytes);
    let is_interleaved = match header.line("version")? {
        "PTM_1.2" => false,
        "PTM_1.1" => true,
        other => {
            return Err(Error::data("version", format!("`{other}`")).expected("PTM_1.1 or PTM_1.2"));
        }
    };
    let colors = colors_of(header.line("format")?)?;
    let (width, height) = header.sides()?;
    let mut scale = vec![0.0; TERMS];
    for (term, scale) in scale.iter_mut().enumerate() {
        *scale = header.float(&format!("scale {term}"))?;
    }
    let mut offset = vec![0.0; TERMS];
    for (term, offset) in offset.iter_mut().enumerate() {
        *offset = -header.float(&format!("bias {term}"))? * scale[term];
    }
    let mut fit = Fit {
        width,
        height,
        basis: Basis::Polynomial,
        colors,
        scale,
        offset,
        coefficients: Vec::new(),
        texel_colors: Vec::new(),
        white: 255.0,
    };
    let body = header.end()?;
    match (colors, is_interleaved) {
        (Colors::Rgb, _) => read_planes(&mut fit, body)?,
        (Colors::Lrgb, false) => read_blocks(&mut fit, body)?,
        (Colors::Lrgb, true) => read_interleaved(&mut fit, body)?,
    }
    Ok(fit)
}

fn colors_of(format: &str) -> Result<Colors> {
    let fault = |advice: &str| {
        Err(Error::data("format", format!("`{format}`"))
            .expected(READ)
            .advice(advice))
    };
    match format {
        "PTM_FORMAT_LRGB" => Ok(Colors::Lrgb),
        "PTM_FORMAT_RGB" => Ok(Colors::Rgb),
        _ if format.starts_with("PTM_FORMAT_JPEG") => fault(
            "its coefficients are compressed, some as differences from others: save it uncompressed with the \
             program that made it",
        ),
        "PTM_FORMAT_LUM" => fault("its colours are stored as differences: save it as LRGB"),
        _ => fault("the file is of another kind, or damaged"),
    }
}

fn read_blocks(fit: &mut Fit, mut body: &[u8]) -> Result<()> {
    let texels = fit.texels() as u64;
    let coefficients = take(&mut body, TERMS as u64 * texels, "coefficients")?;
    let colors = take(&mut body, 3 * texels, "colours")?;
    fit.coefficients = turned_over(coefficients, TERMS * fit.width as usize);
    fit.texel_colors = turned_over(colors, 3 * fit.width as usize);
    Ok(())
}

fn read_interleaved(fit: &mut Fit, mut body: &[u8]) -> Result<()> {
    let texels = fit.texels() as u64;
    let both = take(
        &mut body,
        (TERMS as u64 + 3) * texels,
        "coefficients and colours",
    )?;
    for texel in turned_over(both, (TERMS + 3) * fit.width as usize).chunks_exact(TERMS + 3) {
        fit.coefficients.extend_from_slice(&texel[..TERMS]);
        fit.texel_colors.extend_from_slice(&texel[TERMS..]);
    }
    Ok(())
}

fn read_planes(fit: &mut Fit, mut body: &[u8]) -> Result<()> {
    let (count, row) = (fit.texels(), TERMS * fit.width as usize);
    let planes = take(
        &mut body,
        (3 * TERMS * count) as u64,
        "coefficients of three colours",
    )?;
    let planes: Vec<Vec<u8>> = planes
        .chunks_exact(TERMS * count)
        .map(|plane| turned_over(plane, row))
        .collect();
    fit.coefficients.reserve(3 * TERMS * count);
    for texel in 0..count {
        for plane in &planes {
            fit.coefficients
                .extend_from_slice(&plane[texel * TERMS..][..TERMS]);
        }
    }
    Ok(())
}

/// The same rows, the last one first.
fn turned_over(bytes: &[u8], row: usize) -> Vec<u8> {
    bytes.chunks_exact(row).rev().flatten().copied().collect()
}

/// Writes a fit of polynomials as PTM 1.2.
pub fn write(path: &Path, fit: &Fit) -> Result<()> {
    atomic::write_file(path, |sink| encode(sink, fit))
}

fn encode(sink: &mut impl Write, fit: &Fit) -> io::Result<()> {
    if fit.basis != Basis::Polynomial {
        return Err(io::Error::other("no polynomials"));
    }
    let format = match fit.colors {
        Colors::Lrgb => "LRGB",
        Colors::Rgb => "RGB",
    };
    writeln!(
        sink,
        "PTM_1.2\nPTM_FORMAT_{format}\n{}\n{}",
        fit.width, fit.height
    )?;
    let scales: Vec<String> = fit.scale.iter().map(f32::to_string).collect();
    let bias = |(offset, scale): (&f32, &f32)| format!("{}", (-offset / scale).round());
    let biases: Vec<String> = fit.offset.iter().zip(&fit.scale).map(bias).collect();
    writeln!(sink, "{}\n{}", scales.join(" "), biases.join(" "))?;
    encode_texels(sink, fit)?;
    sink.write_all(PTM_MARK)
}

fn encode_texels(sink: &mut impl Write, fit: &Fit) -> io::Result<()> {
    let width = fit.width as usize;
    match fit.colors {
        Colors::Lrgb => {
            sink.write_all(&turned_over(&fit.coefficients, TERMS * width))?;
            sink.write_all(&turned_over(&fit.texel_colors, 3 * width))
        }
        Colors::Rgb => (0..3).try_for_each(|channel| {
            let texels = fit.coefficients.chunks_exact(3 * TERMS);
            let plane: Vec<u8> = texels
                .flat_map(|texel| texel[channel * TERMS..][..TERMS].iter().copied())
                .collect();
            sink.write_all(&turned_over(&plane, TERMS * width))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(colors: Colors) -> Fit {
        let per_texel = if colors == Colors::Rgb { 18 } else { 6 };
        let scale = vec![0.5, 0.25, 1.0, 2.0, 1.5, 0.125];
        let bias: [f32; 6] = [128.0, 0.0, 7.0, 255.0, 1.0, 20.0];
        Fit {
            width: 2,
            height: 3,
            basis: Basis::Polynomial,
            colors,
            offset: bias
                .iter()
                .zip(&scale)
                .map(|(bias, scale)| -bias * scale)
                .collect(),
            scale,
            coefficients: (0..6 * per_texel).map(|k| (k * 7 % 251) as u8).collect(),
            texel_colors: match colors {
                Colors::Lrgb => (0..18).map(|k| k as u8 * 11).collect(),
                Colors::Rgb => Vec::new(),
            },
            white: 255.0,
        }
    }

    fn bytes_of(fit: &Fit) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(&mut bytes, fit).unwrap();
        assert!(bytes.ends_with(PTM_MARK));
        bytes.truncate(bytes.len() - PTM_MARK.len());
        bytes
    }

    #[test]
    fn both_formats_round_trip() {
        for colors in [Colors::Lrgb, Colors::Rgb] {
            let fit = fit(colors);
            assert_eq!(parse(&bytes_of(&fit)).unwrap(), fit);
        }
    }

    /// The first texel of the file is the lower left one.
    #[test]
    fn rows_run_from_the_bottom() {
        let fit = fit(Colors::Lrgb);
        let bytes = bytes_of(&fit);
        let body = bytes.len() - 6 * 9;
        assert_eq!(bytes[body..body + 6], fit.coefficients[4 * 6..5 * 6]);
    }

    #[test]
    fn headers_of_other_programs_are_read() {
        let fit = fit(Colors::Lrgb);
        let bytes = bytes_of(&fit);
        let body = &bytes[bytes.len() - 6 * 9..];
        let scales = "0.5 0.25 1.0 2 1.5 0.125";
        for header in [
            format!("PTM_1.2\r\nPTM_FORMAT_LRGB \r\n2 3\r\n{scales} \r\n128 0 7 255 1 20 \r\n"),
            format!("PTM_1.2\nPTM_FORMAT_LRGB\n2\n3\n{scales} 128 0 7 255 1 20 \n"),
        ] {
            let bytes = [header.as_bytes(), body, b"x"].concat();
            assert_eq!(parse(&bytes).unwrap(), fit);
        }
        let mut older = b"PTM_1.1\nPTM_FORMAT_LRGB\n2\n3\n".to_vec();
        older.extend(format!("{scales}\n128 0 7 255 1 20\n").bytes());
        for (coefficients, color) in body[..36].chunks(6).zip(body[36..].chunks(3)) {
            older.extend(coefficients.iter().chain(color));
        }
        assert_eq!(parse(&older).unwrap(), fit);
    }

    #[test]
    fn what_is_not_read_is_refused_with_a_reason() {
        let bytes = bytes_of(&fit(Colors::Lrgb));
        let refused = |from: &str, to: &str| {
            let text = String::from_utf8_lossy(&bytes[..60]).replacen(from, to, 1);
            parse(text.as_bytes()).unwrap_err().to_string()
        };
        assert!(refused("LRGB", "JPEG_LRGB").contains("uncompressed"));
        assert!(refused("LRGB", "LUM").contains("save it as LRGB"));
        assert!(refused("LRGB", "PTM_LUT").contains("PTM_FORMAT_RGB"));
        assert!(refused("PTM_1.2", "PTM_2").contains("PTM_1.1 or PTM_1.2"));
        assert!(refused("0.25", "inf").contains("scale 1"));
        let cut = parse(&bytes[..bytes.len() - 1]).unwrap_err().to_string();
        assert!(
            cut.contains("17 bytes") && cut.contains("18 bytes"),
            "{cut}"
        );
    }
}

//! Writing a `.btf` file of any signature, version and number type.

use std::path::Path;

use crate::btf::bonn::bdi::BdiContent;
use crate::btf::bonn::dfmf::DfmfContent;
use crate::btf::bonn::fmf::FmfContent;
use crate::btf::bonn::output::write_file;
use crate::btf::bonn::pvf::PvfContent;
use crate::btf::bonn::signature::{Format, Signature};
use crate::error::{Error, Result};

/// What a file is written from.
pub enum Written<'a> {
    /// A DFMF file.
    Dfmf(DfmfContent<'a>),
    /// An FMF file.
    Fmf(FmfContent<'a>),
    /// A PVF file.
    Pvf(PvfContent<'a>),
    /// A BDI file.
    Bdi(BdiContent<'a>),
}

impl Written<'_> {
    fn format(&self) -> Format {
        match self {
            Self::Dfmf(_) => Format::Dfmf,
            Self::Fmf(_) => Format::Fmf,
            Self::Pvf(_) => Format::Pvf,
            Self::Bdi(_) => Format::Bdi,
        }
    }
}

/// Writes a file that begins with `signature`; on any failure what stands at `path` stays.
pub fn encode(path: &Path, signature: &Signature, mut content: Written<'_>) -> Result<()> {
    if content.format() != signature.format {
        return Err(Error::data("signature", signature.text)
            .expected(format!("one of {}", content.format().name())));
    }
    let has_rotations = signature.has_rotations;
    write_file(path, |output| {
        output.bytes(signature.text.as_bytes())?;
        match &mut content {
            Written::Dfmf(content) => {
                content.header.write(output, has_rotations)?;
                content.write(output)
            }
            Written::Fmf(content) => {
                content.header.write(output, has_rotations)?;
                content.write(output)
            }
            Written::Pvf(content) => content.write(output, has_rotations),
            Written::Bdi(content) => content.write(output),
        }
    })
}

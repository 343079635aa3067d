//! The JSON that describes a glTF file, checked for what the `gltf` crate takes for granted.

use gltf::Gltf;
use serde_json::Value;

use crate::error::{Error, Result};
use crate::format::json;

/// A file's description and the buffer inside it.
pub(super) struct Description {
    /// The whole JSON.
    pub json: Value,
    blob: Option<Vec<u8>>,
}

impl Description {
    /// Reads the JSON of a text or a binary file.
    pub fn read(bytes: &[u8]) -> Result<Self> {
        let (text, blob) = match bytes.strip_prefix(b"glTF") {
            Some(rest) => binary_chunks(bytes, rest)?,
            None => (bytes, None),
        };
        let json: Value = json::parse(text)?;
        check_positions(&json)?;
        Ok(Self {
            json,
            blob: blob.map(<[u8]>::to_vec),
        })
    }

    /// The file as the crate sees it, validated.
    pub fn file(&mut self) -> Result<Gltf> {
        let text = self.json.to_string();
        let mut file = Gltf::from_slice(text.as_bytes()).map_err(|error| {
            Error::data("glTF", error.to_string()).advice("the file is damaged, or not glTF 2.0")
        })?;
        file.blob = self.blob.take();
        Ok(file)
    }
}

/// Positions must stand in the list of accessors.
fn check_positions(description: &Value) -> Result<()> {
    let accessors = list(description, "accessors").len() as u64;
    for mesh in list(description, "meshes") {
        for primitive in list(mesh, "primitives") {
            let position = primitive["attributes"]["POSITION"].as_u64();
            if let Some(index) = position.filter(|&index| index >= accessors) {
                return Err(Error::data("POSITION", format!("accessor {index}"))
                    .expected(format!("below {accessors} accessors")));
            }
        }
    }
    Ok(())
}

/// A list of a description, empty where it is missing.
pub(super) fn list<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().map_or(&[], Vec::as_slice)
}

/// Bytes before the JSON of a binary file: its own header and the chunk's.
const GLB_HEADER: usize = 20;
/// Bytes before the buffer behind it: length and kind.
const CHUNK_HEADER: usize = 8;

/// The JSON chunk of a binary file, and the binary chunk where there is one.
fn binary_chunks<'a>(bytes: &'a [u8], rest: &[u8]) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    let fault =
        |found: String| Error::data("GLB header", found).expected("lengths inside the file");
    let number = |at: usize| {
        let four = rest.get(at..at + 4).and_then(|four| four.try_into().ok());
        four.map(|four| u32::from_le_bytes(four) as usize)
            .ok_or_else(|| fault(format!("{} bytes", bytes.len())))
    };
    // Check version and lengths.
    if number(0)? != 2 {
        return Err(
            Error::data("GLB header", format!("version {}", number(0)?)).expected("version 2")
        );
    }
    let (length, chunk) = (number(4)?, number(8)?);
    if length < GLB_HEADER || length > bytes.len() {
        return Err(fault(format!("length {length} of {} bytes", bytes.len())));
    }
    let bytes = &bytes[..length];
    let end = chunk.checked_add(GLB_HEADER);
    // Cut out the JSON chunk.
    let text = end
        .and_then(|end| bytes.get(GLB_HEADER..end))
        .ok_or_else(|| fault(format!("a description of {chunk} bytes")))?;
    // Cut out the binary chunk behind it.
    let Some((header, content)) = bytes[GLB_HEADER + chunk..].split_at_checked(CHUNK_HEADER) else {
        return Ok((text, None));
    };
    let length = u32::from_le_bytes([header[0], header[1], header[2], header[3]]) as usize;
    if header[4..] != *b"BIN\0" {
        return Ok((text, None));
    }
    let blob = content
        .get(..length)
        .ok_or_else(|| fault(format!("a buffer of {length} bytes")))?;
    Ok((text, Some(blob)))
}

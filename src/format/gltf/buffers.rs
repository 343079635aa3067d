//! The bytes a glTF file's accessors lie in: inside a binary file, in `data:` addresses, or in files
//! beside it. Each source is read once, however many buffers name it.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::rc::Rc;

use gltf::buffer::Source;
use percent_encoding::percent_decode_str;

use crate::error::{Error, Result};
use crate::format::atomic;

/// The buffers of a file; those that share a source share its bytes.
pub(super) struct Buffers<'a> {
    /// The bytes of each buffer.
    pub contents: Vec<Rc<Cow<'a, [u8]>>>,
    /// Bytes that were read from files beside the glTF.
    pub outside: usize,
}

impl<'a> Buffers<'a> {
    /// Reads all buffers of a file that lies at `path`.
    pub fn read(file: &'a gltf::Gltf, path: &Path) -> Result<Self> {
        let mut buffers = Self {
            contents: Vec::new(),
            outside: 0,
        };
        let blob = Rc::new(Cow::Borrowed(file.blob.as_deref().unwrap_or_default()));
        let mut known: HashMap<&str, Rc<Cow<'_, [u8]>>> = HashMap::new();
        for buffer in file.buffers() {
            let bytes = match buffer.source() {
                Source::Bin => Rc::clone(&blob),
                Source::Uri(uri) => match known.get(uri) {
                    Some(bytes) => Rc::clone(bytes),
                    None => {
                        let bytes = Rc::new(Cow::Owned(buffers.uri_bytes(uri, path)?));
                        known.insert(uri, Rc::clone(&bytes));
                        bytes
                    }
                },
            };
            if bytes.len() < buffer.length() {
                let place = format!("buffer {}", buffer.index());
                return Err(Error::data(place, format!("{} bytes", bytes.len()))
                    .expected(format!("{}", buffer.length())));
            }
            buffers.contents.push(bytes);
        }
        Ok(buffers)
    }

    /// The bytes of a `data:` address, or of a file beside the glTF.
    fn uri_bytes(&mut self, uri: &str, path: &Path) -> Result<Vec<u8>> {
        if let Some(data) = uri.strip_prefix("data:") {
            let encoded = data
                .split_once("base64,")
                .map_or("", |(_, encoded)| encoded);
            return decode_base64(encoded)
                .ok_or_else(|| Error::data("buffer", "a data address").expected("base64"));
        }
        let name = file_name(uri);
        if uri.contains("://")
            || Path::new(&*name).is_absolute()
            || name.split('/').any(|part| part == "..")
        {
            return Err(Error::data("buffer", format!("address `{uri}`"))
                .expected("a file beside the glTF, or a data address"));
        }
        let bytes = read_file(&atomic::parent(path).join(&*name))?;
        self.outside = self.outside.saturating_add(bytes.len());
        Ok(bytes)
    }
}

/// The name of a file that an address stands for: bytes may be written as `%20`.
pub(super) fn file_name(uri: &str) -> Cow<'_, str> {
    percent_decode_str(uri).decode_utf8_lossy()
}

/// The bytes of a plain file: a device would never end.
fn read_file(path: &Path) -> Result<Vec<u8>> {
    let told = fs::metadata(path).map_err(Error::io(path, "read"))?;
    if !told.is_file() {
        return Err(Error::data("buffer", "not a regular file")
            .expected("a file")
            .in_file(path));
    }
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(Error::io(path, "read"))?;
    file.take(told.len())
        .read_to_end(&mut bytes)
        .map_err(Error::io(path, "read"))?;
    Ok(bytes)
}

fn decode_base64(encoded: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(encoded.len() / 4 * 3);
    let (mut held, mut bits) = (0u32, 0);
    for symbol in encoded
        .bytes()
        .filter(|b| !b.is_ascii_whitespace() && *b != b'=')
    {
        let value = match symbol {
            b'A'..=b'Z' => symbol - b'A',
            b'a'..=b'z' => symbol - b'a' + 26,
            b'0'..=b'9' => symbol - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        held = held << 6 | u32::from(value);
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((held >> bits) as u8);
            held &= (1 << bits) - 1;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_may_be_percent_encoded() {
        assert_eq!(file_name("Box%20With%20Spaces.bin"), "Box With Spaces.bin");
        assert_eq!(file_name("b%C3%B6x 100%.bin"), "böx 100%.bin");
    }

    #[test]
    fn base64_decodes() {
        assert_eq!(decode_base64("bWVzaA==").unwrap(), b"mesh");
        assert_eq!(decode_base64("bW*z"), None);
    }
}

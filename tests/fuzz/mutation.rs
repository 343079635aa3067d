//! What is done to a file: bits, numbers, blocks; fields of JSON and numbers of text; checksums made
//! right again, so that a change reaches what lies behind them.

use std::io::{Cursor, Read, Write};

use mesotex::random::{Stream, stream};
use rand::Rng;
use serde_json::Value;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// What a file holds, for mutations that know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Bytes.
    Bytes,
    /// Lines of words and numbers.
    Text,
    /// One JSON value.
    Json,
    /// A zip archive with a `meta.json`.
    Zip,
    /// Chunks of a PNG.
    Png,
    /// A gzip file of text.
    Gzip,
    /// A binary glTF file.
    Glb,
}

/// Numbers at which counts and sizes go wrong.
const NUMBERS: [u64; 18] = [
    0,
    1,
    2,
    3,
    7,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x10000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    u64::MAX,
];

/// The same in text, and what else a number may be written as.
const WORDS: [&str; 20] = [
    "0",
    "-1",
    "1",
    "2",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "-2147483648",
    "4294967295",
    "18446744073709551615",
    "1e308",
    "-1e-320",
    "nan",
    "inf",
    "1e39",
    "0.5",
    "x",
    "",
];

/// Makes one mutated file.
pub struct Mutator {
    random: Stream,
}

impl Mutator {
    /// The mutator of one file: the same numbers give the same file.
    pub fn new(seed: u64, reader: &str, run: u64) -> Self {
        Self {
            random: stream(seed, reader, 0, run),
        }
    }

    /// One of `files`, changed in one to four places.
    pub fn mutate(&mut self, files: &[Vec<u8>], content: Content) -> Vec<u8> {
        let mut bytes = self.pick(files).clone();
        if self.random.gen_bool(0.1) {
            bytes = self.splice(&bytes, files);
        }
        if content != Content::Bytes && self.random.gen_bool(0.7) {
            return self.informed(&bytes, content);
        }
        self.change(&mut bytes);
        bytes
    }

    fn informed(&mut self, bytes: &[u8], content: Content) -> Vec<u8> {
        match content {
            Content::Bytes => bytes.to_vec(),
            Content::Text => self.change_words(bytes),
            Content::Json => self.change_json(bytes),
            Content::Zip => self.change_archive(bytes),
            Content::Png => self.change_png(bytes),
            Content::Gzip => self.change_packed(bytes),
            Content::Glb => self.change_glb(bytes),
        }
    }

    fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.random.gen_range(0..list.len())]
    }

    /// A place in `length` bytes, in every other case near the start, where headers are.
    fn place(&mut self, length: usize) -> usize {
        let end = if self.random.gen_bool(0.5) {
            length.min(128)
        } else {
            length
        };
        self.random.gen_range(0..end.max(1))
    }

    /// The beginning of one file and the end of another.
    fn splice(&mut self, bytes: &[u8], files: &[Vec<u8>]) -> Vec<u8> {
        let other = self.pick(files).clone();
        let (cut, from) = (self.place(bytes.len() + 1), self.place(other.len() + 1));
        [
            &bytes[..cut.min(bytes.len())],
            &other[from.min(other.len())..],
        ]
        .concat()
    }

    /// Changes bytes in one to four places.
    fn change(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..self.random.gen_range(1..=4) {
            if bytes.is_empty() {
                return;
            }
            let at = self.place(bytes.len());
            match self.random.gen_range(0..9) {
                0 => bytes[at] ^= 1 << self.random.gen_range(0..8),
                1 => bytes[at] = self.random.r#gen(),
                2 => bytes[at] = *self.pick(&NUMBERS) as u8,
                3 | 4 => self.put_number(bytes, at),
                5 => bytes.truncate(at),
                6 => {
                    let end = (at + self.random.gen_range(1..64)).min(bytes.len());
                    bytes.drain(at..end);
                }
                7 => {
                    let end = (at + self.random.gen_range(1..64)).min(bytes.len());
                    let block = bytes[at..end].to_vec();
                    let to = self.place(bytes.len());
                    bytes.splice(to..to, block);
                }
                _ => {
                    let end = (at + self.random.gen_range(1..64)).min(bytes.len());
                    let fill: u8 = self.random.r#gen();
                    bytes[at..end].fill(fill);
                }
            }
        }
    }

    fn put_number(&mut self, bytes: &mut [u8], at: usize) {
        let number = self
            .pick(&NUMBERS)
            .wrapping_add(self.random.gen_range(0..3))
            .wrapping_sub(1);
        let size = *self.pick(&[2_usize, 4, 8]);
        let little = self.random.gen_bool(0.6);
        let at = if self.random.gen_bool(0.7) {
            at / size * size
        } else {
            at
        };
        for (k, byte) in bytes[at..].iter_mut().take(size).enumerate() {
            let shift = if little { k } else { size - 1 - k };
            *byte = (number >> (8 * shift)) as u8;
        }
    }

    /// Changes numbers, words and lines of a text, one to three times.
    fn change_words(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut text = bytes.to_vec();
        for _ in 0..self.random.gen_range(1..=3) {
            let numbers = numbers_in(&text);
            if numbers.is_empty() || self.random.gen_bool(0.2) {
                self.change_lines(&mut text);
                continue;
            }
            let chosen = self.pick(&numbers).clone();
            let word = (*self.pick(&WORDS)).as_bytes().to_vec();
            text.splice(chosen, word);
        }
        text
    }

    /// Drops, doubles or swaps a line.
    fn change_lines(&mut self, text: &mut Vec<u8>) {
        let mut lines: Vec<Vec<u8>> = text.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
        let (at, other) = (self.place(lines.len()), self.place(lines.len()));
        match self.random.gen_range(0..3) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(other, lines[at].clone()),
            _ => lines.swap(at, other),
        }
        *text = lines.join(&b'\n');
    }

    /// Changes one to three fields of a JSON value.
    fn change_json(&mut self, bytes: &[u8]) -> Vec<u8> {
        let Ok(mut value) = serde_json::from_slice::<Value>(bytes) else {
            let mut bytes = bytes.to_vec();
            self.change(&mut bytes);
            return bytes;
        };
        for _ in 0..self.random.gen_range(1..=3) {
            self.change_value(&mut value, 0);
        }
        serde_json::to_vec(&value).unwrap()
    }

    fn change_value(&mut self, value: &mut Value, depth: usize) {
        let stop = depth > 0 && self.random.gen_bool(0.1);
        match value {
            Value::Object(map) if !map.is_empty() && !stop => {
                let keys: Vec<String> = map.keys().cloned().collect();
                let key = self.pick(&keys).clone();
                if self.random.gen_bool(0.08) {
                    map.remove(&key);
                } else {
                    self.change_value(&mut map[&key], depth + 1);
                }
            }
            Value::Array(list) if !list.is_empty() && !stop => {
                let at = self.random.gen_range(0..list.len());
                match self.random.gen_range(0..12) {
                    0 => drop(list.remove(at)),
                    1 => list.insert(at, list[at].clone()),
                    _ => self.change_value(&mut list[at], depth + 1),
                }
            }
            leaf => *leaf = self.leaf(),
        }
    }

    fn leaf(&mut self) -> Value {
        match self.random.gen_range(0..10) {
            0 => Value::Null,
            1 => Value::Bool(self.random.r#gen()),
            2 => Value::String((*self.pick(&WORDS)).into()),
            3 => Value::Array(Vec::new()),
            4 => Value::from(-1_i64),
            5 => Value::from(i64::from(i32::MIN)),
            6 => Value::from(*self.pick(&[1e30, 1e-30, 0.5, -0.0, 1e308])),
            _ => Value::from(*self.pick(&NUMBERS)),
        }
    }

    /// Changes a member of an archive and packs all anew, so that every checksum is right.
    fn change_archive(&mut self, bytes: &[u8]) -> Vec<u8> {
        let Some(mut members) = members_of(bytes) else {
            let mut bytes = bytes.to_vec();
            self.change(&mut bytes);
            return bytes;
        };
        let at = self.random.gen_range(0..members.len());
        let (name, content) = &mut members[at];
        if name.ends_with(".json") {
            *content = self.change_json(content);
        } else if self.random.gen_bool(0.3) {
            *content = self.change_words(content); // the shape in an array's header
        } else {
            self.change(content);
        }
        if self.random.gen_bool(0.03) {
            members.remove(at);
        }
        let deflate = self.random.gen_bool(0.2);
        pack(&members, deflate)
    }

    /// Changes a chunk of a PNG; its length and checksum are right.
    fn change_png(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut chunks = chunks_of(bytes);
        if chunks.is_empty() {
            return bytes.to_vec();
        }
        let at = self.random.gen_range(0..chunks.len());
        let (kind, content) = &mut chunks[at];
        if kind == b"IDAT" && self.random.gen_bool(0.5) {
            let mut pixels = Vec::new();
            let _ = flate2::read::ZlibDecoder::new(&content[..]).read_to_end(&mut pixels);
            self.change(&mut pixels);
            let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
            packed.write_all(&pixels).unwrap();
            *content = packed.finish().unwrap();
        } else {
            self.change(content);
        }
        let mut png = bytes[..8].to_vec();
        for (kind, content) in &chunks {
            let mut crc = flate2::Crc::new();
            crc.update(kind);
            crc.update(content);
            png.extend((content.len() as u32).to_be_bytes());
            png.extend(kind);
            png.extend(content);
            png.extend(crc.sum().to_be_bytes());
        }
        png
    }

    /// Changes the text inside a gzip file.
    fn change_packed(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut text = Vec::new();
        let _ = flate2::read::GzDecoder::new(bytes).read_to_end(&mut text);
        let text = self.change_words(&text);
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), Default::default());
        packed.write_all(&text).unwrap();
        packed.finish().unwrap()
    }

    /// Changes the description of a binary glTF file; its lengths are right.
    fn change_glb(&mut self, bytes: &[u8]) -> Vec<u8> {
        let length = |at: usize| {
            let four = bytes.get(at..at + 4)?;
            Some(u32::from_le_bytes(four.try_into().ok()?) as usize)
        };
        let Some((text, rest)) =
            length(12).and_then(|text| Some((bytes.get(20..20 + text)?, bytes.get(20 + text..)?)))
        else {
            return bytes.to_vec();
        };
        let mut text = self.change_json(text);
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((20 + text.len() as u32 + rest.len() as u32).to_le_bytes());
        glb.extend((text.len() as u32).to_le_bytes());
        glb.extend(b"JSON");
        glb.extend(text);
        glb.extend(rest);
        glb
    }
}

/// Where the numbers of a text are.
fn numbers_in(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let in_number = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-');
    let mut found = Vec::new();
    let mut start = None;
    for (at, &byte) in text.iter().chain(b" ").enumerate() {
        match (in_number(byte), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                found.push(from..at);
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn members_of(bytes: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let mut members = Vec::new();
    for at in 0..archive.len() {
        let mut member = archive.by_index(at).ok()?;
        let mut content = Vec::new();
        member
            .by_ref()
            .take(1 << 20)
            .read_to_end(&mut content)
            .ok()?;
        let name = member.name().ok()?.into_owned();
        members.push((name, content));
    }
    (!members.is_empty()).then_some(members)
}

fn pack(members: &[(String, Vec<u8>)], deflate: bool) -> Vec<u8> {
    let method = match deflate {
        true => CompressionMethod::Deflated,
        false => CompressionMethod::Stored,
    };
    let options = SimpleFileOptions::default().compression_method(method);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in members {
        zip.start_file(name.as_str(), options).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn chunks_of(png: &[u8]) -> Vec<([u8; 4], Vec<u8>)> {
    let mut chunks = Vec::new();
    let mut at = 8;
    while let Some(head) = png.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(content) = at
            .checked_add(8 + length)
            .and_then(|end| png.get(at + 8..end))
        else {
            break;
        };
        chunks.push(([head[4], head[5], head[6], head[7]], content.to_vec()));
        at += 12 + length;
    }
    chunks
}

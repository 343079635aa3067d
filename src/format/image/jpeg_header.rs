//! The header of a JPEG file: what its segments say before the pixels begin.

/// What the segments up to the first scan say.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct JpegHeader {
    /// Components of a pixel: 1 grey, 3 colour, 4 CMYK.
    pub(super) components: u8,
    /// Bits per number.
    pub(super) precision: u8,
    /// "baseline", "progressive" …
    pub(super) process: &'static str,
    /// The colour transform of Adobe's segment, where there is one.
    pub(super) adobe: Option<u8>,
    /// Pixels per length, across and down.
    pub(super) density: Option<[u16; 2]>,
    /// Whether the mark of the image's end follows the first scan. Without it the file is cut off.
    pub(super) is_whole: bool,
}

impl JpegHeader {
    /// Reads the segments; what is not there, or cut off, is left out.
    pub(super) fn of(bytes: &[u8]) -> Self {
        let mut header = Self::default();
        let mut at = 2;
        while let Some([0xff, marker, high, low]) = bytes.get(at..at + 4) {
            if *marker == 0xff {
                at += 1;
                continue;
            }
            let length = usize::from(*high) << 8 | usize::from(*low);
            let body = bytes
                .get(at + 4..at + 2 + length.max(2))
                .unwrap_or_default();
            match marker {
                0xda | 0xd9 => break,
                0xc4 | 0xc8 | 0xcc => {}
                0xc0..=0xcf => header.frame(*marker, body),
                0xe0 => header.density(body),
                0xee if body.starts_with(b"Adobe") => header.adobe = body.get(11).copied(),
                _ => {}
            }
            at += 2 + length.max(2);
        }
        // Inside a scan 0xff is followed by 0 or by the number of a restart.
        let scans = bytes.get(at..).unwrap_or_default();
        header.is_whole = scans.windows(2).any(|pair| pair == [0xff, 0xd9]);
        header
    }

    fn frame(&mut self, marker: u8, body: &[u8]) {
        self.process = match marker {
            0xc0 => "baseline",
            0xc1 => "extended",
            0xc2 => "progressive",
            0xc3 => "lossless",
            0xc9..=0xcb | 0xcd..=0xcf => "arithmetic",
            _ => "hierarchical",
        };
        self.precision = body.first().copied().unwrap_or(0);
        self.components = body.get(5).copied().unwrap_or(0);
    }

    fn density(&mut self, body: &[u8]) {
        if let (true, Some(&[a, b, c, d])) = (
            body.starts_with(b"JFIF\0"),
            body.get(8..12).and_then(|b| b.first_chunk::<4>()),
        ) {
            self.density = Some([u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d])]);
        }
    }

    /// The name of the colour model of four components.
    pub(super) fn four_components(&self) -> &'static str {
        match self.adobe {
            Some(2) => "YCCK",
            _ => "CMYK",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_read_and_cut_ones_do_no_harm() {
        let mut bytes = b"\xff\xd8\xff\xe0\0\x10JFIF\0\x01\x02\x01\0\x48\0\x90\0\0".to_vec();
        bytes.extend(b"\xff\xee\0\x0eAdobe\0\x64\0\0\0\0\x02");
        bytes.extend(b"\xff\xc2\0\x14\x08\0\x01\0\x01\x04\x01\x11\0\x02\x11\0\x03\x11\0\x04\x11\0");
        let header = JpegHeader::of(&bytes);
        assert_eq!((header.components, header.precision), (4, 8));
        assert_eq!(
            (header.process, header.four_components()),
            ("progressive", "YCCK")
        );
        assert_eq!(header.density, Some([72, 144]));
        assert!(!header.is_whole);
        let scan = b"\xff\xda\0\x02\x12\xff\0\x34\xff\xd9";
        assert!(JpegHeader::of(&[&bytes[..], scan].concat()).is_whole);
        for length in 0..bytes.len() {
            JpegHeader::of(&bytes[..length]);
        }
    }
}

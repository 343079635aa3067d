//! Where the members of a zip archive go: a file until a write fails, then nowhere.
//!
//! A `ZipWriter` that is dropped closes its archive, and prints on stderr when it cannot. The first
//! failure is handed on to the caller, who reports it; what the writer does afterwards has no effect and
//! succeeds.

use std::io::{self, Seek, SeekFrom, Write};

/// A sink that fails once.
#[derive(Debug)]
pub struct ZipSink<W> {
    sink: W,
    /// Where the next byte would go.
    position: u64,
    failed: bool,
}

impl<W: Write + Seek> ZipSink<W> {
    /// Writes to `sink`, which is at its beginning.
    pub fn new(sink: W) -> Self {
        Self {
            sink,
            position: 0,
            failed: false,
        }
    }

    /// Does some work with the sink; `otherwise` stands for its result after a failure.
    fn attempt<T>(
        &mut self,
        work: impl FnOnce(&mut W) -> io::Result<T>,
        otherwise: T,
    ) -> io::Result<T> {
        if self.failed {
            return Ok(otherwise);
        }
        let done = work(&mut self.sink);
        self.failed = done.is_err();
        done
    }
}

impl<W: Write + Seek> Write for ZipSink<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.attempt(|sink| sink.write(bytes), bytes.len())?;
        self.position += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.attempt(Write::flush, ())
    }
}

impl<W: Write + Seek> Seek for ZipSink<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let supposed = match to {
            SeekFrom::Start(position) => position,
            SeekFrom::Current(step) | SeekFrom::End(step) => {
                self.position.saturating_add_signed(step)
            }
        };
        self.position = self.attempt(|sink| sink.seek(to), supposed)?;
        Ok(self.position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    /// Room for this many bytes.
    struct Small(Cursor<Vec<u8>>, usize);

    impl Write for Small {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0.position() as usize + bytes.len() > self.1 {
                return Err(io::Error::from(io::ErrorKind::StorageFull));
            }
            self.0.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Small {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.0.seek(to)
        }
    }

    fn archive(room: usize) -> io::Result<Vec<u8>> {
        let mut small = Small(Cursor::default(), room);
        let mut zip = ZipWriter::new(ZipSink::new(&mut small));
        for name in ["a", "b"] {
            zip.start_file(name, SimpleFileOptions::default())?;
            zip.write_all(&[7; 100])?;
        }
        zip.finish()?;
        Ok(small.0.into_inner())
    }

    #[test]
    fn every_lack_of_room_is_reported_once() {
        let whole = archive(usize::MAX).unwrap();
        for room in 0..whole.len() {
            let error = archive(room).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{room}: {error}");
        }
        assert_eq!(archive(whole.len()).unwrap(), whole);
        let mut sink = ZipSink::new(Small(Cursor::default(), 4));
        assert!(sink.write_all(&[0; 5]).is_err());
        assert_eq!(sink.write(&[0; 5]).unwrap(), 5);
        assert_eq!(sink.stream_position().unwrap(), 5);
        assert!(sink.flush().is_ok());
    }
}

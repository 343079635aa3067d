//! What the machine has and what this process took of it.

use std::fs;

use crate::texton::options::ByteSize;

/// A quarter of the machine's memory; `None` where the system does not say.
pub fn quarter_of_memory() -> Option<ByteSize> {
    field("/proc/meminfo", "MemTotal:").map(|bytes| ByteSize(bytes / 4))
}

/// The most memory this process ever held; `None` where the system does not say.
pub fn peak_memory() -> Option<ByteSize> {
    field("/proc/self/status", "VmHWM:").map(ByteSize)
}

/// Bytes of a line `NAME N kB`.
fn field(path: &str, name: &str) -> Option<u64> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

//! What the machine has and what this process took of it.

use std::fs;
use std::path::Path;

use crate::byte_size::ByteSize;
use crate::error::{Error, Result};

/// Where Linux shows the control groups, which limit containers and services.
const GROUPS: &str = "/sys/fs/cgroup";

/// Memory that some work is expected to take, and what lowers it.
pub struct Need {
    /// Bytes at the peak.
    pub bytes: u64,
    /// What takes it, as in "*frames of 16384x16384* need about 40 GiB".
    pub work: String,
    /// The option that lowers it most.
    pub option: &'static str,
    /// What to ask for instead.
    pub advice: String,
}

impl Need {
    /// Refuses work for which the machine has too little memory, where the system says what it has.
    pub fn check(&self) -> Result<()> {
        self.check_against(available_memory())
    }

    fn check_against(&self, available: Option<ByteSize>) -> Result<()> {
        match available {
            Some(available) if self.bytes > available.0 => Err(Error::option(
                self.option,
                format!("{} need about {}", self.work, ByteSize(self.bytes)),
                format!("at most {available}, which is free now: {}", self.advice),
            )),
            _ => Ok(()),
        }
    }
}

/// A quarter of the machine's memory, or of what its control group may take, in whole MiB; `None` where the
/// system does not say.
pub fn quarter_of_memory() -> Option<ByteSize> {
    let total = field("/proc/meminfo", "MemTotal:")?;
    let limit = groups().filter_map(|group| group.limit).min();
    let mebibytes = total.min(limit.unwrap_or(u64::MAX)) / (4 << 20);
    Some(ByteSize(mebibytes << 20))
}

/// Memory that can be taken without swapping, or less where a control group allows less; `None` where
/// the system does not say.
pub fn available_memory() -> Option<ByteSize> {
    let free = field("/proc/meminfo", "MemAvailable:")?;
    let left = groups().filter_map(|group| group.left()).min();
    Some(ByteSize(free.min(left.unwrap_or(u64::MAX))))
}

/// The most memory this process ever held; `None` if the system does not state it.
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

/// The memory of a control group.
struct Group {
    limit: Option<u64>,
    used: Option<u64>,
    /// Pages of files, which the system takes back.
    cached: u64,
}

impl Group {
    /// Of either version, whose files have other names; `None` in a folder that is no group.
    fn read(folder: &Path) -> Option<Self> {
        let number = |names: [&str; 2]| -> Option<u64> {
            let text = names
                .iter()
                .find_map(|name| fs::read_to_string(folder.join(name)).ok())?;
            text.trim().parse().ok()
        };
        let statistics = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
        let cached = statistics.lines().find_map(|line| {
            let (name, bytes) = line.split_once(' ')?;
            let is_cache = matches!(name, "file" | "total_cache");
            is_cache.then(|| bytes.trim().parse().ok())?
        });
        folder.is_dir().then(|| Self {
            limit: number(["memory.max", "memory.limit_in_bytes"]),
            used: number(["memory.current", "memory.usage_in_bytes"]),
            cached: cached.unwrap_or(0),
        })
    }

    fn left(&self) -> Option<u64> {
        let used = self.used.unwrap_or(0).saturating_sub(self.cached);
        Some(self.limit?.saturating_sub(used))
    }
}

/// The control groups that this process lies in.
fn groups() -> impl Iterator<Item = Group> {
    let told = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    groups_below(Path::new(GROUPS), &told).into_iter()
}

/// The groups that `/proc/self/cgroup` tells of, with all above them, as they lie below `root`.
fn groups_below(root: &Path, told: &str) -> Vec<Group> {
    let mut found = Vec::new();
    for line in told.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(kinds), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let top = match kinds {
            "" => root.to_path_buf(),
            _ if kinds.split(',').any(|kind| kind == "memory") => root.join("memory"),
            _ => continue,
        };
        let own = top.join(path.trim_start_matches('/'));
        let above = own
            .ancestors()
            .take_while(|folder| folder.starts_with(&top));
        found.extend(above.filter_map(Group::read));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_narrowest_group_counts_less_what_it_holds() {
        let root = tempfile::tempdir().unwrap();
        let inner = root.path().join("service/job");
        fs::create_dir_all(&inner).unwrap();
        let write = |folder: &Path, name: &str, text: &str| {
            fs::write(folder.join(name), text).unwrap();
        };
        write(&inner, "memory.max", "max\n");
        write(&inner, "memory.current", "900\n");
        let outer = root.path().join("service");
        write(&outer, "memory.max", "5000\n");
        write(&outer, "memory.current", "3000\n");
        write(&outer, "memory.stat", "anon 1000\nfile 2000\n");
        let left = |told: &str| {
            let groups = groups_below(root.path(), told);
            groups.iter().filter_map(Group::left).min()
        };
        assert_eq!(left("0::/service/job\n"), Some(4000));
        assert_eq!(left("0::/elsewhere\n"), None);
        let old = root.path().join("memory/box");
        fs::create_dir_all(&old).unwrap();
        write(&old, "memory.limit_in_bytes", "700\n");
        write(&old, "memory.usage_in_bytes", "100\n");
        assert_eq!(left("4:cpu,memory:/box\n3:cpu:/service\n"), Some(600));
    }

    #[test]
    fn work_that_does_not_fit_is_refused_with_what_lowers_it() {
        let need = Need {
            bytes: 5 << 30,
            work: "frames of 9x9".into(),
            option: "size",
            advice: "a smaller --size".into(),
        };
        assert!(need.check_against(None).is_ok());
        assert!(need.check_against(Some(ByteSize(5 << 30))).is_ok());
        let error = need.check_against(Some(ByteSize(1 << 30))).unwrap_err();
        assert_eq!(
            error.to_string(),
            "--size: frames of 9x9 need about 5.00 GiB; expected at most 1.00 GiB, which is free now: a \
             smaller --size"
        );
    }
}

//! One of several runs that share some work, `i/n`, and whether the parts they made are complete.
//!
//! In: the words of a command line, or the shards of parts. Out: which units of the work a run takes, and the
//! parts in order. Nothing here knows what the units are.

use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Missing shards that an error lists by number.
const LISTED: usize = 8;

/// One of several runs that share some work: run `index` of `count`, written `index/count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    /// Which of the runs, from 0.
    pub index: u32,
    /// How many runs.
    pub count: u32,
}

impl Shard {
    /// Whether the unit at `place` is this run's, where runs take every `count`-th unit.
    pub fn takes(self, place: usize) -> bool {
        place % self.count as usize == self.index as usize
    }

    /// The units that are this run's, where runs take a contiguous range of `units` each.
    pub fn range(self, units: usize) -> Range<usize> {
        let start = |index: u32| {
            let product = u128::from(index) * units as u128;
            (product / u128::from(self.count)) as usize
        };
        start(self.index)..start(self.index + 1)
    }

    /// Refuses more runs than there are units; `what` says what the units are.
    pub fn check(self, units: usize, what: &str) -> Result<()> {
        if self.count as usize <= units {
            return Ok(());
        }
        Err(Error::option(
            "shard",
            format!("{self}, of {units} {what}"),
            format!("at most {units} shards"),
        ))
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((index, count)) if index < count => Ok(Self { index, count }),
            _ => Err(format!(
                "`{text}` is not a shard i/n with 0 <= i < n, as 0/3"
            )),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

/// The places of parts in the order of their shards. Refuses parts of another number of shards than the first,
/// two parts of one shard, and shards without a part.
pub fn in_order(parts: &[(&Path, Shard)]) -> Result<Vec<usize>> {
    let Some(&(first, Shard { count, .. })) = parts.first() else {
        return Err(Error::option("reduce", "no part", "all parts"));
    };
    let name = |path: &Path| path.display().to_string();
    let others = parts.iter().filter(|(_, shard)| shard.count != count);
    let others: Vec<String> = others
        .map(|(path, shard)| format!("{} is shard {shard}", name(path)))
        .collect();
    if !others.is_empty() {
        let expected = format!("parts of {count} shards, as {}", name(first));
        return Err(Error::option("reduce", others.join(", "), expected));
    }
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&at| parts[at].1);
    let doubled = order.windows(2).filter_map(|pair| {
        let [(one, shard), (other, same)] = [parts[pair[0]], parts[pair[1]]];
        (shard == same).then(|| format!("{} and {} are shard {shard}", name(one), name(other)))
    });
    let doubled: Vec<String> = doubled.collect();
    if !doubled.is_empty() {
        return Err(Error::option(
            "reduce",
            doubled.join(", "),
            "each shard once",
        ));
    }
    match parts.len() == count as usize {
        true => Ok(order),
        false => Err(missing(parts, count)),
    }
}

fn missing(parts: &[(&Path, Shard)], count: u32) -> Error {
    let is_missing = |index: &u32| parts.iter().all(|(_, shard)| shard.index != *index);
    let listed = (0..count).filter(is_missing).take(LISTED);
    let mut listed: Vec<String> = listed
        .map(|index| Shard { index, count }.to_string())
        .collect();
    let left = count as usize - parts.len();
    if left > listed.len() {
        listed.push(format!("{} more", left - listed.len()));
    }
    let found = format!("no part of shard {}", listed.join(", "));
    Error::option("reduce", found, format!("the parts of all {count} shards"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shards(texts: &[&str]) -> Vec<Shard> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn shards_share_all_units() {
        for shard in shards(&["0/1", "0/3", "6/7"]) {
            assert_eq!(shard.to_string().parse(), Ok(shard));
        }
        let three = shards(&["0/3", "1/3", "2/3"]);
        for place in 0..10 {
            assert_eq!(three.iter().filter(|shard| shard.takes(place)).count(), 1);
        }
        let ranges: Vec<_> = three.iter().map(|shard| shard.range(10)).collect();
        assert_eq!(ranges, [0..3, 3..6, 6..10]);
        for text in ["3/3", "x", "1", "0/0", "-1/2"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert!(three[0].check(3, "views").is_ok());
        let error = three[0].check(2, "views").unwrap_err().to_string();
        assert_eq!(error, "--shard: 0/3, of 2 views; expected at most 2 shards");
        let last = Shard {
            index: u32::MAX - 1,
            count: u32::MAX,
        };
        assert_eq!(last.range(usize::MAX).end, usize::MAX);
    }

    fn ordered(texts: &[&str]) -> std::result::Result<Vec<usize>, String> {
        let names: Vec<String> = (0..texts.len()).map(|at| format!("p{at}")).collect();
        let parts = names.iter().map(Path::new).zip(shards(texts));
        in_order(&parts.collect::<Vec<_>>()).map_err(|error| error.to_string())
    }

    #[test]
    fn parts_are_put_in_order_or_refused_by_name() {
        assert_eq!(ordered(&["1/3", "2/3", "0/3"]), Ok(vec![2, 0, 1]));
        for (parts, says) in [
            (&["0/3", "1/3"][..], "no part of shard 2/3"),
            (&["0/2", "0/2", "1/2"], "p0 and p1 are shard 0/2"),
            (
                &["0/2", "1/2", "2/3"],
                "p2 is shard 2/3; expected parts of 2 shards, as p0",
            ),
            (
                &["0/4000000000"],
                "7/4000000000, 8/4000000000, 3999999991 more",
            ),
            (&[], "no part"),
        ] {
            let error = ordered(parts).unwrap_err();
            assert!(error.contains(says), "{error}");
        }
    }
}

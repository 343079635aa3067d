//! What a method asks of a space: a channel of some kind, or a control. Out: it, or an error that says how to
//! make a space that has it.

use ndarray::{ArrayView3, s};

use crate::error::{Error, Result};
use crate::exemplar::channels::{Channel, ChannelKind};
use crate::exemplar::controls::{ControlKind, Controls};
use crate::exemplar::space::{Features, Space};

impl Space {
    /// The first channel of a kind.
    pub fn channel(&self, kind: ChannelKind) -> Option<&Channel> {
        self.channels
            .list()
            .iter()
            .find(|channel| channel.kind == kind)
    }

    /// The first channel of a kind, without which `method` cannot work.
    pub fn required_channel(&self, kind: ChannelKind, method: &str) -> Result<&Channel> {
        self.channel(kind).ok_or_else(|| {
            let list = self.channels.list().iter();
            let names: Vec<String> = list.map(|channel| channel.name.clone()).collect();
            let found = match names.is_empty() {
                true => "none are stated".into(),
                false => names.join(", "),
            };
            Error::data("channels", found)
                .expected(format!("one of kind {}, which {method} needs", kind.name()))
                .advice(format!(
                    "make the space with `mesotex exemplar IMAGE… --kinds …,{}`",
                    kind.name()
                ))
        })
    }

    /// The numbers of a channel at a level as the file stores them, unweighted, [H, W, count]; nothing in
    /// a space of textons.
    pub fn channel_numbers(&self, level: usize, channel: &Channel) -> Option<ArrayView3<'_, f32>> {
        let Features::Plain(features) = &self.levels.get(level)?.features else {
            return None;
        };
        let stored = self.channels.stored(level, features);
        let numbers = channel.numbers();
        (numbers.end <= stored.dim().2).then(|| stored.slice(s![.., .., numbers]))
    }
}

impl Space {
    /// The controls of a level, among which is `kind`; without it `method` cannot work.
    pub fn required_control(
        &self,
        level: usize,
        kind: ControlKind,
        method: &str,
    ) -> Result<&Controls> {
        let controls = self
            .controls
            .get(level)
            .filter(|controls| controls.has(kind));
        controls.ok_or_else(|| {
            let finest = self.controls.first().into_iter();
            let names: Vec<&str> = finest
                .flat_map(Controls::kinds)
                .map(ControlKind::name)
                .collect();
            let found = match names.is_empty() {
                true => "none".into(),
                false => names.join(", "),
            };
            Error::data("controls", found)
                .expected(format!("{}, which {method} needs", kind.name()))
                .advice(format!(
                    "make the space with `mesotex exemplar … --{} FILE`",
                    kind.option()
                ))
        })
    }
}

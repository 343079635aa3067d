//! The one interface between a method and the engine: how a site is decided, given what the others hold. A paper is a
//! rule and the [drivers](crate::synthesis::drive) that visit the sites with it.

/// How one site is decided.
pub trait Rule: Sync {
    /// What all sites hold; what a rule remembers beside (which are done, how often a texel is used) is part
    /// of it.
    type State: Sync;
    /// What one site takes.
    type Take: Copy + Default + PartialEq + Send + Sync;
    /// Working memory of one thread.
    type Scratch: Default + Send;

    /// What a site holds.
    fn held(&self, state: &Self::State, site: usize) -> Self::Take;

    /// What a site should hold.
    fn choose(&self, state: &Self::State, site: usize, scratch: &mut Self::Scratch) -> Self::Take;

    /// Lets a site hold something.
    fn set(&self, state: &mut Self::State, site: usize, take: Self::Take);

    /// Sites that a thread takes at a time: fewer where each takes long.
    fn batch(&self) -> usize {
        64
    }
}

/// A rule that can tell whether a choice made some visits ago still holds.
pub trait Foreseen: Rule {
    /// Sites that are decided before the first of them is set.
    fn run(&self) -> usize;

    /// Begins a run: what is set from here on is compared with what is read.
    fn begin_run(&self, state: &mut Self::State);

    /// Whether a site would still take what it took when the run began. `false` where that is not certain.
    fn stands(&self, state: &Self::State, site: usize, take: Self::Take) -> bool;
}

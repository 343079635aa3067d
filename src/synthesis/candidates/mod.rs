//! Which texels are tried at a site: those that its neighbours propose by forward shift.

pub(crate) mod forward;
mod proposals;

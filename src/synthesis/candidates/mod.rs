//! Which texels are tried at a site: those that its neighbours propose by forward shift.

pub mod forward;
pub mod proposals;

//! Where edges wait for their collapse.

pub(crate) mod queue;
pub(crate) mod rounds;

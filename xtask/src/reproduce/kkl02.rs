//! Kim, Kim, Levin 2002.

use super::Step;

pub(super) const STEPS: [Step; 0] = [];

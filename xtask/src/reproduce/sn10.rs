//! Szilvási-Nagy 2010.

use super::Step;

pub(super) const STEPS: [Step; 0] = [];

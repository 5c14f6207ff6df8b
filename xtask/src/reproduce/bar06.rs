//! Brink, Alboul, Rodrigues 2006.

use super::Step;

pub(super) const STEPS: [Step; 0] = [];

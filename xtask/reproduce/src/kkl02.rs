//! Kim, Kim, Levin 2002: simplification by a discrete curvature norm.

mod distances;
mod error_curves;
mod guards;
mod head;
mod norm_levels;
mod readings;
mod rotorcraft;
mod runs;
mod similarity;
mod single_metrics;
mod thin_parts;
mod visual;

use super::step::Step;

pub(super) const STEPS: [Step; 7] = [
    Step { name: "Fig. 4", data: &[], compute: norm_levels::compute },
    Step { name: "Sec. 4.2", data: &[], compute: single_metrics::compute },
    Step { name: "Sec. 4.2, as published and guarded", data: &[], compute: guards::compute },
    Step { name: "Sec. 2.1, 4.2 and 5, other readings", data: &[], compute: readings::compute },
    Step { name: "Fig. 5 and 7 (a)", data: &[], compute: thin_parts::compute },
    Step { name: "Fig. 6", data: &[], compute: visual::compute },
    Step { name: "Fig. 7 (b)", data: &[], compute: error_curves::compute },
];

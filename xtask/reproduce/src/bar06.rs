//! Brink, Alboul, Rodrigues 2006: edge flips by a virtual Willmore energy.

mod cube;
mod energy;
mod face;
pub(super) mod face_shape;
mod measures;
mod rules;
mod torus;
mod virtual_point;

use super::step::Step;

pub(super) const STEPS: [Step; 5] = [
    Step { name: "Sec. 2 and 3", data: &[], compute: energy::compute },
    Step { name: "Fig. 4", data: &["cube"], compute: cube::compute },
    Step { name: "Fig. 5", data: &["torus"], compute: torus::compute },
    Step { name: "Fig. 6", data: &[], compute: face::compute },
    Step { name: "Sec. 5, virtual points", data: &[], compute: virtual_point::compute },
];

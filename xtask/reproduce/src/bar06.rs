//! Brink, Alboul, Rodrigues 2006: edge flips by a virtual Willmore energy.

mod cube;
mod energy;
mod face;
pub(super) mod face_shape;
mod measures;
mod rules;
mod torus;

use super::step::Step;

pub(super) const STEPS: [Step; 4] = [
    Step { name: "Sec. 2 and 3", compute: energy::compute },
    Step { name: "Fig. 4", compute: cube::compute },
    Step { name: "Fig. 5", compute: torus::compute },
    Step { name: "Fig. 6", compute: face::compute },
];

//! Fits in which the farthest pairs count most, round the peaks alone.

use mesh_core::{Handle, TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError};

use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::{FitOptions, fit};
use crate::finish::peaks::points::{Most, Peaks};

/// A step that lowers the largest distance by less than this ratio is not worth another.
const ENOUGH: f64 = 0.999;

/// The parts of a step that are tried, one after the other.
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.12];

/// What counts as a peak there, relative to the largest distance.
const FLATTENED: f64 = 0.85;

impl Peaks<'_> {
    /// Moves the vertices round the peaks so that these become lower, as long as that works.
    pub(super) fn flatten(
        &mut self,
        mesh: &mut TriMesh,
        original: &Surface,
        constraints: &FitConstraints,
        options: &FitOptions,
        most: Most,
    ) -> Result<(), SurfaceError> {
        for round in 0..options.rounds {
            let local = self.all_but_peaks_fixed(mesh, constraints, FLATTENED * self.largest);
            let seed = options.seed.wrapping_add(round as u64);
            let once = FitOptions { rounds: 1, flips: false, seed, ..*options };
            let mut moved = mesh.clone();
            fit(&mut moved, original, &local, &once)?;
            let mut better = None;
            // A part of a step without intersections may have some.
            let parts = if once.forbid_intersections { &STEPS[..1] } else { &STEPS[..] };
            for &part in parts {
                let mut next = moved.clone();
                for (to, from) in next.positions_mut().iter_mut().zip(mesh.positions()) {
                    *to = *from + part * (*to - *from);
                }
                let found = Peaks::new(&next, original, self.points)?;
                if found.largest < ENOUGH * self.largest && found.mean <= most.mean {
                    better = Some((next, found));
                    break;
                }
            }
            let Some((next, found)) = better else { break };
            (*mesh, *self) = (next, found);
        }
        Ok(())
    }

    /// The constraints, with all vertices fixed that are not next to a face with a peak.
    fn all_but_peaks_fixed(
        &self,
        mesh: &TriMesh,
        constraints: &FitConstraints,
        bar: f64,
    ) -> FitConstraints {
        let topology = mesh.topology();
        let forward = self.forward.iter().map(|closest| (closest.face, closest.distance));
        let far = forward.chain(self.inner.iter().copied()).filter(|&(_, distance)| distance > bar);
        let corners = far.flat_map(|(face, _)| topology.face_vertices(face));
        let far = self.backward.iter().enumerate().filter(|(_, closest)| closest.distance > bar);
        let own = far.map(|(index, _)| VertexId::from_index(index));
        let mut fixed = topology.vertex_map(true);
        for v in corners.chain(own) {
            fixed[v] = false;
            topology.one_ring(v).for_each(|w| fixed[w] = false);
        }
        let before = constraints.fixed.iter().flat_map(VertexMap::iter);
        before.filter(|(_, was)| **was).for_each(|(v, _)| fixed[v] = true);
        FitConstraints { fixed: Some(fixed), ..constraints.clone() }
    }
}

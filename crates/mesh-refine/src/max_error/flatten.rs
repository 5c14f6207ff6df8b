//! Fits around the largest errors in which the farthest pairs have the largest weights.

use glam::DVec3;
use mesh_collapse::{FaceLimits, Phase};
use mesh_core::{FaceId, TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, closest_on_triangle};

use crate::error::RefineError;
use crate::face_quality::{keeps_height, keeps_side};
use crate::fit::constraints::FitConstraints;
use crate::fit::moves::cross;
use crate::fit::spread::{Spot, Spread, area};
use crate::fit::{FitOptions, FitTarget, LocalFit, share_of_one};
use crate::max_error::distance_update::Became;
use crate::max_error::points::{Heights, Most, Peaks};
use crate::observer::Observer;

/// A step must lower the largest distance at least by this factor; otherwise there is no further step.
const ENOUGH: f64 = 0.999;

/// The fractions of a step that are tried, in this order.
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.12];

/// The distance at which a peak starts, relative to the largest distance.
const FLATTENED: f64 = 0.85;

/// Whether no face turns too far or becomes a sliver between two meshes with the same connectivity, and the limits hold.
fn keeps_faces(before: &TriMesh, after: &TriMesh, limits: &FaceLimits) -> bool {
    before.topology().faces().all(|face| {
        let (old, new) = (before.triangle(face), after.triangle(face));
        let keeps_edge = |i: usize, j: usize| {
            [old[i], old[j]] == [new[i], new[j]] || limits.allows_edge(new[i], new[j])
        };
        old == new
            || (keeps_side(cross(new), cross(old))
                && keeps_height([new], [old])
                && limits.allows_angles(new)
                && [(0, 1), (1, 2), (2, 0)].into_iter().all(|(i, j)| keeps_edge(i, j)))
    })
}

impl Peaks<'_> {
    /// Moves the vertices around the largest errors to lower them, as long as that works.
    pub(super) fn flatten(
        &mut self,
        mesh: &mut TriMesh,
        original: &Surface,
        constraints: &FitConstraints,
        options: &FitOptions,
        most: Most,
        observer: &mut Observer<'_>,
    ) -> Result<(), RefineError> {
        if options.rounds == 0 {
            return Ok(());
        }
        let fit = LocalFit::new(mesh, original, constraints);
        for round in 0..options.rounds {
            if observer.stops(Phase::MaxError, mesh) {
                break;
            }
            let local = self.all_but_peaks_fixed(mesh, constraints);
            let seed = options.seed.wrapping_add(round as u64);
            let once = FitOptions { seed, ..*options };
            let mut moved = mesh.clone();
            let surface = Surface::new(mesh)?;
            let pulled = self.pulled(mesh, (original, &surface), &local, &once);
            fit.step(
                &mut moved,
                &local,
                &once,
                (surface.in_space(), self.heights.largest),
                |face, act| {
                    let start = pulled.partition_point(|(on, _)| *on < face);
                    let of_face = pulled[start..].iter().take_while(|(on, _)| *on == face);
                    of_face.for_each(|(_, target)| act(target));
                },
            );
            // Frees memory for the measurement of distances.
            drop((surface, pulled));
            let moved = moved.positions().to_vec();
            let mut better = None;
            // A fraction of a step without intersections may cause intersections.
            let parts = if once.forbid_intersections { &STEPS[..1] } else { &STEPS[..] };
            for &part in parts {
                let mut next = mesh.clone();
                for (at, to) in next.positions_mut().iter_mut().zip(&moved) {
                    *at += part * (*to - *at);
                }
                if part < 1.0 && !keeps_faces(mesh, &next, &constraints.limits) {
                    continue;
                }
                let bar = ENOUGH * self.heights.largest;
                let change = self.after(mesh, &next, original, Became::Same, bar)?;
                if let Some(change) = change.filter(|c| is_worth_it(c.heights, self.heights, most))
                {
                    better = Some((next, change));
                    break;
                }
            }
            let Some((next, change)) = better else { break };
            *mesh = next;
            self.take_up(change);
        }
        Ok(())
    }

    /// The targets of the faces with a moving corner, sorted by face: new samples of the original, and points of the
    /// original that are more than half as far as the farthest.
    fn pulled(
        &self,
        mesh: &TriMesh,
        (original, surface): (&Surface, &Surface),
        constraints: &FitConstraints,
        options: &FitOptions,
    ) -> Vec<(FaceId, FitTarget)> {
        let topology = mesh.topology();
        let is_free = |v: VertexId| !constraints.is_fixed(topology, v);
        let mut moves = vec![false; topology.face_capacity()];
        for f in topology.faces() {
            moves[f.index()] = topology.face_vertices(f).into_iter().any(is_free);
        }
        // The triangles of the original with a corner that is closest to such a face.
        let mut is_near = vec![false; original.positions().len()];
        for (&vertex, closest) in self.points.vertices.iter().zip(&self.forward) {
            is_near[vertex as usize] = moves[closest.face.index()];
        }
        let order = original.in_space().iter().copied();
        let near = |t: &u32| original.triangles()[*t as usize].iter().any(|&v| is_near[v as usize]);
        let order: Vec<u32> = order.filter(near).collect();
        let corners = |t: u32| original.triangle(t as usize);
        let part = order.iter().map(|&t| area(&corners(t))).sum::<f64>();
        let whole: f64 = topology.faces().map(|f| area(&mesh.triangle(f))).sum();
        let density = options.samples_per_face as f64 * topology.face_count() as f64 / whole;
        let count = (part * density).ceil() as usize;
        let spread = Spread::new(&order, corners, count, options.seed);
        let spots: Vec<Spot> = spread.spots(corners, 0..spread.len()).collect();
        let points: Vec<DVec3> = spots.iter().map(|spot| spot.point).collect();
        let share = share_of_one(options.samples_per_face);
        let mut all: Vec<(FaceId, FitTarget)> = Vec::new();
        for (spot, closest) in spots.iter().zip(surface.closest_to_neighbours(&points)) {
            if moves[closest.face.index()] {
                let on = corners(spot.triangle);
                let target =
                    FitTarget::on_triangle(spot.triangle, on, spot.point, share * spot.share);
                all.push((closest.face, target));
            }
        }
        for (number, closest) in self.forward[..self.points.samples].iter().enumerate() {
            if moves[closest.face.index()] && closest.distance > 0.5 * self.heights.largest {
                let point = self.points.point(number);
                let offset = closest_on_triangle(point, &mesh.triangle(closest.face));
                let normal = offset.normalize_or_zero();
                all.push((closest.face, FitTarget { point, normal, share: 1.0, triangle: None }));
            }
        }
        all.sort_by_key(|(face, _)| *face);
        all
    }

    /// The constraints, with all vertices fixed that do not belong to a face with a peak.
    fn all_but_peaks_fixed(&self, mesh: &TriMesh, constraints: &FitConstraints) -> FitConstraints {
        let bar = FLATTENED * self.heights.largest;
        let topology = mesh.topology();
        let forward = self.forward.iter().map(|closest| (closest.face, closest.distance));
        let centers = topology.faces().map(|f| (f, self.elements.of_face[f.index()]));
        let middles = topology.edges().filter_map(|e| {
            let face = topology.edge_faces(e).into_iter().flatten().next()?;
            Some((face, self.elements.of_edge[e.index()]))
        });
        let far = forward.chain(centers).chain(middles).filter(|&(_, distance)| distance > bar);
        let corners = far.flat_map(|(face, _)| topology.face_vertices(face));
        let own = topology.vertices().filter(|v| self.elements.of_vertex[v.index()] > bar);
        let mut fixed = topology.vertex_map(true);
        // Many far points may belong to the faces of one vertex, and the vertex may have many neighbours.
        let mut is_done = topology.vertex_map(false);
        for v in corners.chain(own) {
            if !core::mem::replace(&mut is_done[v], true) {
                fixed[v] = false;
                topology.one_ring(v).for_each(|w| fixed[w] = false);
            }
        }
        let before = constraints.fixed.iter().flat_map(VertexMap::iter);
        before.filter(|(_, was)| **was).for_each(|(v, _)| fixed[v] = true);
        FitConstraints { fixed: Some(fixed), ..constraints.clone() }
    }
}

/// Whether the largest error has fallen enough, and the mean is not too high.
fn is_worth_it(found: Heights, before: Heights, most: Most) -> bool {
    found.largest < ENOUGH * before.largest && found.mean <= most.mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::max_error::points::Points;
    use mesh_core::Handle;
    use mesh_shapes::Plane;

    fn grid() -> TriMesh {
        let soup = Plane { half_width: 1.0 }.mesh(12, Default::default()).unwrap();
        TriMesh::from_soup(&soup).unwrap()
    }

    #[test]
    fn only_the_vertices_round_peaks_are_free() {
        let mesh = grid();
        let surface = Surface::new(&mesh).unwrap();
        let points = Points::new(&surface, 3.0, 1);
        let mut max_error = Peaks::new(&mesh, &surface, &points).unwrap();
        let faces: Vec<_> = mesh.topology().faces().collect();
        let (low, high) = (faces[100], faces[200]);
        max_error.heights.largest = 2.0;
        max_error.elements.of_face[low.index()] = 2.0 * 0.849;
        max_error.elements.of_face[high.index()] = 2.0 * 0.851;
        let all = FitConstraints::default();
        let fixed = max_error.all_but_peaks_fixed(&mesh, &all).fixed.unwrap();
        let topology = mesh.topology();
        let corners = topology.face_vertices(high);
        for v in topology.vertices() {
            let is_near =
                corners.contains(&v) || topology.one_ring(v).any(|w| corners.contains(&w));
            assert_eq!(fixed[v], !is_near, "{v:?}");
        }
        // Vertices that were fixed before stay fixed.
        let mut given = topology.vertex_map(false);
        given[corners[0]] = true;
        let all = FitConstraints { fixed: Some(given), ..all };
        assert!(max_error.all_but_peaks_fixed(&mesh, &all).fixed.unwrap()[corners[0]]);
        // Vertices of the mesh that are far from the original are peaks as well.
        max_error.elements.of_face.fill(0.0);
        max_error.elements.of_vertex.fill(2.0 * 0.849);
        let peak = VertexId::from_index(80);
        max_error.elements.of_vertex[80] = 2.0 * 0.851;
        let all = FitConstraints::default();
        let fixed = max_error.all_but_peaks_fixed(&mesh, &all).fixed.unwrap();
        assert!(
            topology
                .vertices()
                .all(|v| { fixed[v] != (v == peak || topology.one_ring(v).any(|w| w == peak)) })
        );
    }

    #[test]
    fn steps_that_help_little_are_not_taken() {
        let with = |largest, mean| Heights { largest, mean, rms: 1.0 };
        let (before, most) = (with(2.0, 1.0), Most { mean: 1.0, rms: 1.0 });
        assert!(is_worth_it(with(1.997, 1.0), before, most));
        assert!(!is_worth_it(with(1.9981, 1.0), before, most));
        assert!(!is_worth_it(with(1.0, 1.01), before, most));
    }
}

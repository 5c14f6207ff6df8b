//! Random flips, to start an optimisation from a bad triangulation.

use mesh_core::{EdgeId, Handle, SplitMix64, TriMesh};

/// Trials per flip before [`scramble`] gives up.
const TRIES: usize = 1000;

/// Flips random edges, `flips` times, if the flip is legal and `allowed`. Returns the number of flips: fewer than
/// `flips` if hardly any edge may flip.
pub fn scramble(
    mesh: &mut TriMesh,
    flips: usize,
    random: &mut SplitMix64,
    allowed: impl Fn(&TriMesh, EdgeId) -> bool,
) -> usize {
    let edges = mesh.topology().edge_capacity();
    let tries = if edges == 0 { 0 } else { TRIES.saturating_mul(flips) };
    let mut done = 0;
    for _ in 0..tries {
        if done == flips {
            break;
        }
        let edge = EdgeId::from_index((random.bits() % edges as u64) as usize);
        if !allowed(mesh, edge) {
            continue;
        }
        if let Ok(flip) = mesh.topology().check_flip(edge) {
            mesh.flip(flip);
            done += 1;
        }
    }
    done
}

#[cfg(test)]
mod tests {
    use super::scramble;
    use crate::Sphere;
    use mesh_core::{Repair, SplitMix64, TriMesh, build};

    fn sphere() -> TriMesh {
        build(&Sphere { radius: 1.0 }.icosphere(2).unwrap(), &Repair::strict()).unwrap().mesh
    }

    #[test]
    fn flips_as_often_as_asked_and_keeps_a_mesh() {
        let mut mesh = sphere();
        assert_eq!(scramble(&mut mesh, 100, &mut SplitMix64::new(3), |_, _| true), 100);
        mesh.topology().validate().unwrap();
        let [before, after] = [sphere(), mesh].map(|mesh| mesh.topology().canonical_triangles());
        assert_eq!(before.len(), after.len());
        assert_ne!(before, after);
    }

    #[test]
    fn ends_where_nothing_may_flip() {
        let mut mesh = sphere();
        assert_eq!(scramble(&mut mesh, 5, &mut SplitMix64::new(3), |_, _| false), 0);
        let same = [sphere(), mesh].map(|mesh| mesh.topology().canonical_triangles());
        assert_eq!(same[0], same[1]);
    }
}

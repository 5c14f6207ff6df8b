//! Soups with every combination of repairs.

use arbitrary::{Result, Unstructured};
use mesh_core::{Built, PolygonSoup, Repair, Weld, build, diagnose};

use crate::shape::{assert_sound, soup};

/// Builds a mesh. It must be valid and agree with the report, or the refusal must have a reason.
pub fn attack(data: &[u8]) {
    // Too few bytes are not an error.
    let _ = run(&mut Unstructured::new(data));
}

fn run(u: &mut Unstructured<'_>) -> Result<()> {
    let repair = repair(u)?;
    let soup = soup(u, 40)?;
    let found = diagnose(&soup).expect("it is small");
    assert_eq!(found.vertices, soup.vertex_count());
    let lenient = build(&soup, &Repair::lenient()).expect("repairs cure everything here");
    check(&soup, &lenient);
    let built = build(&soup, &repair);
    let again = build(&soup, &repair);
    match (built, again) {
        (Ok(built), Ok(again)) => {
            check(&soup, &built);
            assert_eq!(built.report, again.report, "the same soup, another mesh");
            assert_eq!(built.provenance, again.provenance, "the same soup, another mesh");
        }
        (Err(error), Err(again)) => assert_eq!(error.to_string(), again.to_string()),
        _ => panic!("the same soup, once a mesh and once none"),
    }
    Ok(())
}

fn repair(u: &mut Unstructured<'_>) -> Result<Repair> {
    let mut repair = Repair::strict();
    repair.weld = match u.int_in_range(0..=5)? {
        0 => Weld::Exact,
        1 => Weld::Distance(f64::from(u.int_in_range(0..=30)?) / 10.0),
        2 => Weld::Distance(*u.choose(&[1e-300, 1e300, f64::NAN, f64::INFINITY, -1.0])?),
        _ => Weld::None,
    };
    let flags: u8 = u.arbitrary()?;
    repair.drop_out_of_range = flags & 1 != 0;
    repair.drop_degenerate = flags & 2 != 0;
    repair.drop_duplicates = flags & 4 != 0;
    repair.reorient = flags & 8 != 0;
    repair.cut_non_manifold = flags & 16 != 0;
    repair.drop_unreferenced = flags & 32 != 0;
    repair.drop_not_finite = flags & 64 != 0;
    Ok(repair)
}

fn check(soup: &PolygonSoup, built: &Built) {
    let Built { mesh, report, provenance } = built;
    assert_sound(mesh);
    let topology = mesh.topology();
    assert_eq!(
        [report.vertices_out, report.faces_out],
        [topology.vertex_count(), topology.face_count()]
    );
    assert_eq!(provenance.vertex_source.len(), topology.vertex_count());
    assert_eq!(provenance.face_source.len(), topology.face_count());
    assert_eq!(provenance.corner_source.len(), topology.face_count());
    for (vertex, &source) in topology.vertices().zip(&provenance.vertex_source) {
        assert_eq!(mesh.position(vertex), soup.positions()[source as usize]);
    }
    for (&face, corners) in provenance.face_source.iter().zip(&provenance.corner_source) {
        let range = soup.corner_range(face as usize);
        assert!(corners.iter().all(|&corner| range.contains(&(corner as usize))));
    }
    // A built mesh needs no more repair.
    let triangles: Vec<[u32; 3]> = topology.triangles().collect();
    let whole = PolygonSoup::from_triangles(mesh.positions(), &triangles).expect("it is small");
    let found = diagnose(&whole).expect("it is small");
    assert!(found.is_manifold() && found.is_oriented(), "{found:?}");
    assert!(build(&whole, &Repair::strict()).expect("it is a mesh").report.is_unchanged());
}

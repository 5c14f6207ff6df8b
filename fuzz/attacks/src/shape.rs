//! Small meshes with vertices at small integer coordinates, made from bytes.

use arbitrary::{Result, Unstructured};
use glam::DVec3;
use mesh_core::{PolygonSoup, Repair, TriMesh, Weld, build};
use mesh_shapes::{Sphere, Torus};

/// The largest absolute coordinate.
const REACH: i32 = 4;

/// A point with integer coordinates.
///
/// # Errors
/// There are not enough bytes.
pub fn point(u: &mut Unstructured<'_>) -> Result<DVec3> {
    let mut coordinate = || u.int_in_range(-REACH..=REACH).map(f64::from);
    Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}

/// Arbitrary polygons: up to `limit` vertices and faces.
///
/// # Errors
/// There are not enough bytes.
pub fn soup(u: &mut Unstructured<'_>, limit: usize) -> Result<PolygonSoup> {
    let mut soup = PolygonSoup::new();
    for _ in 0..u.int_in_range(3..=limit)? {
        soup.push_vertex(point(u)?);
    }
    let vertices = soup.vertex_count() as u32;
    for _ in 0..u.int_in_range(1..=limit)? {
        let corners = u.int_in_range(0..=15)?;
        // Mostly triangles; a few faces with too few corners, or with many.
        let corners = if corners > 8 { 3 } else { corners };
        // The largest index is out of range.
        let face: Result<Vec<u32>> = (0..corners).map(|_| u.int_in_range(0..=vertices)).collect();
        let face = face?;
        let is_whole = !u.ratio(15, 16)? || face.iter().all(|&vertex| vertex < vertices);
        if is_whole {
            // It cannot be too large.
            let _ = soup.push_face(&face);
        }
    }
    Ok(soup)
}

/// A mesh: a patch of a lattice, a sphere or a torus, rounded to integers, with some vertices moved and some faces
/// missing; or a repaired soup.
///
/// # Errors
/// There are not enough bytes.
pub fn mesh(u: &mut Unstructured<'_>) -> Result<TriMesh> {
    let mut soup = match u.int_in_range(0..=5)? {
        0 => soup(u, 20)?,
        1 => rounded(Sphere { radius: 3.0 }.icosphere(1).ok(), 1.0),
        2 => rounded(Torus { major: 3.0, minor: 1.5 }.mesh(8, 4).ok(), 1.0),
        3 => rounded(Sphere { radius: 1.0 }.icosphere(0).ok(), 2.0),
        _ => height_field(u)?,
    };
    for _ in 0..u.int_in_range(0..=6)? {
        let vertex = u.choose_index(soup.vertex_count())?;
        let place = point(u)?;
        soup.positions_mut()[vertex] = place;
    }
    let mut kept = PolygonSoup::new();
    soup.positions().iter().for_each(|&position| kept.push_vertex(position));
    let left_out: Vec<usize> = (0..u.int_in_range(0..=3)?)
        .map(|_| u.choose_index(soup.face_count()))
        .collect::<Result<_>>()?;
    for (number, face) in soup.faces().enumerate() {
        if !left_out.contains(&number) {
            // It cannot be too large.
            let _ = kept.push_face(face);
        }
    }
    let mut repair = Repair::lenient();
    // Keeps coincident vertices and vertices without faces.
    if u.ratio(3, 4)? {
        repair.weld = Weld::None;
    }
    repair.drop_unreferenced = u.ratio(1, 2)?;
    Ok(build(&kept, &repair).expect("repairs cure everything here").mesh)
}

fn rounded(soup: Option<PolygonSoup>, scale: f64) -> PolygonSoup {
    let mut soup = soup.unwrap_or_default();
    soup.positions_mut().iter_mut().for_each(|position| *position = (*position * scale).round());
    soup
}

fn height_field(u: &mut Unstructured<'_>) -> Result<PolygonSoup> {
    let [width, depth] = [u.int_in_range(2..=6)?, u.int_in_range(2..=6)?];
    let mut soup = PolygonSoup::new();
    for y in 0..depth {
        for x in 0..width {
            let height = f64::from(u.int_in_range(-2..=2)?);
            soup.push_vertex([f64::from(x), f64::from(y), height]);
        }
    }
    for y in 0..depth - 1 {
        for x in 0..width - 1 {
            let [a, b] = [x + y * width, x + (y + 1) * width];
            let faces = if u.ratio(1, 2)? {
                [[a, a + 1, b + 1], [a, b + 1, b]]
            } else {
                [[a, a + 1, b], [a + 1, b + 1, b]]
            };
            // They cannot be too large.
            for face in faces {
                let _ = soup.push_face(&face);
            }
        }
    }
    Ok(soup)
}

/// Checks that the mesh is valid and all its positions are finite.
pub fn assert_sound(mesh: &TriMesh) {
    mesh.topology().validate().expect("the mesh keeps its invariants");
    let stray = mesh.topology().vertices().find(|&v| !mesh.position(v).is_finite());
    assert_eq!(stray, None, "a vertex is nowhere");
}

//! Refinement of the result, piece by piece, each against its own part of the original.
//!
//! The faces of the result are divided into pieces by cell. A face of the original belongs to the piece that is closest
//! to its centroid. Each piece is fitted and annealed, and its largest error is reduced, as the options say. The
//! boundary of a piece stays, so that the pieces fit together again. Further rounds refine the faces near vertices that
//! were on a boundary in each round so far, in pieces that are divided in other directions, until few such vertices are
//! left.

use core::ops::Range;
use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use mesh_core::{
    FaceId, FaceMap, Handle, PolygonSoup, Repair, TriMesh, VertexId, VertexMap, as_u32, build,
};
use mesh_metric::Surface;
use simplify::{
    FitConstraints, FitOptions, MaxErrorOptions, Options, SimplifyError, Steps, anneal, fit,
    reduce_max_error, unfold,
};

use crate::cells::Cells;
use crate::error::Error;
use crate::layout::REFINE;
use crate::region::Region;
use crate::renumber::{FirstUse, NONE};
use crate::step::Step;
use crate::work::Work;

/// The number of rings of faces around a boundary between pieces that a further round refines.
const RINGS: usize = 4;

/// Rounds end when fewer than one in this many vertices was on a boundary between pieces in each round. For large
/// pieces this is the case after the second round.
const MOST_STUCK: usize = 100;

/// The rotations of space before it is divided, for rounds after the first: angles about x, then about z, in radians.
const TURNS: [[f64; 2]; 3] = [[0.785, 0.471], [1.3, 1.1], [2.2, 0.8]];

/// The settings and data of a refinement.
pub(crate) struct Refinement<'f> {
    pub(crate) work: &'f Work,
    /// The cells of level 0 that the mesh was made from.
    pub(crate) cells: Range<u32>,
    pub(crate) options: &'f Steps,
}

/// A refined mesh, and for each vertex of the mesh before, its new index if it has not moved; otherwise [`NONE`].
/// Vertices on the boundary do not move.
pub(crate) struct Refined {
    pub(crate) mesh: TriMesh,
    pub(crate) kept: Vec<u32>,
}

/// The refinement of a mesh whose faces may all have been simplified in other processes.
pub(crate) fn refinement(options: &Options) -> Steps {
    options.refine.steps(&options.protect, 0)
}

/// Whether the options ask for any refinement.
pub(crate) fn is_anything(options: &Steps) -> bool {
    options.fit.is_some() || options.anneal.is_some() || options.max_error.is_some()
}

impl Refinement<'_> {
    /// Refines a mesh.
    pub(crate) fn refine(
        &self,
        mut mesh: TriMesh,
        observer: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Refined, Error> {
        let mut kept: Vec<u32> = (0..as_u32(mesh.positions().len())).collect();
        if !is_anything(self.options) || mesh.topology().face_count() == 0 {
            return Ok(Refined { mesh, kept });
        }
        let mut follow = |round: Refined| {
            for v in kept.iter_mut().filter(|v| **v != NONE) {
                *v = round.kept[*v as usize];
            }
            round.mesh
        };
        let mut of_face = by_cell(&mesh, &self.work.manifest().cells, DMat3::IDENTITY);
        for face in mesh.topology().faces() {
            // Faces across the border of a cell may have their centroid beyond it.
            of_face[face] = of_face[face].clamp(self.cells.start, self.cells.end - 1);
        }
        let mut non_manifold = rims(&mesh, &of_face);
        mesh = follow(self.round(0, mesh, &of_face, self.cells.clone(), observer)?);
        // Vertices on boundaries between pieces have not moved; their faces may have been flipped.
        let depth = self.cells.len().trailing_zeros();
        for (number, [about_z, about_x]) in (1..).zip(TURNS) {
            let is_enough = number > 1 && non_manifold.len() * MOST_STUCK < mesh.positions().len();
            if non_manifold.is_empty() || is_enough {
                break;
            }
            let turn = DMat3::from_rotation_z(about_z) * DMat3::from_rotation_x(about_x);
            let sites = mesh.positions().iter().map(|&position| turn * position).collect();
            of_face = by_cell(&mesh, &Cells::new(sites, depth), turn);
            let is_near = near(&mesh, &non_manifold);
            for face in mesh.topology().faces().filter(|&face| !is_near[face]) {
                of_face[face] = NONE;
            }
            let on_rims = rims(&mesh, &of_face);
            non_manifold.retain(|place| on_rims.binary_search(place).is_ok());
            mesh = follow(self.round(number, mesh, &of_face, 0..1 << depth, observer)?);
        }
        Ok(Refined { mesh, kept })
    }

    /// Refines each piece separately, and joins the pieces.
    fn round(
        &self,
        number: u32,
        mesh: TriMesh,
        of_face: &FaceMap<u32>,
        pieces: Range<u32>,
        observer: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Refined, Error> {
        let folder = self.work.folder();
        // Another process may refine the same cell at the same time, if it assumes that this process is dead.
        let scratch = tempfile::Builder::new().prefix(REFINE).tempdir_in(folder);
        let scratch = scratch.map_err(Error::io(folder))?;
        let folder = scratch.path();
        let of = pieces.len() as u64;
        let mut goes_on = |what, done: u32| {
            let step = Step { what, done: u64::from(done), of, level: number };
            if observer(step) { Ok(()) } else { Err(Error::Stopped) }
        };
        let surface = Surface::new(&mesh)?;
        for cell in self.cells.clone() {
            goes_on("distributing", cell - self.cells.start)?;
            distribute(&self.work.region(0, cell)?, &surface, of_face, folder)?;
        }
        drop(surface);
        let mut refined = |options: &Steps| {
            let mut all = Vec::new();
            for piece in pieces.clone() {
                goes_on("fitting", piece - pieces.start)?;
                let Some(part) = Piece::new(&mesh, of_face, piece)? else { continue };
                all.push(match gather(folder, self.cells.clone(), piece)? {
                    Some(original) => part.refined(&original, options)?,
                    None => part,
                });
            }
            Ok::<_, Error>(all)
        };
        let glued = match glue(&mesh, of_face, &refined(self.options)?) {
            Ok(glued) => Some(glued),
            // Two pieces have flipped to the same edge. Without flips this cannot happen.
            Err(_) => glue(&mesh, of_face, &refined(&only_moves(self.options))?).ok(),
        };
        Ok(glued.unwrap_or_else(|| {
            let kept = (0..as_u32(mesh.positions().len())).collect();
            Refined { mesh, kept }
        }))
    }
}

/// The options without operations that change edges.
pub(crate) fn only_moves(options: &Steps) -> Steps {
    let fit = options.fit.map(|fit| FitOptions { flips: false, ..fit });
    Steps { fit, ..Steps::default() }
}

/// The piece of each face: the cell of its centroid after a rotation.
fn by_cell(mesh: &TriMesh, cells: &Cells, turn: DMat3) -> FaceMap<u32> {
    let mut of_face = mesh.topology().face_map(NONE);
    for face in mesh.topology().faces() {
        of_face[face] = cells.cell_of(turn * centroid(mesh.triangle(face)));
    }
    of_face
}

fn centroid([a, b, c]: [DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

/// The bits of a position, which identify a vertex that does not move.
type Place = [u64; 3];

fn place_of(point: DVec3) -> Place {
    point.to_array().map(f64::to_bits)
}

/// The positions of the vertices between pieces, in order.
fn rims(mesh: &TriMesh, of_face: &FaceMap<u32>) -> Vec<Place> {
    let topology = mesh.topology();
    let is_rim = |&v: &VertexId| {
        let mut pieces = topology.faces_of_vertex(v).map(|face| of_face[face]);
        let first = pieces.next();
        pieces.any(|piece| Some(piece) != first)
    };
    let mut rims: Vec<Place> =
        topology.vertices().filter(is_rim).map(|v| place_of(mesh.position(v))).collect();
    rims.sort_unstable();
    rims
}

/// The faces within some rings of the vertices at these positions.
fn near(mesh: &TriMesh, places: &[Place]) -> FaceMap<bool> {
    let topology = mesh.topology();
    let mut reached = topology.vertex_map(false);
    for v in topology.vertices() {
        reached[v] = places.binary_search(&place_of(mesh.position(v))).is_ok();
    }
    let mut is_near = topology.face_map(false);
    for _ in 0..RINGS {
        for face in topology.faces() {
            is_near[face] |= topology.face_vertices(face).iter().any(|&v| reached[v]);
        }
        for face in topology.faces().filter(|&face| is_near[face]) {
            topology.face_vertices(face).iter().for_each(|&v| reached[v] = true);
        }
    }
    is_near
}

fn part_path(folder: &Path, cell: u32, piece: u32) -> PathBuf {
    folder.join(format!("cell-{cell}-piece-{piece}.region"))
}

/// Writes the own faces of a region of the original to a file for each of their pieces.
fn distribute(
    region: &Region,
    surface: &Surface,
    of_face: &FaceMap<u32>,
    folder: &Path,
) -> Result<(), Error> {
    let triangles: Vec<[u32; 3]> = region.own_triangles().collect();
    let middles: Vec<DVec3> =
        triangles.iter().map(|t| centroid(t.map(|v| region.positions[v as usize]))).collect();
    let closest = surface.closest_to_neighbours(&middles);
    let mut dealt: Vec<(u32, u32)> =
        closest.iter().zip(0..).map(|(point, i)| (of_face[point.face], i)).collect();
    dealt.retain(|&(piece, _)| piece != NONE);
    dealt.sort_unstable();
    let mut number = vec![NONE; region.positions.len()];
    for group in dealt.chunk_by(|a, b| a.0 == b.0) {
        let mut used: Vec<u32> = group.iter().flat_map(|&(_, i)| triangles[i as usize]).collect();
        used.sort_unstable_by_key(|&v| region.vertex_ids[v as usize]);
        used.dedup();
        used.iter().enumerate().for_each(|(new, &v)| number[v as usize] = as_u32(new));
        let part = Region {
            level: 0,
            cell: group[0].0,
            own: 0,
            vertex_ids: used.iter().map(|&v| region.vertex_ids[v as usize]).collect(),
            other_cells: vec![NONE; used.len()],
            positions: used.iter().map(|&v| region.positions[v as usize]).collect(),
            triangles: group
                .iter()
                .map(|&(_, i)| triangles[i as usize].map(|v| number[v as usize]))
                .collect(),
            ..Region::default()
        };
        part.write(&part_path(folder, region.cell, part.cell))?;
    }
    Ok(())
}

/// Reads the part of the original that belongs to a piece.
fn gather(folder: &Path, cells: Range<u32>, piece: u32) -> Result<Option<Surface>, Error> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for cell in cells {
        let path = part_path(folder, cell, piece);
        if path.exists() {
            let part = Region::read(&path)?;
            // Unlike each part, all parts of a piece together may exceed 32 bits.
            if positions.len() + part.positions.len() > u32::MAX as usize {
                return Err(Error::RegionTooLarge { faces: triangles.len() as u64 });
            }
            let first = as_u32(positions.len());
            positions.extend(part.positions);
            triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
        }
    }
    if triangles.is_empty() {
        return Ok(None);
    }
    Ok(Some(Surface::from_triangles(&positions, &triangles)?))
}

/// Some triangles with the vertices that they use, and the old index of each of these vertices.
pub(crate) fn used_vertices(
    triangles: impl IntoIterator<Item = [u32; 3]>,
    vertices: usize,
    position: impl Fn(u32) -> DVec3,
) -> Result<(PolygonSoup, Vec<u32>), Error> {
    let mut numbers = FirstUse::new(vertices);
    let mut soup = PolygonSoup::new();
    for triangle in triangles {
        let known = numbers.used.len();
        let corners = numbers.triangle(triangle);
        numbers.used[known..].iter().for_each(|&v| {
            soup.push_vertex(position(v));
        });
        let faces = soup.face_count() as u64;
        soup.push_face(&corners).map_err(|_| Error::RegionTooLarge { faces })?;
    }
    Ok((soup, numbers.used))
}

/// A piece of the result.
struct Piece {
    mesh: TriMesh,
    /// The vertex of the whole mesh for each vertex on the boundary of the piece.
    rim: VertexMap<Option<VertexId>>,
}

impl Piece {
    fn new(mesh: &TriMesh, of_face: &FaceMap<u32>, piece: u32) -> Result<Option<Self>, Error> {
        let topology = mesh.topology();
        let faces: Vec<FaceId> = topology.faces().filter(|&face| of_face[face] == piece).collect();
        if faces.is_empty() {
            return Ok(None);
        }
        let triangles = faces.iter().map(|&face| topology.face_vertices(face).map(VertexId::get));
        let position = |v: u32| mesh.positions()[v as usize];
        let (soup, ids) = used_vertices(triangles, mesh.positions().len(), position)?;
        // Faces that share only a vertex are separated there. The vertex is on the boundary, and does not move.
        let mut cut = Repair::strict();
        cut.cut_non_manifold = true;
        let built = build(&soup, &cut).map_err(|error| Error::Build(Box::new(error)))?;
        let mut rim = built.mesh.topology().vertex_map(None);
        for v in built.mesh.topology().vertices() {
            if built.mesh.topology().is_boundary_vertex(v) {
                rim[v] = {
                    let source = built.provenance.vertex_source[v.index()];
                    Some(VertexId::new(ids[source as usize]))
                };
            }
        }
        Ok(Some(Self { mesh: built.mesh, rim }))
    }

    /// The piece after its refinement.
    fn refined(mut self, original: &Surface, options: &Steps) -> Result<Self, Error> {
        // Without curves, vertices on the boundary do not move.
        let mut constraints = FitConstraints::default();
        if let Some(options) = &options.fit {
            fit(&mut self.mesh, original, &constraints, options).map_err(SimplifyError::from)?;
        }
        if let Some(options) = &options.anneal
            && options.has_work(&self.mesh, original)
        {
            let report = anneal(&mut self.mesh, original, &mut constraints, options)
                .map_err(SimplifyError::from)?;
            self.follow(&report.vertex_map);
        }
        if let Some(options) = &options.max_error {
            let faces = self.mesh.topology().face_count();
            let options = MaxErrorOptions { min_faces: faces, ..*options };
            let report = reduce_max_error(&mut self.mesh, original, &mut constraints, &options)
                .map_err(SimplifyError::from)?;
            self.follow(&report.vertex_map);
        }
        if let Some(options) = &options.unfold {
            unfold(&mut self.mesh, original, &constraints, options);
        }
        Ok(self)
    }

    fn follow(&mut self, became: &VertexMap<Option<VertexId>>) {
        let mut rim = self.mesh.topology().vertex_map(None);
        for (old, new) in became.as_slice().iter().enumerate() {
            if let (Some(new), Some(id)) = (new, self.rim[VertexId::from_index(old)]) {
                rim[*new] = Some(id);
            }
        }
        self.rim = rim;
    }
}

/// Joins the pieces, and the faces that belong to no piece.
fn glue(
    mesh: &TriMesh,
    of_face: &FaceMap<u32>,
    pieces: &[Piece],
) -> Result<Refined, mesh_core::MeshError> {
    let topology = mesh.topology();
    let mut positions = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut number = topology.vertex_map(NONE);
    let mut place = |v: VertexId, positions: &mut Vec<DVec3>| {
        if number[v] == NONE {
            number[v] = as_u32(positions.len());
            positions.push(mesh.position(v));
        }
        number[v]
    };
    for face in topology.faces().filter(|&face| of_face[face] == NONE) {
        triangles.push(topology.face_vertices(face).map(|v| place(v, &mut positions)));
    }
    for piece in pieces {
        let own = piece.mesh.topology();
        let mut local = own.vertex_map(NONE);
        for v in own.vertices() {
            local[v] = match piece.rim[v] {
                Some(id) => place(id, &mut positions),
                None => {
                    positions.push(piece.mesh.position(v));
                    as_u32(positions.len() - 1)
                }
            };
        }
        triangles.extend(own.faces().map(|face| own.face_vertices(face).map(|v| local[v])));
    }
    let mesh = TriMesh::from_triangles(&positions, &triangles)?;
    Ok(Refined { mesh, kept: number.into_vec() })
}

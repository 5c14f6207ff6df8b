//! Fitting the result to the original, piece by piece, each against its own part of the original.
//!
//! The faces of the result are dealt out to pieces by cell. A face of the original belongs to the piece that
//! is closest to its middle. Each piece is fitted, annealed, and its peaks are cut, as the options say; its
//! rim stays, so that pieces fit together again. Further rounds do the same with strips along what has been a
//! rim in every round so far, in pieces that are cut in other directions, until next to nothing has.

use core::ops::Range;
use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use mesh_core::{
    FaceId, FaceMap, Handle, PolygonSoup, Repair, TriMesh, VertexId, VertexMap, build,
};
use mesh_metric::Surface;
use simplify::{
    FitConstraints, FitOptions, MaxErrorOptions, Options, SimplifyError, Steps, anneal, fit,
    reduce_max_error,
};

use crate::cells::Cells;
use crate::error::Error;
use crate::region::Region;
use crate::work::{Step, Work};

/// So many rings of faces about a rim make up the strip in which it is smoothed over.
const RINGS: usize = 4;

/// Rounds end when fewer than one in so many vertices has been on a rim in every one of them. Large pieces have
/// come so far after the second.
const MOST_STUCK: usize = 100;

/// The directions in which pieces of the rounds after the first are cut: angles about z, then about x.
const TURNS: [[f64; 2]; 3] = [[0.785, 0.471], [1.3, 1.1], [2.2, 0.8]];

/// No piece, no vertex.
pub(crate) const NONE: u32 = u32::MAX;

/// What a mesh is finished against, and how.
pub(crate) struct Finishing<'f> {
    pub(crate) work: &'f Work,
    /// The cells of level 0 whose faces it stands for.
    pub(crate) cells: Range<u32>,
    /// Where files go in the meantime; made, and removed again.
    pub(crate) folder: PathBuf,
    pub(crate) options: &'f Steps,
}

/// A mesh that was finished, and the number in it of each vertex that was there before and has not been
/// moved; [`NONE`] for others. What was on the boundary is among them.
pub(crate) struct Finished {
    pub(crate) mesh: TriMesh,
    pub(crate) kept: Vec<u32>,
}

/// The refinement of a mesh of which every face may have been simplified elsewhere.
pub(crate) fn refinement(options: &Options) -> Steps {
    options.refine.steps(&options.protect, 0)
}

/// Whether the options say that anything comes after the collapses.
pub(crate) fn is_anything(options: &Steps) -> bool {
    options.fit.is_some() || options.anneal.is_some() || options.max_error.is_some()
}

impl Finishing<'_> {
    /// Finishes what the collapses have left.
    pub(crate) fn finish(
        &self,
        mut mesh: TriMesh,
        see: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Finished, Error> {
        let mut kept: Vec<u32> = (0..mesh.positions().len() as u32).collect();
        if !is_anything(self.options) || mesh.topology().face_count() == 0 {
            return Ok(Finished { mesh, kept });
        }
        let mut follow = |round: Finished| {
            for v in kept.iter_mut().filter(|v| **v != NONE) {
                *v = round.kept[*v as usize];
            }
            round.mesh
        };
        let mut of_face = by_cell(&mesh, &self.work.manifest().cells, DMat3::IDENTITY);
        for face in mesh.topology().faces() {
            // Faces across the border of a cell may have their middle beyond it.
            of_face[face] = of_face[face].clamp(self.cells.start, self.cells.end - 1);
        }
        let mut stuck = rims(&mesh, &of_face);
        mesh = follow(self.round(0, mesh, &of_face, self.cells.clone(), see)?);
        // The rims are where they were; faces about them may have been flipped or moved since.
        let depth = self.cells.len().trailing_zeros();
        for (number, [about_z, about_x]) in (1..).zip(TURNS) {
            let is_enough = number > 1 && stuck.len() * MOST_STUCK < mesh.positions().len();
            if stuck.is_empty() || is_enough {
                break;
            }
            let turn = DMat3::from_rotation_z(about_z) * DMat3::from_rotation_x(about_x);
            let sites = mesh.positions().iter().map(|&position| turn * position).collect();
            of_face = by_cell(&mesh, &Cells::new(sites, depth), turn);
            let is_near = near(&mesh, &stuck);
            for face in mesh.topology().faces().filter(|&face| !is_near[face]) {
                of_face[face] = NONE;
            }
            let on_rims = rims(&mesh, &of_face);
            stuck.retain(|place| on_rims.binary_search(place).is_ok());
            mesh = follow(self.round(number, mesh, &of_face, 0..1 << depth, see)?);
        }
        Ok(Finished { mesh, kept })
    }

    /// Finishes every piece by itself, and puts them together again.
    fn round(
        &self,
        number: u32,
        mesh: TriMesh,
        of_face: &FaceMap<u32>,
        pieces: Range<u32>,
        see: &mut dyn FnMut(Step) -> bool,
    ) -> Result<Finished, Error> {
        let folder = &self.folder;
        // What an interrupted run has left belongs to another round.
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
        let of = pieces.len() as u64;
        let mut goes_on = |what, done: u32| {
            let step = Step { what, done: u64::from(done), of, level: number };
            if see(step) { Ok(()) } else { Err(Error::Stopped) }
        };
        let surface = Surface::new(&mesh)?;
        for cell in self.cells.clone() {
            goes_on("dealing out", cell - self.cells.start)?;
            deal(&self.work.region(0, cell)?, &surface, of_face, folder)?;
        }
        drop(surface);
        let mut finished = |options: &Steps| {
            let mut all = Vec::new();
            for piece in pieces.clone() {
                goes_on("fitting", piece - pieces.start)?;
                let Some(part) = Piece::new(&mesh, of_face, piece)? else { continue };
                all.push(match gather(folder, self.cells.clone(), piece)? {
                    Some(original) => part.finished(&original, options)?,
                    None => part,
                });
            }
            Ok::<_, Error>(all)
        };
        let glued = match glue(&mesh, of_face, &finished(self.options)?) {
            Ok(glued) => Some(glued),
            // Two pieces have come to the same edge between their rims. What only moves cannot.
            Err(_) => glue(&mesh, of_face, &finished(&only_moves(self.options))?).ok(),
        };
        let _ = std::fs::remove_dir_all(folder);
        Ok(glued.unwrap_or_else(|| {
            let kept = (0..mesh.positions().len() as u32).collect();
            Finished { mesh, kept }
        }))
    }
}

/// The options without what changes the edges.
pub(crate) fn only_moves(options: &Steps) -> Steps {
    let fit = options.fit.map(|fit| FitOptions { flips: false, ..fit });
    Steps { fit, anneal: None, max_error: None }
}

/// The piece of each face: the cell of its middle, in other directions.
fn by_cell(mesh: &TriMesh, cells: &Cells, turn: DMat3) -> FaceMap<u32> {
    let mut of_face = mesh.topology().face_map(NONE);
    for face in mesh.topology().faces() {
        of_face[face] = cells.cell_of(turn * middle(mesh.triangle(face)));
    }
    of_face
}

fn middle([a, b, c]: [DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

/// The bits of a position, by which a vertex that stays is found again.
type Place = [u64; 3];

fn place_of(point: DVec3) -> Place {
    point.to_array().map(f64::to_bits)
}

/// The places of the vertices between pieces, in order.
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

/// The faces within some rings of the vertices at these places.
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

/// Writes the own faces of a region of the original to a file for each piece that they belong to.
fn deal(
    region: &Region,
    surface: &Surface,
    of_face: &FaceMap<u32>,
    folder: &Path,
) -> Result<(), Error> {
    let triangles: Vec<[u32; 3]> = region.own_triangles().collect();
    let middles: Vec<DVec3> =
        triangles.iter().map(|t| middle(t.map(|v| region.positions[v as usize]))).collect();
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
        used.iter().enumerate().for_each(|(new, &v)| number[v as usize] = new as u32);
        let part = Region {
            level: 0,
            cell: group[0].0,
            own: 0,
            vertex_ids: used.iter().map(|&v| region.vertex_ids[v as usize]).collect(),
            homes: vec![NONE; used.len()],
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

/// The part of the original that belongs to a piece.
fn gather(folder: &Path, cells: Range<u32>, piece: u32) -> Result<Option<Surface>, Error> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for cell in cells {
        let path = part_path(folder, cell, piece);
        if path.exists() {
            let part = Region::read(&path)?;
            let first = positions.len() as u32;
            positions.extend(part.positions);
            triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
        }
    }
    if triangles.is_empty() {
        return Ok(None);
    }
    Ok(Some(Surface::from_triangles(&positions, &triangles)?))
}

/// A piece of the result.
struct Piece {
    mesh: TriMesh,
    /// The vertex of the whole for each vertex of the piece that lies on its rim, or on the boundary.
    rim: VertexMap<Option<VertexId>>,
}

impl Piece {
    fn new(mesh: &TriMesh, of_face: &FaceMap<u32>, piece: u32) -> Result<Option<Self>, Error> {
        let topology = mesh.topology();
        let faces: Vec<FaceId> = topology.faces().filter(|&face| of_face[face] == piece).collect();
        if faces.is_empty() {
            return Ok(None);
        }
        let mut soup = PolygonSoup::with_capacity(faces.len(), faces.len(), 3 * faces.len());
        let mut number = topology.vertex_map(NONE);
        let mut ids = Vec::new();
        for &face in &faces {
            let corners = topology.face_vertices(face).map(|v| {
                if number[v] == NONE {
                    number[v] = ids.len() as u32;
                    ids.push(v);
                    soup.push_vertex(mesh.position(v));
                }
                number[v]
            });
            let too_large = |_| Error::RegionTooLarge { faces: faces.len() as u64 };
            soup.push_face(&corners).map_err(too_large)?;
        }
        // Faces that meet at a vertex alone come apart there; it is on the rim, and stays.
        let mut cut = Repair::strict();
        cut.cut_non_manifold = true;
        let built = build(&soup, &cut).map_err(|error| Error::Build(Box::new(error)))?;
        let mut rim = built.mesh.topology().vertex_map(None);
        for v in built.mesh.topology().vertices() {
            if built.mesh.topology().is_boundary_vertex(v) {
                rim[v] = Some(ids[built.provenance.vertex_source[v.index()] as usize]);
            }
        }
        Ok(Some(Self { mesh: built.mesh, rim }))
    }

    /// The same, closer to the original.
    fn finished(mut self, original: &Surface, options: &Steps) -> Result<Self, Error> {
        // Without a curve to slide along, what is on the boundary stays.
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

/// Puts the pieces in the place of the faces that they were made of.
fn glue(
    mesh: &TriMesh,
    of_face: &FaceMap<u32>,
    pieces: &[Piece],
) -> Result<Finished, mesh_core::MeshError> {
    let topology = mesh.topology();
    let mut positions = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut number = topology.vertex_map(NONE);
    let mut place = |v: VertexId, positions: &mut Vec<DVec3>| {
        if number[v] == NONE {
            number[v] = positions.len() as u32;
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
                    (positions.len() - 1) as u32
                }
            };
        }
        triangles.extend(own.faces().map(|face| own.face_vertices(face).map(|v| local[v])));
    }
    let mesh = TriMesh::from_triangles(&positions, &triangles)?;
    Ok(Finished { mesh, kept: number.into_vec() })
}

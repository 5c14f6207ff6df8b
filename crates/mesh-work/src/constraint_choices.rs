//! Constraints of a simplification that name properties of the file or are given in units of the user.

use mesh_core::{FaceMap, VertexMap};
use mesh_io::Scalars;
use simplify::{FaceLimits, Options, Target};

use crate::labels::UnknownNumbers;
use crate::length::{Length, NoExtent};
use crate::loaded::Source;

/// Constraints of a simplification: marked elements, importance, and limits on new faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConstraintChoices {
    /// A named number of vertices or faces. Vertices with another value than 0 stay where they are. Faces with another
    /// value than 0 stay as they are, with their corners. Both apply if vertices and faces have numbers of this name.
    pub keep: Option<String>,
    /// A named number of vertices, at least 0: their importance; see [`simplify::Protect::importance`].
    pub weight: Option<String>,
    /// The greatest length of an edge; see [`FaceLimits::max_edge`].
    pub max_edge: Option<Length>,
    /// The smallest angle of a face, in radians; see [`FaceLimits::min_angle`].
    pub min_angle: Option<f64>,
    /// The greatest number of edges at a vertex; see [`FaceLimits::max_valence`].
    pub max_valence: Option<usize>,
    /// Whether a plain length is a share of the diagonal.
    pub relative: bool,
}

/// Why constraints do not suit a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConstraintError {
    /// The file has no numbers of this name.
    #[error(transparent)]
    Unknown(#[from] UnknownNumbers),
    /// Importance is a property of vertices, and only faces have numbers of this name.
    #[error(
        "{0} belongs to faces, but importance is a property of vertices; store one number per vertex"
    )]
    OfFaces(String),
    /// An importance is negative, infinite or not a number.
    #[error("{name} of vertex {vertex} is {value}, but importance must be at least 0 and finite")]
    Importance {
        /// The name of the property.
        name: String,
        /// The vertex of the file, from 0.
        vertex: u32,
        /// The value.
        value: f64,
    },
    /// A mark is not a number.
    #[error(
        "{name} of {element} is not a number, so it is unknown whether it is kept; store 0 or 1"
    )]
    Mark {
        /// The name of the property.
        name: String,
        /// The vertex or face of the file, from 0.
        element: String,
    },
    /// A length is relative to a mesh without extent.
    #[error(transparent)]
    NoExtent(#[from] NoExtent),
}

impl ConstraintChoices {
    /// Whether there is any constraint.
    #[must_use]
    pub fn is_any(&self) -> bool {
        let Self { keep, weight, max_edge, min_angle, max_valence, .. } = self;
        let names = keep.is_some() || weight.is_some();
        names || max_edge.is_some() || min_angle.is_some() || max_valence.is_some()
    }

    /// Adds the constraints to the options for this mesh. Returns the numbers of kept vertices and faces.
    ///
    /// If the kept faces leave the others less than half of their share of the wanted faces, the target grows, so that
    /// the others get their share. Otherwise they would be collapsed to nothing.
    ///
    /// # Errors
    /// A property is unknown or has values that mean nothing, or a length is relative to a mesh without extent.
    pub fn constrain(
        &self,
        source: Source<'_>,
        options: &mut Options,
    ) -> Result<[usize; 2], ConstraintError> {
        let max_edge = self.max_edge.map(|length| length.on(source.mesh, self.relative));
        options.protect.limits = FaceLimits {
            max_edge: max_edge.transpose()?,
            min_angle: self.min_angle,
            max_valence: self.max_valence,
        };
        if let Some(name) = &self.weight {
            options.protect.importance = Some(importance(source, name)?);
        }
        let Some(name) = &self.keep else { return Ok([0; 2]) };
        let kept = keep(source, name, options)?;
        leave_room(source.mesh.topology().face_count(), kept[1], &mut options.target);
        Ok(kept)
    }
}

/// Raises a number of faces that the kept faces leave no room in.
fn leave_room(all: usize, kept: usize, target: &mut Target) {
    if kept == 0 || (target.faces.is_none() && target.ratio.is_none()) {
        return;
    }
    let wanted = target.face_target(all);
    let share = ((all - kept) as f64 * wanted as f64 / all as f64).round() as usize;
    if wanted < kept + share / 2 {
        *target = Target { faces: Some(kept + share), ratio: None, ..*target };
    }
}

/// The numbers of this name.
fn find<'a>(all: &'a [Scalars], name: &str) -> Option<&'a Scalars> {
    all.iter().find(|scalars| scalars.name == name)
}

/// For each vertex of the mesh, the greatest value of the vertices of the file that it was made from.
fn greatest(
    source: Source<'_>,
    scalars: &Scalars,
    check: impl Fn(u32, f64) -> Result<f64, ConstraintError>,
) -> Result<VertexMap<f64>, ConstraintError> {
    let topology = source.mesh.topology();
    let mut values = topology.vertex_map(0.0_f64);
    let mut add = |v: usize, file: u32| {
        let value = check(file, scalars.values.get(file as usize).unwrap_or(f64::NAN))?;
        if let Some(greatest) = values.as_mut_slice().get_mut(v) {
            *greatest = greatest.max(value);
        }
        Ok::<(), ConstraintError>(())
    };
    for (v, &file) in source.provenance.vertex_source.iter().enumerate() {
        add(v, file)?;
    }
    let corners = source.model.soup.corners();
    for (triangle, sources) in topology.triangles().zip(&source.provenance.corner_source) {
        for (v, &corner) in triangle.into_iter().zip(sources) {
            if let Some(&file) = corners.get(corner as usize) {
                add(v as usize, file)?;
            }
        }
    }
    Ok(values)
}

fn importance(source: Source<'_>, name: &str) -> Result<VertexMap<f64>, ConstraintError> {
    let Some(scalars) = find(&source.model.vertex_scalars, name) else {
        return Err(match find(&source.model.face_scalars, name) {
            Some(_) => ConstraintError::OfFaces(name.to_owned()),
            None => UnknownNumbers::new(source.model, name).into(),
        });
    };
    greatest(source, scalars, |vertex, value| {
        let error = || ConstraintError::Importance { name: name.to_owned(), vertex, value };
        if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(error()) }
    })
}

/// Keeps the marked vertices and faces, and returns their numbers.
fn keep(
    source: Source<'_>,
    name: &str,
    options: &mut Options,
) -> Result<[usize; 2], ConstraintError> {
    let of_vertices = find(&source.model.vertex_scalars, name);
    let of_faces = find(&source.model.face_scalars, name);
    if of_vertices.is_none() && of_faces.is_none() {
        return Err(UnknownNumbers::new(source.model, name).into());
    }
    let mark = |kind: &str, element: u32, value: f64| {
        let error = || ConstraintError::Mark {
            name: name.to_owned(),
            element: format!("{kind} {element}"),
        };
        if value.is_nan() { Err(error()) } else { Ok(f64::from(u8::from(value != 0.0))) }
    };
    let topology = source.mesh.topology();
    let mut counts = [0; 2];
    if let Some(scalars) = of_vertices {
        let marks = greatest(source, scalars, |vertex, value| mark("vertex", vertex, value))?;
        options.protect.keep_vertices(topology, |v| marks[v] > 0.0);
        counts[0] = marks.live(topology).filter(|(_, mark)| **mark > 0.0).count();
    }
    if let Some(scalars) = of_faces {
        let mut kept: FaceMap<bool> = topology.face_map(false);
        for (face, &file) in topology.faces().zip(&source.provenance.face_source) {
            let value = scalars.values.get(file as usize).unwrap_or(f64::NAN);
            kept[face] = mark("face", file, value)? > 0.0;
        }
        options.protect.keep_faces(topology, &kept);
        counts[1] = kept.as_slice().iter().filter(|&&kept| kept).count();
    }
    Ok(counts)
}

//! Serde implementations for types with invariants: meshes, soups, handles, maps and samples.
//!
//! Deserialised data is validated: any data gives a valid value or an error. Types without
//! invariants derive their implementations.

use std::borrow::Cow;

use glam::DVec3;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::attribute::AttributeMap;
use crate::build::Sample;
use crate::build::soup::PolygonSoup;
use crate::mesh::TriMesh;
use crate::topology::half_edges::{HalfEdge, Topology};
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::revision::Revision;

/// The index for "no element": a half-edge without a face, a vertex without a half-edge.
const NONE: u32 = u32::MAX;

/// The index of a removed element.
const REMOVED: u32 = u32::MAX - 1;

macro_rules! handle {
    ($($handle:ty),*) => {$(
        /// The index.
        impl Serialize for $handle {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_u32(self.get())
            }
        }

        impl<'de> Deserialize<'de> for $handle {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let index = u32::deserialize(deserializer)?;
                if (index as usize) < Self::LIMIT {
                    Ok(Self::new(index))
                } else {
                    Err(D::Error::custom(format_args!("{index} is no index of an element")))
                }
            }
        }
    )*};
}

handle!(VertexId, EdgeId, HalfEdgeId, FaceId);

/// The values, in order of index.
impl<H, T: Serialize> Serialize for AttributeMap<H, T>
where
    H: Handle,
{
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.as_slice().serialize(serializer)
    }
}

impl<'de, H: Handle, T: Deserialize<'de>> Deserialize<'de> for AttributeMap<H, T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self::from_vec)
    }
}

/// The arrays of a topology, element after element, with indices for all handles.
#[derive(Serialize, Deserialize)]
#[serde(rename = "Topology", deny_unknown_fields)]
struct TopologyArrays {
    /// A half-edge that starts at each vertex.
    vertices: Vec<u32>,
    /// The first half-edge of each face.
    faces: Vec<u32>,
    /// Per half-edge its `next`, its target vertex and its face.
    half_edges: Vec<[u32; 3]>,
}

/// All handles stay valid, even if elements were removed.
impl Serialize for Topology {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let half_edge = |h: &HalfEdge| {
            if h.next == HalfEdgeId::REMOVED {
                [REMOVED; 3]
            } else {
                [h.next.get(), h.target.get(), h.face.map_or(NONE, FaceId::get)]
            }
        };
        // The handle of removed elements has exactly this index.
        let of_vertex = |h: &Option<HalfEdgeId>| h.map_or(NONE, HalfEdgeId::get);
        TopologyArrays {
            vertices: self.vertex_half_edge.iter().map(of_vertex).collect(),
            faces: self.face_half_edge.iter().map(|h| h.get()).collect(),
            half_edges: self.half_edges.iter().map(half_edge).collect(),
        }
        .serialize(serializer)
    }
}

/// Checks all invariants.
impl<'de> Deserialize<'de> for Topology {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        TopologyArrays::deserialize(deserializer)?.topology().map_err(D::Error::custom)
    }
}

impl TopologyArrays {
    fn topology(self) -> Result<Topology, String> {
        let sizes = [self.vertices.len(), self.faces.len(), self.half_edges.len()];
        if sizes.into_iter().any(|size| size >= VertexId::LIMIT) {
            return Err("the mesh has more elements than 32-bit indices can address".into());
        }
        let half_edge_or_removed = |index: u32| match index {
            REMOVED => Ok(HalfEdgeId::REMOVED),
            index => half_edge(index),
        };
        let vertices: Result<Vec<_>, _> = self
            .vertices
            .into_iter()
            .map(
                |index| {
                    if index == NONE { Ok(None) } else { half_edge_or_removed(index).map(Some) }
                },
            )
            .collect();
        let faces: Result<Vec<_>, _> = self.faces.into_iter().map(half_edge_or_removed).collect();
        let half_edges: Result<Vec<_>, _> = self
            .half_edges
            .into_iter()
            .map(|[next, target, face]| {
                if next == REMOVED {
                    return Ok(HalfEdge::UNSET);
                }
                let target = checked(target, "vertex").map(VertexId::new)?;
                let face = match face {
                    NONE => None,
                    face => Some(checked(face, "face").map(FaceId::new)?),
                };
                Ok::<_, String>(HalfEdge { next: half_edge(next)?, target, face })
            })
            .collect();
        let mut topology = Topology {
            half_edges: half_edges?,
            vertex_half_edge: vertices?,
            face_half_edge: faces?,
            live_vertices: 0,
            live_edges: 0,
            live_faces: 0,
            revision: Revision::new(),
        };
        topology.live_vertices = topology.vertices().count();
        topology.live_edges = topology.edges().count();
        topology.live_faces = topology.faces().count();
        topology.validate().map_err(|broken| format!("the mesh is not sound: {broken}"))?;
        Ok(topology)
    }
}

fn half_edge(index: u32) -> Result<HalfEdgeId, String> {
    checked(index, "half-edge").map(HalfEdgeId::new)
}

fn checked(index: u32, what: &str) -> Result<u32, String> {
    if index < REMOVED { Ok(index) } else { Err(format!("{index} is no index of a {what}")) }
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "TriMesh", deny_unknown_fields)]
struct MeshParts<'a> {
    topology: Cow<'a, Topology>,
    positions: Cow<'a, [DVec3]>,
}

/// All handles stay valid.
impl Serialize for TriMesh {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        MeshParts {
            topology: Cow::Borrowed(self.topology()),
            positions: Cow::Borrowed(self.positions()),
        }
        .serialize(serializer)
    }
}

/// Checks all invariants, and that the positions are finite.
impl<'de> Deserialize<'de> for TriMesh {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let parts = MeshParts::deserialize(deserializer)?;
        Self::new(parts.topology.into_owned(), parts.positions.into_owned())
            .map_err(D::Error::custom)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "PolygonSoup", deny_unknown_fields)]
struct SoupParts<'a> {
    positions: Cow<'a, [DVec3]>,
    corners: Cow<'a, [u32]>,
    face_ends: Cow<'a, [u32]>,
}

/// Formats without infinities and NaN, such as JSON, cannot hold all soups.
impl Serialize for PolygonSoup {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SoupParts {
            positions: Cow::Borrowed(self.positions()),
            corners: Cow::Borrowed(self.corners()),
            face_ends: Cow::Borrowed(self.face_ends()),
        }
        .serialize(serializer)
    }
}

/// Checks that the face ends ascend to the number of corners. Nothing else is an invariant of a soup.
impl<'de> Deserialize<'de> for PolygonSoup {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let SoupParts { positions, corners, face_ends } = SoupParts::deserialize(deserializer)?;
        Self::from_parts(positions.into_owned(), corners.into_owned(), face_ends.into_owned())
            .map_err(D::Error::custom)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Sample", deny_unknown_fields)]
struct SampleParts<T> {
    count: usize,
    first: Vec<T>,
}

impl<T: Serialize> Serialize for Sample<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let first: Vec<&T> = self.first().iter().collect();
        SampleParts { count: self.count(), first }.serialize(serializer)
    }
}

/// Checks that the number of kept elements fits the count.
impl<'de, T: Deserialize<'de>> Deserialize<'de> for Sample<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let SampleParts { count, first } = SampleParts::deserialize(deserializer)?;
        Self::from_parts(first, count)
            .ok_or_else(|| D::Error::custom(format_args!("no sample of {count} elements")))
    }
}

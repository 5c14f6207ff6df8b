//! Transfer of texture coordinates, normals, colours, labels and materials to a simplified mesh.
//!
//! Seams are feature lines of the simplification, as far as the wanted number of faces leaves room for them. Attributes
//! inside the charts are part of its cost. Each corner of the result then takes the texture coordinates of the input at
//! the closest point in its chart, and all other data at the closest point of the surface.

use glam::{DVec3, Vec3};
use mesh_core::{
    EdgeMap, HalfEdgeId, HalfEdgeMap, TriMesh, UnitScale, VertexId, VertexMap, as_u32,
};
use mesh_io::{Blend, Model, ModelError};
use simplify::{
    AttributeOptions, CornerAttributes, CornerSource, Options, SimplifyError, Target,
    corner_sources, seam_nodes,
};

use crate::charts::{Charted, MergedCharts};
use crate::loaded::Source;
use crate::normals::settle_normals;
use crate::seams::Seams;

/// How attributes are weighted and transferred.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AttributeRules {
    /// Weight of texture and colour errors; 0 ignores them. At 1, a texture shift of one model unit costs as
    /// much as a surface shift of one unit. So does a change from black to white on a mesh whose diagonal is
    /// 100 units.
    pub attribute_weight: f64,
    /// Weight of errors of the normals of the file; 0 ignores them. At 1, a normal that turns by one radian
    /// costs as much as a surface shift of one unit on a mesh whose diagonal is 100 units.
    pub normal_weight: f64,
    /// Angle in radians. An edge is a crease if the normals of the file on both sides differ by more.
    pub crease_angle: f64,
    /// Whether creases are feature lines. Borders of texture charts, materials, groups and labels are, unless
    /// [`Attributes::merge_charts`] merges charts.
    pub keep_creases: bool,
    /// Whether attributes are transferred. If not, the result has positions and faces only.
    pub carry: bool,
}

impl Default for AttributeRules {
    fn default() -> Self {
        Self {
            attribute_weight: 0.3,
            normal_weight: 0.0,
            crease_angle: 40_f64.to_radians(),
            keep_creases: false,
            carry: true,
        }
    }
}

/// The seams of a mesh and the attributes of its corners.
#[derive(Clone, Debug)]
pub struct Attributes {
    seams: Seams,
    rules: AttributeRules,
    flat_shaded: bool,
    of_corners: Option<CornerAttributes>,
    merged: Option<MergedCharts>,
}

impl Attributes {
    /// Finds the seams and the attributes of a mesh.
    ///
    /// # Errors
    /// A corner has more attribute values than the cost supports, or one is not finite.
    pub fn find(source: Source<'_>, rules: &AttributeRules) -> Result<Self, SimplifyError> {
        let topology = source.mesh.topology();
        let (mut flat_shaded, mut of_corners) = (false, None);
        // The search for the source of each corner is slow. A model without attributes does not need it.
        let rules = AttributeRules { carry: rules.carry && !source.model.is_bare(), ..*rules };
        let bare = Model::default();
        let model = if rules.carry { source.model } else { &bare };
        let mut seams = Seams::find(topology, source.provenance, model);
        if let Some(normals) = &model.corner_normals {
            flat_shaded = is_flat_shaded(source.mesh, &seams, normals);
            if rules.keep_creases && !flat_shaded {
                seams.add_creases(topology, normals, rules.crease_angle);
            }
        }
        if rules.carry {
            of_corners = corner_attributes(source, &seams, &rules, !flat_shaded)?;
        }
        Ok(Self { seams, rules, flat_shaded, of_corners, merged: None })
    }

    /// Whether the mesh is flat-shaded: the corners of a face share one normal. The result has no normals then.
    #[must_use]
    pub fn is_flat_shaded(&self) -> bool {
        self.flat_shaded
    }

    /// Number of edges that are seams or creases.
    #[must_use]
    pub fn seam_count(&self) -> usize {
        self.seams.count()
    }

    /// Merges the smallest charts with neighbours if the borders of all charts need more than a fifth of the wanted faces.
    /// Collapses then cross the borders of merged charts, and each face of the result takes the attributes of one
    /// chart. Nothing is merged if creases are kept.
    ///
    /// Returns the attributes with merged charts; `None` if all charts stay.
    #[must_use]
    pub fn merge_charts(&self, mesh: &TriMesh, target: &Target) -> Option<Self> {
        // A mesh has about twice as many faces as vertices.
        let by_vertices = target.vertices.unwrap_or(0).saturating_mul(2);
        let faces = target.face_target(mesh.topology().face_count()).max(by_vertices);
        if faces == 0 {
            // Another limit ends the run, and the borders are no obstacle to it.
            return None;
        }
        let charted = self.charted(mesh, 1, 1.0)?;
        let merged = MergedCharts::make_room(&[charted], faces).pop().flatten()?;
        Some(self.with_merged(mesh, merged))
    }

    /// The charts of a mesh that is drawn a number of times, with areas that grow by a factor; `None` if they all stay.
    pub(crate) fn charted<'a>(
        &'a self,
        mesh: &'a TriMesh,
        times: usize,
        growth: f64,
    ) -> Option<Charted<'a>> {
        let is_wanted = !self.rules.keep_creases && self.seams.count() > 0;
        is_wanted.then_some(Charted { mesh, seams: &self.seams.edges, times, growth })
    }

    /// The attributes with merged charts.
    pub(crate) fn with_merged(&self, mesh: &TriMesh, merged: MergedCharts) -> Self {
        let of_corners = self.of_corners.as_ref().map(|corners| {
            let guides = merged.guides(mesh);
            corners.taking(mesh, |h| guides[h])
        });
        Self { merged: Some(merged), of_corners, ..self.clone() }
    }

    /// The numbers of charts before and after some were merged; `None` if none were.
    #[must_use]
    pub fn merged(&self) -> Option<[usize; 2]> {
        self.merged.as_ref().map(|merged| [merged.before, merged.after])
    }

    /// The seams that stay.
    fn kept_seams(&self) -> &EdgeMap<bool> {
        self.merged.as_ref().map_or(&self.seams.edges, |merged| &merged.seams)
    }

    /// Makes the seams feature edges, locks the vertices where seams meet, and adds the attributes to the cost.
    pub fn constrain(&self, mesh: &TriMesh, options: &mut Options) {
        let topology = mesh.topology();
        if self.seams.count() > 0 {
            let constraints = &mut options.protect;
            let features = constraints.features.get_or_insert_with(|| topology.edge_map(false));
            for edge in topology.edges() {
                features[edge] |= self.kept_seams()[edge];
            }
            let locked = constraints.locked.get_or_insert_with(|| topology.vertex_map(false));
            let nodes = seam_nodes(topology, self.kept_seams());
            for v in topology.vertices() {
                locked[v] |= nodes[v];
            }
        }
        // The curvature norms have no attribute term. The values are weighted already.
        let counting = !options.cost.metric.is_norm();
        let corners = self.of_corners.clone().filter(|_| counting);
        options.attributes = AttributeOptions { corners, ..AttributeOptions::default() };
    }

    /// The simplified mesh with the attributes of the input. `became` maps old to new vertices.
    ///
    /// # Errors
    /// `result` is not a simplification of this mesh.
    pub fn carry(
        &self,
        loaded: Source<'_>,
        result: &TriMesh,
        became: &VertexMap<Option<VertexId>>,
    ) -> Result<Model, ModelError> {
        if !self.rules.carry {
            return Ok(Model::from(result));
        }
        self.carry_from(loaded, result, &self.sources(loaded, result, became))
    }

    /// For each element of the simplified mesh, where its data come from.
    pub(crate) fn sources(
        &self,
        loaded: Source<'_>,
        result: &TriMesh,
        became: &VertexMap<Option<VertexId>>,
    ) -> Sources {
        let find = |charts| corner_sources(loaded.mesh, self.kept_seams(), charts, result, became);
        let closest = find(None);
        // A face takes texture coordinates from one chart. Data of vertices are not bound to charts.
        let in_charts = self.merged.as_ref().map(|merged| find(Some(&merged.charts)));
        let sources = in_charts.as_ref().unwrap_or(&closest);
        let topology = result.topology();
        // An isolated vertex has its position only.
        let mut vertices = vec![Blend::one(0); topology.vertex_capacity()];
        for (old, new) in became.iter() {
            if let Some(new) = new {
                vertices[new.index()] = Blend::one(loaded.provenance.vertex_source[old.index()]);
            }
        }
        let (mut faces, mut corners, mut points) = (Vec::new(), Vec::new(), Vec::new());
        for face in topology.faces() {
            let sides = topology.face_half_edges(face);
            let at_points = sides.map(|h| self.blend(loaded, &closest, h));
            for (h, blend) in sides.into_iter().zip(&at_points) {
                let vertex = |corner: u32| loaded.model.soup.corners()[corner as usize];
                let sources = blend.sources.map(vertex);
                vertices[topology.origin(h).index()] = Blend { sources, ..*blend };
            }
            let source = sides.iter().find_map(|&h| sources[h]).map_or(0, |s| s.face.index());
            faces.push(loaded.provenance.face_source.get(source).copied().unwrap_or(0));
            corners.push(sides.map(|h| self.blend(loaded, sources, h)));
            points.push(at_points);
        }
        Sources { vertices, faces, corners, points }
    }

    /// The simplified mesh with the attributes of the input.
    pub(crate) fn carry_from(
        &self,
        loaded: Source<'_>,
        result: &TriMesh,
        Sources { vertices, faces, corners, points }: &Sources,
    ) -> Result<Model, ModelError> {
        let triangles: Vec<[u32; 3]> = result.topology().triangles().collect();
        let mut model =
            loaded.model.blended(result.positions(), &triangles, vertices, faces, corners)?;
        if self.flat_shaded {
            model.corner_normals = None;
        }
        if let (Some(new), Some(old), Some(_)) =
            (&mut model.corner_normals, &loaded.model.corner_normals, &self.merged)
        {
            for (normal, Blend { sources, weights }) in new.iter_mut().zip(points.as_flattened()) {
                let sum = sources.iter().zip(weights).map(|(&corner, &weight)| {
                    old.get(corner as usize).map_or(Vec3::ZERO, |&n| weight as f32 * Vec3::from(n))
                });
                *normal = sum.sum::<Vec3>().try_normalize().map_or(*normal, Vec3::into);
            }
        }
        if let Some(normals) = &mut model.corner_normals {
            settle_normals(normals.as_chunks_mut().0, result, self.rules.crease_angle);
        }
        Ok(model)
    }

    fn blend(
        &self,
        loaded: Source<'_>,
        sources: &HalfEdgeMap<Option<CornerSource>>,
        h: HalfEdgeId,
    ) -> Blend {
        let Some(CornerSource { face, weights }) = sources[h] else { return Blend::one(0) };
        let corners = loaded.mesh.topology().face_half_edges(face);
        Blend { sources: corners.map(|h| as_u32(self.seams.corner(h))), weights }
    }
}

/// Where the data of a simplified mesh come from, in elements of the model.
#[derive(Clone, Debug)]
pub(crate) struct Sources {
    /// For each vertex, vertices of the model.
    pub(crate) vertices: Vec<Blend>,
    /// For each face, a face of the model.
    pub(crate) faces: Vec<u32>,
    /// For the corners of each face, corners of the model in one chart.
    pub(crate) corners: Vec<[Blend; 3]>,
    /// For the corners of each face, the corners of the model at the closest point, in any chart.
    pub(crate) points: Vec<[Blend; 3]>,
}

/// Normals whose components differ by less are equal.
const SAME_NORMAL: f32 = 1e-3;

/// The smallest cosine between the normal of a face and a normal of the file that stands for it: 3°.
const OF_FACE: f64 = 0.9986;

/// Whether nearly every face has one normal at its three corners, or about its own normal at each of them, and few edges
/// have equal normals on both sides.
fn is_flat_shaded(mesh: &TriMesh, seams: &Seams, normals: &[[f32; 3]]) -> bool {
    let topology = mesh.topology();
    let normal = |h: HalfEdgeId| Vec3::from(normals[seams.corner(h)]);
    let same = |a, b| normal(a).abs_diff_eq(normal(b), SAME_NORMAL);
    let is_uniform = |&f: &_| {
        let [a, b, c] = topology.face_half_edges(f);
        let own = mesh.face_normal(f);
        let is_own = |h| normal(h).as_dvec3().normalize_or_zero().dot(own) > OF_FACE;
        (same(a, b) && same(b, c)) || [a, b, c].into_iter().all(is_own)
    };
    let inner = topology.edges().filter(|&e| !topology.is_boundary_edge(e));
    let is_smooth = |h: HalfEdgeId| same(h, topology.next(h.twin()));
    let (faces, edges) = (topology.face_count(), inner.clone().count());
    let uniform = topology.faces().filter(is_uniform).count();
    let smooth = inner.filter(|e| is_smooth(e.half_edge())).count();
    uniform * 100 > faces * 98 && smooth * 2 < edges
}

/// Cost of a normal that turns by one radian, and of a colour change from black to white, as a share of the
/// diagonal of the bounding box.
const PART_OF_DIAGONAL: f64 = 0.01;

/// The attributes of the corners, scaled to model units and weighted; `None` if all weights are zero.
fn corner_attributes(
    source: Source<'_>,
    seams: &Seams,
    rules: &AttributeRules,
    with_normals: bool,
) -> Result<Option<CornerAttributes>, SimplifyError> {
    let Source { model, mesh, .. } = source;
    let counts = |weight: f64| weight > 0.0;
    let uvs = model.corner_uvs.as_ref().filter(|_| counts(rules.attribute_weight));
    let colors = model.vertex_colors.as_ref().filter(|_| counts(rules.attribute_weight));
    let corner_normals =
        model.corner_normals.as_ref().filter(|_| with_normals && counts(rules.normal_weight));
    let vertex_normals = model.vertex_normals.as_ref().filter(|_| counts(rules.normal_weight));
    let has_normals = corner_normals.is_some() || vertex_normals.is_some();
    if uvs.is_none() && colors.is_none() && !has_normals {
        return Ok(None);
    }
    let part = PART_OF_DIAGONAL * mesh.bounding_box().map_or(0.0, |b| b.diagonal());
    let texture = rules.attribute_weight * uvs.map_or(0.0, |uvs| texture_scale(mesh, seams, uvs));
    let (color, normal) = (rules.attribute_weight * part, rules.normal_weight * part);
    let of_corner = |h: HalfEdgeId| {
        let corner = seams.corner(h);
        let vertex = model.soup.corners()[corner] as usize;
        let [u, v] = uvs.map_or([0.0; 2], |all| all[corner]);
        let by_vertex = vertex_normals.map_or([0.0; 3], |all| all[vertex]);
        let [x, y, z] = corner_normals.map_or(by_vertex, |all| all[corner]);
        let [r, g, b, a] = colors.map_or([0.0; 4], |all| all[vertex]);
        let [u, v] = [u, v].map(|t| f64::from(t) * texture);
        let [x, y, z] = [x, y, z].map(|n| f64::from(n) * normal);
        let [r, g, b, a] = [r, g, b, a].map(|c| f64::from(c) * color);
        [u, v, x, y, z, r, g, b, a]
    };
    CornerAttributes::new(mesh, uvs.is_some(), of_corner).map(Some).map_err(SimplifyError::from)
}

/// Model units per texture unit: the square root of the ratio of surface area to texture area.
fn texture_scale(mesh: &TriMesh, seams: &Seams, uvs: &[[f32; 2]]) -> f64 {
    if let Ok(Some(scale)) = UnitScale::of(mesh)
        && let Ok(scaled) = scale.mesh(mesh)
    {
        return scale.original_length(texture_scale(&scaled, seams, uvs));
    }
    let topology = mesh.topology();
    let area = |face| {
        let corners = topology.face_half_edges(face).map(|h| uvs[seams.corner(h)].map(f64::from));
        let [a, b, c] = corners.map(|[u, v]| DVec3::new(u, v, 0.0));
        0.5 * (b - a).cross(c - a).length()
    };
    let total: f64 = topology.faces().map(area).filter(|area| area.is_finite()).sum();
    if total > 0.0 { (mesh.area() / total).sqrt() } else { 0.0 }
}

//! A mesh on a page, with all its data.

use glam::DVec3;
use mesh_core::build::Triangulator;
use mesh_core::{PolygonSoup, TriMesh, VertexMap, as_u32};
use mesh_io::{Alpha, Model, Picture, PictureError, Pictures, Scalars, color_in_bytes};

use crate::error::ViewError;
use crate::text::grouped;

/// A mesh on a page: triangles, not necessarily a manifold, and data for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exhibit {
    /// The name above the picture.
    pub name: String,
    /// The positions of the vertices. Vertices without triangles may have non-finite positions.
    pub positions: Vec<DVec3>,
    /// The triangles.
    pub triangles: Vec<[u32; 3]>,
    /// For every triangle, the number of its original face; `None` if it is the index of the triangle.
    pub face_numbers: Option<Vec<u32>>,
    /// Numbers that can be shown as colours.
    pub fields: Vec<Field>,
    /// Colours of the vertices: red, green, blue, opacity (the opacity is ignored).
    pub vertex_colors: Option<Vec<[u8; 4]>>,
    /// Colours of the triangles.
    pub face_colors: Option<Vec<[u8; 4]>>,
    /// Materials and textures.
    pub materials: Option<Materials>,
    /// Lines and dots on the mesh.
    pub lines: Vec<Lines>,
    /// Directions at the vertices.
    pub directions: Vec<Directions>,
    /// Facts for the side panel: names and values.
    pub facts: Vec<(String, String)>,
    /// For a level of detail: the share of the screen height from which on it is shown.
    pub coverage: Option<f64>,
    /// Whether it is a part of another mesh on the page: it is shown alone, never beside others.
    pub is_part: bool,
}

/// The elements that the values of a field belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum On {
    /// One value per vertex.
    #[default]
    Vertices,
    /// One value per triangle.
    Faces,
}

/// Named numbers. Fields of several meshes with the same name share one colour scale.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// The name of the quantity.
    pub name: String,
    /// The unit of the values, for the legend; empty for none.
    pub unit: String,
    /// The elements that the values belong to.
    pub on: On,
    /// The values; non-finite values have no colour.
    pub values: Vec<f64>,
    /// Whether the initial colour range is symmetric about zero.
    pub signed: bool,
    /// The initial range of the colours; `None` for the 2nd and 98th percentile.
    pub range: Option<[f64; 2]>,
    /// Whether the values are labels: each different value has a colour of its own, and nothing is blended.
    pub is_label: bool,
}

impl Field {
    /// A field, signed if it has values on both sides of zero.
    #[must_use]
    pub fn new(name: impl Into<String>, on: On, values: Vec<f64>) -> Self {
        let has = |test: fn(f64) -> bool| values.iter().any(|&x| x.is_finite() && test(x));
        let signed = has(|x| x < 0.0) && has(|x| x > 0.0);
        Self { name: name.into(), on, values, signed, ..Self::default() }
    }

    /// A field of labels, which are whole numbers. If a value has a fraction or is beyond 2^31, it is a field of
    /// amounts, because a page cannot tell such numbers apart.
    #[must_use]
    pub fn labels(name: impl Into<String>, on: On, values: Vec<f64>) -> Self {
        const LARGEST: f64 = 2_147_483_648.0;
        let is_whole = |x: &f64| !x.is_finite() || (x.fract() == 0.0 && x.abs() <= LARGEST);
        let is_label = values.iter().all(is_whole);
        Self { is_label, ..Self::new(name, on, values) }
    }

    /// The key of the field in [`crate::Start::color`].
    #[must_use]
    pub fn key(&self) -> String {
        let on = match self.on {
            On::Vertices => "vertex",
            On::Faces => "face",
        };
        format!("{on}:{}", crate::text::visible(&self.name))
    }
}

/// Straight lines in model units; lines of length zero are dots.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// Their name on the page.
    pub name: String,
    /// Their colour.
    pub color: [u8; 3],
    /// Their width, or the diameter of dots, in pixels.
    pub width: f64,
    /// Their ends.
    pub segments: Vec<[DVec3; 2]>,
    /// Whether they are visible at first.
    pub shown: bool,
}

impl Lines {
    /// Lines through points, visible at first.
    #[must_use]
    pub fn through(name: impl Into<String>, color: [u8; 3], points: &[DVec3]) -> Self {
        let segments = points.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        Self { name: name.into(), color, width: 2.5, segments, shown: true }
    }

    /// Dots, visible at first.
    #[must_use]
    pub fn dots(name: impl Into<String>, color: [u8; 3], points: &[DVec3]) -> Self {
        let segments = points.iter().map(|&p| [p, p]).collect();
        Self { name: name.into(), color, width: 11.0, segments, shown: true }
    }
}

/// An undirected line element at every vertex, drawn as a short line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directions {
    /// Their name on the page.
    pub name: String,
    /// Their colour.
    pub color: [u8; 3],
    /// The direction of each vertex, if it has one.
    pub vectors: Vec<Option<DVec3>>,
    /// Whether they are visible at first.
    pub shown: bool,
}

/// The appearance of the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// The materials.
    pub surfaces: Vec<Surface>,
    /// The material of every triangle, an index into `surfaces`.
    pub of_face: Vec<u32>,
    /// Texture coordinates of the corners of every triangle; the origin is at the lower left.
    pub uvs: Option<Vec<[[f32; 2]; 3]>>,
    /// The pictures.
    pub pictures: Vec<Picture>,
    /// The names of the pictures that were left out, with the reasons.
    pub left_out: Vec<(String, PictureError)>,
}

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its name, or empty.
    pub name: String,
    /// Red, green, blue (as light) and opacity, multiplied with the picture.
    pub color: [f32; 4],
    /// The picture, an index into [`Materials::pictures`].
    pub picture: Option<u32>,
    /// From 0 (dielectric) to 1 (metal).
    pub metallic: f32,
    /// From 0 (mirror) to 1 (matt).
    pub roughness: f32,
    /// The meaning of the opacity.
    pub alpha: Alpha,
}

impl Default for Surface {
    fn default() -> Self {
        let color = [0.6, 0.6, 0.58, 1.0];
        Self {
            name: String::new(),
            color,
            picture: None,
            metallic: 0.0,
            roughness: 1.0,
            alpha: Alpha::Opaque,
        }
    }
}

impl Exhibit {
    /// The key of the colours of components in [`crate::Start::color`].
    pub const COMPONENTS: &'static str = "face:component";

    /// Whether a page offers colours of components: the mesh has several.
    #[must_use]
    pub fn has_components(&self) -> bool {
        let is_several = |count: &str| !["0", "1"].contains(&count);
        self.facts.iter().any(|(name, count)| name == "components" && is_several(count))
    }

    /// A mesh without further data, with its counts as facts.
    #[must_use]
    pub fn of_mesh(name: impl Into<String>, mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let boundary = topology.edges().filter(|&e| topology.is_boundary_edge(e)).count();
        let counts = [
            ("vertices", grouped(topology.vertex_count())),
            ("faces", grouped(topology.face_count())),
            ("edges", grouped(topology.edge_count())),
            ("boundary edges", grouped(boundary)),
            ("components", grouped(topology.components().count)),
            ("Euler characteristic", topology.euler_characteristic().to_string()),
        ];
        Self {
            name: name.into(),
            positions: mesh.positions().to_vec(),
            triangles: topology.triangles().collect(),
            facts: counts.map(|(name, value)| (name.to_owned(), value)).into(),
            ..Self::default()
        }
    }

    /// Adds values of the vertices.
    #[must_use]
    pub fn with_vertex_values(mut self, name: impl Into<String>, values: &VertexMap<f64>) -> Self {
        self.fields.push(Field::new(name, On::Vertices, values.as_slice().to_vec()));
        self
    }

    /// The content of a file, without repairs: every property as a field, colours, materials.
    ///
    /// Faces with a non-finite vertex position are left out. A material whose picture was left out is shown without it.
    ///
    /// # Errors
    /// The model is inconsistent.
    pub fn of_model(
        name: impl Into<String>,
        model: &Model,
        pictures: Pictures,
    ) -> Result<Self, ViewError> {
        let name = name.into();
        model.check().map_err(|source| ViewError::Model { name: name.clone(), source })?;
        let parts = cut(&model.soup);
        let of_faces = |values: &[f64]| parts.face.iter().map(|&f| values[f as usize]).collect();
        let mut fields: Vec<Field> = Vec::new();
        let field = |scalars: &Scalars, on, values| match scalars.is_label {
            true => Field::labels(&scalars.name, on, values),
            false => Field::new(&scalars.name, on, values),
        };
        for scalars in &model.vertex_scalars {
            fields.push(field(scalars, On::Vertices, scalars.values.to_f64().into_owned()));
        }
        for scalars in &model.face_scalars {
            fields.push(field(scalars, On::Faces, of_faces(&scalars.values.to_f64())));
        }
        let face_colors = model.face_colors.as_ref();
        let is_cut = parts.face.len() != model.soup.face_count();
        let materials = materials(model, &parts, pictures);
        Ok(Self {
            name,
            positions: model.soup.positions().to_vec(),
            facts: facts(&model.soup),
            fields,
            vertex_colors: model
                .vertex_colors
                .as_ref()
                .map(|c| c.iter().map(color_in_bytes).collect()),
            face_colors: face_colors
                .map(|c| parts.face.iter().map(|&f| color_in_bytes(&c[f as usize])).collect()),
            materials,
            triangles: parts.triangles,
            face_numbers: is_cut.then_some(parts.face),
            ..Self::default()
        })
    }
}

/// The polygons of a soup as triangles.
struct Cut {
    triangles: Vec<[u32; 3]>,
    /// The original face of each triangle, and its corners in the soup.
    face: Vec<u32>,
    corners: Vec<[u32; 3]>,
}

fn cut(soup: &PolygonSoup) -> Cut {
    let mut cut = Cut { triangles: Vec::new(), face: Vec::new(), corners: Vec::new() };
    let mut triangulator = Triangulator::default();
    let (mut local, mut places) = (Vec::new(), Vec::new());
    for (face, vertices) in soup.faces().enumerate() {
        places.clear();
        places.extend(vertices.iter().map(|&v| soup.positions()[v as usize]));
        if !places.iter().all(|p| p.is_finite()) {
            continue;
        }
        local.clear();
        triangulator.triangulate(&places, vertices, &mut local);
        let first = as_u32(soup.corner_range(face).start);
        for &corners in &local {
            cut.triangles.push(corners.map(|c| vertices[c as usize]));
            cut.face.push(as_u32(face));
            cut.corners.push(corners.map(|c| first + c));
        }
    }
    cut
}

/// The facts about a file for the side panel.
fn facts(soup: &PolygonSoup) -> Vec<(String, String)> {
    let Ok(diagnosis) = mesh_core::diagnose(soup) else {
        let counts = [("vertices", soup.vertex_count()), ("faces", soup.face_count())];
        return counts.map(|(name, count)| (name.to_owned(), grouped(count))).into();
    };
    let counts = [
        ("vertices", diagnosis.vertices),
        ("faces", soup.face_count()),
        ("triangles", diagnosis.faces),
        ("edges", diagnosis.edges),
        ("boundary edges", diagnosis.boundary_edges),
        ("boundary loops", diagnosis.boundary_loops),
        ("components", diagnosis.components),
        ("non-manifold edges", diagnosis.non_manifold_edges),
        ("non-manifold vertices", diagnosis.non_manifold_vertices),
        ("inconsistent edges", diagnosis.inconsistent_edges),
        ("degenerate faces", diagnosis.degenerate_faces()),
        ("duplicate faces", diagnosis.duplicate_faces),
        ("slivers", diagnosis.slivers),
    ];
    let mut facts: Vec<_> =
        counts.into_iter().map(|(name, count)| (name.to_owned(), grouped(count))).collect();
    facts.push(("Euler characteristic".into(), diagnosis.euler_characteristic.to_string()));
    facts
}

fn materials(model: &Model, parts: &Cut, pictures: Pictures) -> Option<Materials> {
    let ids = model.face_materials.as_ref().filter(|_| !model.materials.is_empty())?;
    let mut surfaces: Vec<Surface> = model
        .materials
        .iter()
        .map(|m| Surface {
            name: m.name.clone(),
            color: m.base_color,
            picture: m.base_color_image.and_then(|image| pictures.of_image(image)),
            metallic: m.metallic,
            roughness: m.roughness,
            alpha: m.alpha,
        })
        .collect();
    let none = as_u32(surfaces.len());
    surfaces.push(Surface::default());
    let of_face = parts.face.iter().map(|&f| ids[f as usize].min(none)).collect();
    let uvs = model.corner_uvs.as_ref().map(|uvs| {
        let uv = |corner: u32| uvs[corner as usize].map(|x| if x.is_finite() { x } else { 0.0 });
        parts.corners.iter().map(|corners| corners.map(uv)).collect()
    });
    let Pictures { pictures, left_out, .. } = pictures;
    Some(Materials { surfaces, of_face, uvs, pictures, left_out })
}

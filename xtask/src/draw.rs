//! `cargo xtask render`: a mesh file to a picture.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mesh_core::build::{Provenance, Repair, build};
use mesh_core::{TriMesh, VertexMap};
use mesh_io::Model;
use mesh_render::{Paint, Picture, Scene, Style, Texture, View, render};

use crate::failure::Failure;

/// What to draw, and from where.
#[derive(Debug, clap::Args)]
pub(crate) struct Draw {
    /// The mesh: OBJ, PLY, STL, OFF, glTF or GLB
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The picture, a PNG file
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// The direction from the model to the camera
    #[arg(long, value_name = "X,Y,Z", default_value = "0.4,0.3,1", value_parser = parse_vector, allow_hyphen_values = true)]
    from: DVec3,
    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", default_value = "0,1,0", value_parser = parse_vector, allow_hyphen_values = true)]
    up: DVec3,
    /// Width and height in pixels
    #[arg(long, value_name = "W,H", default_value = "900,900", value_delimiter = ',')]
    size: Vec<u32>,
    /// Width of the edges in pixels; 0 draws none
    #[arg(long, value_name = "PIXELS", default_value_t = 0.0)]
    edges: f64,
    /// Shade with one normal per vertex, so that the surface looks smooth
    #[arg(long)]
    smooth: bool,
    /// Show texture coordinates by a chessboard of so many squares, instead of the file's pictures
    #[arg(long, value_name = "SQUARES")]
    chessboard: Option<u32>,
}

pub(crate) fn run(options: &Draw) -> Result<(), Failure> {
    let model = mesh_io::read(&options.input).map_err(Failure::reading(&options.input))?;
    let built = build(&model.soup, &Repair::lenient()).map_err(Failure::mesh)?;
    let colors = vertex_colors(&model, &built.provenance.vertex_source);
    let texture = texture(&model, &built.provenance, options)?;
    let paint = match (&colors, &texture) {
        (Some(colors), _) => Paint::Vertices(colors),
        (None, Some(texture)) => Paint::Texture(texture),
        (None, None) => Paint::Clay,
    };
    let picture = draw(&built.mesh, paint, options)?;
    std::fs::write(&options.output, picture.to_png().map_err(Failure::render)?)
        .map_err(Failure::writing(&options.output))
}

/// The materials of the file, or a chessboard on its texture coordinates.
fn texture(
    model: &Model,
    provenance: &Provenance,
    options: &Draw,
) -> Result<Option<Texture>, Failure> {
    let Provenance { face_source, corner_source, .. } = provenance;
    if let Some(squares) = options.chessboard {
        let Some(uvs) = &model.corner_uvs else { return Ok(None) };
        let of_face = |corners: &[u32; 3]| corners.map(|c| uvs[c as usize]);
        return Ok(Some(Texture::chessboard(squares, corner_source.iter().map(of_face))));
    }
    let folder = options.input.parent().unwrap_or(Path::new(""));
    let load = |uri: &str| std::fs::read(folder.join(uri)).ok();
    Texture::of_model(model, face_source, corner_source, load).map_err(Failure::render)
}

fn draw(mesh: &TriMesh, paint: Paint<'_>, options: &Draw) -> Result<Picture, Failure> {
    let &[width, height] = &options.size[..] else {
        return Err(Failure::Usage("--size takes a width and a height, like 900,600".into()));
    };
    let view = View::of(mesh, options.from, options.up)
        .ok_or(Failure::Usage("the mesh has no faces".into()))?;
    let style = Style {
        size: [width, height],
        smooth: options.smooth,
        edge_width: options.edges,
        ..Style::DEFAULT
    };
    render(&Scene { paint, ..Scene::of(mesh) }, &view, &style).map_err(Failure::render)
}

/// The colours of the file, for the vertices of the built mesh.
fn vertex_colors(model: &Model, sources: &[u32]) -> Option<VertexMap<[u8; 3]>> {
    let colors = model.vertex_colors.as_ref()?;
    let eight_bit = |c: f32| (255.0 * c.clamp(0.0, 1.0)).round() as u8;
    let of_source = |&source: &u32| {
        let [red, green, blue, _] = colors.get(source as usize).copied().unwrap_or([1.0; 4]);
        [red, green, blue].map(eight_bit)
    };
    Some(VertexMap::from_vec(sources.iter().map(of_source).collect()))
}

/// Reads `x,y,z`.
fn parse_vector(text: &str) -> Result<DVec3, String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse().map_err(|_| format!("{part:?} is not a number")))
        .collect::<Result<_, _>>()?;
    match parts[..] {
        [x, y, z]
            if x.is_finite() && y.is_finite() && z.is_finite() && (x, y, z) != (0.0, 0.0, 0.0) =>
        {
            Ok(DVec3::new(x, y, z))
        }
        _ => Err("a direction has three numbers, like 0,0.5,1, not all zero".into()),
    }
}

//! `curvmesh render`: a picture of a mesh, without a display.

use std::path::PathBuf;

use clap::ValueEnum;
use glam::DVec3;
use mesh_core::TriMesh;
use mesh_io::{PictureOptions, Pictures};
use mesh_render::{
    Drawing, Legend, Painting, Picture, RenderError, Scene, SheetOptions, Side, Style, Texture,
    View, draw_svg, render, sheet,
};
use mesh_view::{Sight, Toward, Up, Upright};
use mesh_work::{Loaded, legend_title};
use serde::Serialize;

use crate::args::{parse_angle, parse_index, parse_not_negative, parse_picture, parse_whole};
use crate::colormap::{COLOR_OPTIONS, ColorOptions};
use crate::commands::view::parse_up;
use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::{Seconds, tell_crowded_mesh};
use crate::save::save_bytes;
use crate::session::{Outcome, Session};
use crate::task::{Report, Source};
use crate::view::{say_left_out, up_of};

/// Draw a mesh to a PNG or SVG file, without a display
///
/// An output that ends in .svg is made of vectors, for figures of papers: the faces that are seen, each in the colour
/// of its middle, edges, outlines and the legend, without a background. Faces are drawn from the farthest to the
/// nearest; if faces pass through each other, the order can be wrong.
///
///     curvmesh render torus.ply -o torus.png --edges 1 --direction 1,0.3,1
///     curvmesh render scan.ply -o curved.png --property mean_curvature --range=-2,2 --smooth
///     curvmesh render part.stl -o sides.png --direction front,left,top --outlines 2 --transparent
///     curvmesh render cover.ply -o figure.svg --property patch --edges 0.5
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Render {
    #[command(flatten)]
    source: Source,
    /// The picture, a PNG or SVG file; `-` is the standard output, as PNG
    #[arg(short, long, value_name = "OUT.png|OUT.svg", value_parser = parse_picture())]
    output: PathBuf,
    /// Direction from the model to the camera: x,y,z, or names such as front, back, left, right, top,
    /// bottom, corner; several names draw several views in one picture
    #[arg(long, value_name = "X,Y,Z|SIDES", default_value = "0.4,0.3,1", value_parser = parse_directions, allow_hyphen_values = true)]
    direction: Directions,
    /// The direction of the model that is up in the picture: x, y, z, -x, -y, -z, auto or three numbers. `auto` finds
    /// it as `view` does. Sides turn with it, and so does the usual --direction
    #[arg(long, value_name = "AXIS", default_value = "auto", value_parser = parse_upright, allow_hyphen_values = true)]
    up: UpRule,
    /// Width and height of each view in pixels
    #[arg(long, value_name = "W,H", default_value = "900,900", value_parser = parse_size)]
    size: [u32; 2],
    /// Width of the edges in pixels; 0 draws none
    #[arg(long, value_name = "PIXELS", default_value_t = 0.0, value_parser = parse_not_negative)]
    edges: f64,
    /// Width of the outlines in pixels; 0 draws none
    #[arg(long, value_name = "PIXELS", default_value_t = 0.0, value_parser = parse_not_negative)]
    outlines: f64,
    /// With --outlines, also draw edges with a larger dihedral angle than this
    #[arg(long, value_name = "DEGREES", value_parser = parse_angle)]
    crease: Option<f64>,
    /// Shade with one normal per vertex, so that the surface looks smooth
    #[arg(long)]
    smooth: bool,
    /// What the surface is painted with
    #[arg(long, value_enum, default_value_t)]
    paint: PaintName,
    /// Show a property of vertices or faces as colours, with a legend. Integers are labels: each has a colour of
    /// its own, unless --colormap, --range or --log is given
    #[arg(long, value_name = "NAME", conflicts_with = "paint")]
    property: Option<String>,
    /// Show texture coordinates by a chessboard with this many squares along each side of the texture
    #[arg(long, value_name = "SQUARES", conflicts_with_all = ["paint", "property"], value_parser = parse_index::<u32>)]
    chessboard: Option<u32>,
    /// Use a logarithmic scale of colours: equal steps of colour are equal ratios
    #[arg(long)]
    log: bool,
    /// Darken cavities and creases (ambient occlusion): the strength, from 0 to 1
    #[arg(long, value_name = "STRENGTH", default_value_t = 0.0, value_parser = parse_strength)]
    occlusion: f64,
    /// Leave out the legend
    #[arg(long)]
    no_bar: bool,
    /// Leave the picture transparent where there is no mesh, as in all SVG files
    #[arg(long)]
    transparent: bool,
    /// Samples per pixel and direction, from 1 to 8
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = |text: &str| parse_whole::<u32>(text, 1..=8))]
    supersampling: u32,
    #[command(flatten)]
    colors: ColorOptions,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum PaintName {
    /// Colours of vertices or faces, or else materials, if the file has them
    #[default]
    Auto,
    /// Colours of vertices or faces
    Colors,
    /// Materials and textures
    Materials,
    /// A colour for each component, with a legend
    Components,
    /// Light grey
    Plain,
}

/// Where from.
#[derive(Clone, Debug)]
enum Directions {
    Vector(DVec3),
    Sides(Vec<Side>),
}

/// What is up. `None` stands for what the format, the shape and the place of the mesh say.
type UpRule = Option<Upright>;

#[derive(Serialize)]
struct Results {
    width: u32,
    height: u32,
    views: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<[f64; 2]>,
    /// The number of different labels.
    #[serde(skip_serializing_if = "Option::is_none")]
    labels: Option<usize>,
    /// The number of faces in an SVG file.
    #[serde(skip_serializing_if = "Option::is_none")]
    drawn_faces: Option<usize>,
}

/// A picture of either kind.
enum Drawn {
    Pixels(Picture),
    Vectors(Drawing),
}

pub(crate) fn run(options: &Render, session: &Session) -> Result<Outcome, Failure> {
    options.check_given(&session.given)?;
    let console = &*session.console.beside(Some(&options.output))?;
    let mut seconds = Seconds::default();
    let Source { input, loading } = &options.source;
    let loaded = Seconds::time(&mut seconds.load, || loading.load(input, console))?;
    tell_crowded_mesh(input, &loaded.mesh, console);
    let made = options.made(&loaded, &session.given, console)?;
    let sights = options.sights(&loaded.mesh, &session.given);
    let drawn = Seconds::time(&mut seconds.compute, || options.draw(&loaded, &made, &sights))?;
    Seconds::time(&mut seconds.save, || match &drawn {
        Drawn::Pixels(picture) => save_bytes(&options.output, &picture.to_png().map_err(failed)?),
        Drawn::Vectors(drawing) => save_bytes(&options.output, drawing.svg.as_bytes()),
    })?;
    let range = made.legend().and_then(Legend::scale).map(|scale| [scale.low, scale.high]);
    let labels = match made.legend() {
        Some(Legend::Labels(labels)) => Some(labels.values().len()),
        _ => None,
    };
    let ([width, height], drawn_faces) = match &drawn {
        Drawn::Pixels(picture) => ([picture.width(), picture.height()], None),
        Drawn::Vectors(drawing) => (drawing.size, Some(drawing.faces)),
    };
    let results = Results { width, height, views: sights.len(), range, labels, drawn_faces };
    let report =
        Report::new(console, input, loaded.counts(), results, seconds).with_output(&options.output);
    let text = format!("{}: {width} by {height} pixels", report.subject());
    report.done(console, text, String::new())?.print(console)?;
    Ok(Outcome::Done)
}

fn failed(error: RenderError) -> Failure {
    match error {
        RenderError::Size { .. } | RenderError::Supersampling(_) | RenderError::Measure { .. } => {
            Failure::usage(error)
        }
        other => Failure::refused(other),
    }
}

impl Render {
    /// Refuses options without effect.
    fn check_given(&self, given: &Given) -> Result<(), Failure> {
        if self.property.is_none() {
            given.refuse(&COLOR_OPTIONS, "they are for --property")?;
            given.refuse(&["log"], "it is for --property")?;
        }
        if self.property.is_none() && self.paint != PaintName::Components {
            given.refuse(&["no_bar"], "it is for --property and --paint components")?;
        }
        if self.outlines == 0.0 {
            given.refuse(&["crease"], "it is for --outlines")?;
        }
        if self.is_vectors() {
            given.refuse(&["occlusion"], "an SVG file has flat colours; write PNG")?;
        }
        if let (Directions::Sides(_), Some(Upright::Vector(_))) = (&self.direction, &self.up) {
            given.refuse(&["up"], "sides turn with an axis; say x, y, z, -x, -y, -z or auto")?;
        }
        Ok(())
    }

    fn made(&self, loaded: &Loaded, given: &Given, console: &Console) -> Result<Painting, Failure> {
        let (model, provenance) = (&loaded.model, &loaded.provenance);
        if let Some(squares) = self.chessboard {
            return Painting::chessboard(model, provenance, squares)
                .ok_or_else(|| Failure::refused("the file has no texture coordinates"));
        }
        if let Some(name) = &self.property {
            // Who names a scale of colours wants amounts.
            let is_scaled = ["colormap", "range", "log"].iter().any(|name| given.has(name));
            return self.property_colors(name, loaded, is_scaled);
        }
        let pictures = || {
            let Source { input, loading } = &self.source;
            let formats = Texture::FORMATS;
            let options = PictureOptions { formats, are_decoded: true, ..loading.pictures(input) };
            let pictures = Pictures::of_model(model, &options);
            say_left_out(&pictures.left_out, console);
            pictures
        };
        match self.paint {
            PaintName::Auto => Painting::of_content(model, provenance, pictures).map_err(failed),
            PaintName::Colors => Painting::of_colors(model, provenance)
                .ok_or_else(|| Failure::refused("the file has no colours")),
            PaintName::Materials => Painting::of_materials(model, provenance, &pictures())
                .map_err(failed)?
                .ok_or_else(|| Failure::refused("the file has no materials")),
            PaintName::Components => Ok(Painting::of_components(&loaded.mesh)),
            PaintName::Plain => Ok(Painting::Plain),
        }
    }

    fn property_colors(
        &self,
        name: &str,
        loaded: &Loaded,
        is_scaled: bool,
    ) -> Result<Painting, Failure> {
        let (model, provenance) = (&loaded.model, &loaded.provenance);
        let options = self.colors.options(false, self.log);
        if let Some(found) = model.vertex_scalars.iter().find(|s| s.name == name) {
            let values = found.values.to_f64();
            return Ok(match found.is_label && !is_scaled {
                true => Painting::of_vertex_labels(provenance, &values),
                false => Painting::of_vertex_values(provenance, &values, options),
            });
        }
        if let Some(found) = model.face_scalars.iter().find(|s| s.name == name) {
            let values = found.values.to_f64();
            return Ok(match found.is_label && !is_scaled {
                true => Painting::of_face_labels(provenance, &values),
                false => Painting::of_face_values(provenance, &values, options),
            });
        }
        let names = model.vertex_scalars.iter().chain(&model.face_scalars).map(|s| &*s.name);
        let names = names.collect::<Vec<_>>().join(", ");
        let names = if names.is_empty() { "none".into() } else { names };
        Err(Failure::usage(format!("there is no property {name}; there are: {names}")))
    }

    /// Whether the picture is made of vectors.
    fn is_vectors(&self) -> bool {
        self.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"))
    }

    /// Where from.
    fn sights(&self, mesh: &TriMesh, given: &Given) -> Vec<Sight> {
        let of_shape = || {
            let triangles = mesh.topology().triangles().collect::<Vec<_>>();
            Up::of_shape(mesh.positions(), &triangles)
        };
        let up = self.up.unwrap_or_else(|| Upright::Axis(up_of(&self.source.input, of_shape)));
        let toward = match &self.direction {
            Directions::Vector(toward) if given.has("direction") => Toward::Given(*toward),
            Directions::Vector(_) => Toward::Usual,
            Directions::Sides(sides) => Toward::Sides(sides.clone()),
        };
        toward.sights(up)
    }

    fn draw(&self, loaded: &Loaded, made: &Painting, sights: &[Sight]) -> Result<Drawn, Failure> {
        let mesh = &loaded.mesh;
        let is_transparent = self.transparent || self.is_vectors();
        let background = (!is_transparent).then_some([255; 3]);
        let style = Style {
            size: self.size,
            smooth: self.smooth,
            edge_width: self.edges,
            silhouette_width: self.outlines,
            crease: self.crease,
            background,
            supersampling: self.supersampling,
            occlusion: self.occlusion,
            ..Style::default()
        };
        let scene = Scene { paint: made.paint(), ..Scene::of(mesh) };
        let nothing = || Failure::refused("the mesh has no faces");
        let name = self.property.as_deref().map_or("component".into(), legend_title);
        let legend = made.legend().filter(|_| !self.no_bar);
        let view = |sight: &Sight| View::of(mesh, sight.toward, sight.up).ok_or_else(nothing);
        if self.is_vectors() {
            let [sight] = sights else {
                let message = "an SVG file has one view; name one side, or write PNG";
                return Err(Failure::usage(message));
            };
            let legend = legend.map(|legend| (legend, &*name));
            let drawing = draw_svg(&scene, &view(sight)?, &style, legend);
            return Ok(Drawn::Vectors(drawing.map_err(failed)?));
        }
        let from = |sight: &Sight| -> Result<Picture, Failure> {
            render(&scene, &view(sight)?, &style).map_err(failed)
        };
        let picture = match (&self.direction, sights) {
            (Directions::Vector(_), [sight]) => from(sight)?,
            _ => {
                let view = |sight: &Sight| Ok((from(sight)?, sight.name.to_owned()));
                let views = sights.iter().map(view).collect::<Result<Vec<_>, Failure>>()?;
                sheet(&views, &SheetOptions { background, ..Default::default() }).map_err(failed)?
            }
        };
        let picture = match legend {
            Some(legend) => legend.beside(&picture, &name, background).map_err(failed)?,
            None => picture,
        };
        Ok(Drawn::Pixels(picture))
    }
}

/// Reads `x,y,z`, or names of sides.
fn parse_directions(text: &str) -> Result<Directions, String> {
    let side = |name: &str| Side::ALL.iter().copied().find(|side| side.name() == name.trim());
    if let Some(sides) = text.split(',').map(side).collect::<Option<Vec<_>>>() {
        return Ok(Directions::Sides(sides));
    }
    parse_vector(text).map(Directions::Vector)
}

/// Reads the name of an axis, `auto`, or `x,y,z`.
fn parse_upright(text: &str) -> Result<UpRule, String> {
    match parse_up(text) {
        Ok(axis) => Ok(axis.map(Upright::Axis)),
        Err(named) => parse_vector(text)
            .map(|up| Some(Upright::Vector(up)))
            .map_err(|_| format!("{named}, or three numbers, like 0,0.5,1, not all zero")),
    }
}

/// Reads `x,y,z`.
fn parse_vector(text: &str) -> Result<DVec3, String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse().map_err(|_| format!("{part:?} is not a number")))
        .collect::<Result<_, _>>()?;
    match parts[..] {
        [x, y, z] if DVec3::new(x, y, z).is_finite() && DVec3::new(x, y, z) != DVec3::ZERO => {
            Ok(DVec3::new(x, y, z))
        }
        _ => Err("a direction has three numbers, like 0,0.5,1, not all zero".into()),
    }
}

/// Reads a number from 0 to 1.
fn parse_strength(text: &str) -> Result<f64, String> {
    let strength = text.trim().parse().ok().filter(|strength| (0.0..=1.0).contains(strength));
    strength.ok_or_else(|| "expected a number from 0 to 1".into())
}

/// Reads `width,height`.
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once([',', 'x']).and_then(|(width, height)| {
        Some([width.trim().parse().ok()?, height.trim().parse().ok()?])
    });
    sides.ok_or_else(|| "expected a width and a height in pixels, like 900,600".into())
}

//! What an item has at hand while it is computed: the models, and the folder for its pictures.

use std::path::{Path, PathBuf};

use mesh_core::{PolygonSoup, Repair, TriMesh, build};
use mesh_io::{Model, WriteOptions};

use super::item::{Figure, Item};
use mesh_render::{Paint, Scene, Style, View, render};
use mesh_view::{Exhibit, Lines, Page};
use xtask_common::Failure;

/// The surroundings of an item.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run<'a> {
    /// The folder for the page, the pictures and the meshes.
    pub(crate) out: &'a Path,
    /// The folder of the real models, if there is one.
    pub(crate) models: Option<&'a Path>,
    /// Whether slow parts are to be left out. What is not left out gives the same numbers.
    pub(crate) quick: bool,
}

/// Something to be drawn, and how it is to be called.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Picture<'a> {
    pub(crate) scene: Scene<'a>,
    pub(crate) view: &'a View,
    pub(crate) style: &'a Style,
    /// The name of the files, without extension.
    pub(crate) name: &'a str,
    pub(crate) caption: &'a str,
}

impl Run<'_> {
    /// A real model, repaired as far as needed; `None`, and noted in the item, if it is not there.
    pub(crate) fn model(&self, item: &mut Item, file: &str) -> Result<Option<TriMesh>, Failure> {
        match self.models.map(|folder| folder.join(file)).filter(|path| path.exists()) {
            Some(path) => Ok(Some(self.read(&path)?)),
            None => {
                item.missing_models.push(file.to_owned());
                Ok(None)
            }
        }
    }

    fn read(&self, path: &Path) -> Result<TriMesh, Failure> {
        let model = mesh_io::read(path).map_err(Failure::reading(path))?;
        Ok(build(&model.soup, &Repair::lenient()).map_err(Failure::mesh)?.mesh)
    }

    /// Draws a mesh without colours.
    pub(crate) fn picture(
        &self,
        mesh: &TriMesh,
        view: &View,
        style: &Style,
        name: &str,
        caption: &str,
    ) -> Result<Figure, Failure> {
        self.draw(&Picture { scene: Scene::of(mesh), view, style, name, caption })
    }

    /// Draws to `name.png` and keeps the mesh, with its colours, as `name.ply` and `name.glb`.
    pub(crate) fn draw(&self, picture: &Picture<'_>) -> Result<Figure, Failure> {
        let file = PathBuf::from(picture.name).with_extension("png");
        let path = self.out.join(&file);
        let png = render(&picture.scene, picture.view, picture.style).and_then(|p| p.to_png());
        std::fs::write(&path, png.map_err(Failure::mesh)?).map_err(Failure::writing(&path))?;
        let meshes = self.keep(picture.name, picture.scene.mesh, picture.scene.paint)?;
        let turning = self.turning(picture)?;
        Ok(Figure { caption: picture.caption.into(), file, meshes, turning })
    }

    /// Keeps a mesh, with its colours, as `name.ply` and `name.glb`.
    pub(crate) fn keep(
        &self,
        name: &str,
        mesh: &TriMesh,
        paint: Paint<'_>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let model = model_of(mesh, paint)?;
        let files = ["ply", "glb"].map(|kind| PathBuf::from(name).with_extension(kind));
        for file in &files {
            let path = self.out.join(file);
            mesh_io::write(&path, &model, &WriteOptions::default()).map_err(Failure::mesh)?;
        }
        Ok(files.into())
    }

    /// A page on which the drawn mesh turns, with the lines on it, as `name.html`.
    fn turning(&self, picture: &Picture<'_>) -> Result<PathBuf, Failure> {
        let Scene { mesh, paint, strokes, .. } = picture.scene;
        let mut exhibit = Exhibit::of_mesh(picture.caption, mesh);
        if let Paint::Vertices(colors) = paint {
            let opaque = |&[r, g, b]: &[u8; 3]| [r, g, b, 255];
            exhibit.vertex_colors = Some(colors.as_slice().iter().map(opaque).collect());
        }
        // Strokes of one colour and width are one set of lines.
        for stroke in strokes {
            let lines = match exhibit.lines.iter_mut().find(|lines| {
                (lines.color, lines.width.to_bits()) == (stroke.color, stroke.width.to_bits())
            }) {
                Some(lines) => lines,
                None => {
                    exhibit.lines.push(Lines {
                        name: format!("lines {}", exhibit.lines.len() + 1),
                        color: stroke.color,
                        width: stroke.width,
                        segments: Vec::new(),
                        shown: true,
                    });
                    let last = exhibit.lines.len() - 1;
                    &mut exhibit.lines[last]
                }
            };
            match stroke.points[..] {
                [point] => lines.segments.push([point, point]),
                _ => lines.segments.extend(stroke.points.windows(2).map(|pair| [pair[0], pair[1]])),
            }
        }
        let mut page = Page::new(picture.caption, vec![exhibit]);
        page.start.smooth = Some(picture.style.smooth);
        page.start.edges = Some(picture.style.edge_width > 0.0 && picture.scene.edged.is_none());
        page.start.turn = Some(picture.view.rotation().to_array());
        let file = PathBuf::from(picture.name).with_extension("html");
        let path = self.out.join(&file);
        let html = page.to_html().map_err(Failure::mesh)?;
        std::fs::write(&path, html).map_err(Failure::writing(&path))?;
        Ok(file)
    }
}

fn model_of(mesh: &TriMesh, paint: Paint<'_>) -> Result<Model, Failure> {
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let soup = PolygonSoup::from_triangles(mesh.positions(), &triangles).map_err(Failure::mesh)?;
    let unit = |&[r, g, b]: &[u8; 3]| [r, g, b, 255].map(|c| f32::from(c) / 255.0);
    let vertex_colors = match paint {
        Paint::Vertices(colors) => Some(colors.as_slice().iter().map(unit).collect()),
        _ => None,
    };
    Ok(Model { vertex_colors, ..Model::from(soup) })
}

/// A mesh from a soup of good triangles.
pub(crate) fn mesh_of(soup: &PolygonSoup) -> Result<TriMesh, Failure> {
    Ok(build(soup, &Repair::strict()).map_err(Failure::mesh)?.mesh)
}

/// The view of a mesh from a direction, framed to it.
pub(crate) fn view_of(
    mesh: &TriMesh,
    toward: glam::DVec3,
    up: glam::DVec3,
) -> Result<View, Failure> {
    View::of(mesh, toward, up).ok_or(Failure::Usage("the mesh has no faces".into()))
}

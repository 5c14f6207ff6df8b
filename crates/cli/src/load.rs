//! Loading a mesh from a file.

use std::cmp::Reverse;
use std::collections::HashSet;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Instant;

use clap::{Args, ValueEnum};
use mesh_core::TriMesh;
use mesh_core::build::{BuildReport, Repair, Weld};
use mesh_core::measure::cracks::{Cracks, cracks};
use mesh_io::{External, Format, Model, PictureOptions, ReadError, ReadErrorKind, Scene};
use mesh_metric::{Surface, SurfaceError};
use mesh_work::{Loaded, SceneRules, diagonal, drop_not_finite, mark_labels, usual_weld};
use serde::Serialize;

use crate::args::{FormatName, RepairOptions, WeldName, is_standard};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::text::printable;

/// Wall-clock seconds of the parts of a run.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) load: f64,
    pub(crate) compute: f64,
    pub(crate) save: f64,
    pub(crate) total: f64,
}

impl Seconds {
    /// Runs a part of the work and measures its time.
    pub(crate) fn time<T>(part: &mut f64, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        *part += start.elapsed().as_secs_f64();
        result
    }

    /// Fills in the total.
    pub(crate) fn summed(mut self) -> Self {
        self.total = self.load + self.compute + self.save;
        self
    }
}

/// How input files are read.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Input")]
pub(crate) struct ReadOptions {
    /// The format of the input [default: detected from its content]
    #[arg(long, value_name = "FORMAT")]
    from: Option<FormatName>,
    /// Other files that the input may refer to, such as material libraries and buffers: files in its
    /// folder and below, none, or any
    #[arg(long, value_enum, default_value_t)]
    external: ExternalName,
    /// Memory limit of reading, such as 500M or 4G [default: 64 MiB and 60 times the size of the file]
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    max_memory: Option<u64>,
    /// Accept a file without vertices as an empty mesh
    #[arg(long)]
    allow_empty: bool,
    /// Named numbers that are labels: they are copied from the nearest vertex or face, and borders
    /// between labels of faces are kept [default: whole numbers]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    labels: Vec<String>,
    /// Named numbers that are interpolated [default: those with fractions]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    blend: Vec<String>,
}

/// Which other files may be read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ExternalName {
    None,
    #[default]
    Folder,
    Any,
}

impl From<ExternalName> for External {
    fn from(name: ExternalName) -> Self {
        match name {
            ExternalName::None => Self::None,
            ExternalName::Folder => Self::Folder,
            ExternalName::Any => Self::Any,
        }
    }
}

/// A number of bytes, with K, M or G for powers of 1024.
pub(crate) fn parse_bytes(text: &str) -> Result<u64, String> {
    let expected = || "expected a number of bytes below 2^64, like 500M or 4G".to_owned();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match &text[digits.len()..].to_ascii_uppercase()[..] {
        "" => 1,
        "K" | "KB" | "KIB" => 1 << 10,
        "M" | "MB" | "MIB" => 1 << 20,
        "G" | "GB" | "GIB" => 1 << 30,
        _ => return Err(expected()),
    };
    let count: u64 = digits.parse().map_err(|_| expected())?;
    count.checked_mul(unit).ok_or_else(expected)
}

/// How input files become meshes.
#[derive(Clone, Debug, Args)]
pub(crate) struct Loading {
    #[command(flatten)]
    read: ReadOptions,
    /// Read lengths as shares of the diagonal of the bounding box, not in model units. Lengths with a %
    /// sign, such as 0.2%, are always shares
    #[arg(long)]
    pub(crate) relative: bool,
    #[command(flatten)]
    pub(crate) repair: RepairOptions,
}

/// The number of bytes used to detect the format.
const HEAD: usize = 4096;

impl ReadOptions {
    /// Reads a file or the standard input, and reports what the reader skipped.
    fn read(&self, path: &Path, console: &Console) -> Result<Model, Failure> {
        self.read_with_format(path, false, console).map(|(model, _)| model)
    }

    /// The options of the library for a file in this folder.
    fn options(&self) -> mesh_io::ReadOptions {
        mesh_io::ReadOptions {
            format: self.from.map(Format::from),
            external: self.external.into(),
            max_memory: self.max_memory,
            allow_empty: self.allow_empty,
            ..mesh_io::ReadOptions::default()
        }
    }

    /// As [`ReadOptions::read`], with the detected format.
    /// `is_part_of_scene` says that the scene of the file is read as well.
    fn read_with_format(
        &self,
        path: &Path,
        is_part_of_scene: bool,
        console: &Console,
    ) -> Result<(Model, Option<Format>), Failure> {
        let mut options = self.options();
        let model = if is_standard(path) {
            let mut head = Vec::with_capacity(HEAD);
            let mut stdin = std::io::stdin().lock();
            (&mut stdin)
                .take(HEAD as u64)
                .read_to_end(&mut head)
                .map_err(|error| failed(path, error))?;
            options.format = options.format.or_else(|| {
                let size = (head.len() < HEAD).then_some(head.len() as u64);
                Format::detect(&head, size, None)
            });
            mesh_io::read_from(&mut head.as_slice().chain(stdin), &options)
                .map_err(|error| ReadError { path: Some("<stdin>".into()), ..error })
        } else {
            options.format = options.format.or(detect(path)?);
            mesh_io::read_with(path, &options)
        };
        let mut model = model.map_err(|error| Failure::Read(Box::new(error)))?;
        mark_labels(&mut model, &self.labels, &self.blend).map_err(Failure::usage)?;
        if is_part_of_scene {
            // The scene has what the mesh has no place for.
            let lost: HashSet<String> =
                model.lost.drain(..).map(|lost| format!("lost {lost}")).collect();
            model.notes.retain(|note| !lost.contains(note));
        }
        let name = printable(path.display());
        for note in &model.notes {
            console.message(format_args!("{name}: {}", printable(note)));
        }
        model.lost.iter().for_each(|lost| console.lose(&name, "reading", lost));
        console.note_input(&model);
        Ok((model, options.format))
    }
}

/// The surface of a file, or its points if it has no faces.
pub(crate) fn surface_or_points(
    path: &Path,
    model: &Model,
    console: &Console,
) -> Result<Surface, Failure> {
    tell_crowded(path, model.soup.positions().len(), model.soup.faces(), console);
    mesh_work::surface_or_points(&model.soup).map_err(|source| no_surface(path, source))
}

pub(crate) fn no_surface(path: &Path, source: SurfaceError) -> Failure {
    Failure::Surface { path: path.to_owned(), source: Box::new(source) }
}

fn failed(path: &Path, error: std::io::Error) -> Failure {
    let kind = ReadErrorKind::Io(error);
    Failure::Read(Box::new(ReadError { path: Some(path.to_owned()), kind }))
}

/// The format of a regular file by its content, as the reader detects it; other inputs can be read only once.
fn detect(path: &Path) -> Result<Option<Format>, Failure> {
    let metadata = std::fs::metadata(path).map_err(|error| failed(path, error))?;
    if !metadata.is_file() {
        return Ok(None);
    }
    let mut head = Vec::with_capacity(HEAD);
    File::open(path)
        .and_then(|file| file.take(HEAD as u64).read_to_end(&mut head))
        .map_err(|error| failed(path, error))?;
    Ok(Format::detect(&head, Some(metadata.len()), Some(path)))
}

impl Loading {
    /// How a file is read as a stream, which has positions and faces only.
    pub(crate) fn streaming(&self) -> Result<mesh_io::ReadOptions, Failure> {
        let named = [("--labels", &self.read.labels), ("--blend", &self.read.blend)];
        if let Some((option, _)) = named.iter().find(|(_, names)| !names.is_empty()) {
            return Err(Failure::usage(format!(
                "{option} names data of vertices and faces, but only positions and faces are read with this --memory; \
                 give --memory what the whole mesh needs, or leave it out"
            )));
        }
        Ok(mesh_io::ReadOptions {
            format: self.read.from.map(Format::from),
            max_memory: self.read.max_memory,
            allow_empty: self.read.allow_empty,
            ..mesh_io::ReadOptions::default()
        })
    }

    /// Options for loading the pictures of a file: files beside it, within the memory limit of reading.
    pub(crate) fn pictures(&self, path: &Path) -> PictureOptions {
        let folder = path.parent().filter(|_| !is_standard(path)).map(Path::to_owned);
        let (external, max_memory) = (self.read.external.into(), self.read.max_memory);
        PictureOptions { folder, external, max_memory, ..PictureOptions::default() }
    }

    /// The format of a file, if it can be determined before it is read.
    pub(crate) fn format(&self, path: &Path) -> Result<Option<Format>, Failure> {
        match self.read.from {
            Some(format) => Ok(Some(format.into())),
            None if is_standard(path) => Ok(None),
            None => detect(path),
        }
    }

    /// Reads a scene whole, and reports what the reader skipped.
    pub(crate) fn scene(&self, path: &Path, console: &Console) -> Result<Scene, Failure> {
        let options = self.read.options();
        let scene = if is_standard(path) {
            Scene::read_from(&mut std::io::stdin().lock(), &options)
                .map_err(|error| error.at_path(Path::new("<stdin>")))
        } else {
            Scene::read(path, &options)
        };
        let scene = scene.map_err(|error| Failure::Read(Box::new(error)))?;
        let name = printable(path.display());
        for note in scene.notes() {
            console.message(format_args!("{name}: {}", printable(note)));
        }
        scene.lost().iter().for_each(|lost| console.lose(&name, "reading", lost));
        Ok(scene)
    }

    /// How the meshes of a scene are built: split vertices are joined unless a weld is given.
    pub(crate) fn scene_rules(&self) -> SceneRules {
        let repair = self.repair.repair(Weld::None);
        SceneRules {
            repair,
            needed_repairs: !self.repair.strict,
            join: self.repair.weld.is_none() && repair.weld == Weld::None,
            ..SceneRules::default()
        }
    }

    /// Whether vertices within a distance are welded, which is a length of one mesh.
    pub(crate) fn welds_within(&self) -> bool {
        matches!(self.repair.weld, Some(WeldName::Within(_)))
    }

    /// Whether empty meshes are allowed.
    pub(crate) fn allows_empty(&self) -> bool {
        self.read.allow_empty
    }

    /// Reads a file or the standard input without repairs, and reports what the reader skipped.
    pub(crate) fn read(&self, path: &Path, console: &Console) -> Result<Model, Failure> {
        self.read.read(path, console)
    }

    /// Reads the mesh of a file whose scene is read as well, without repairs. Reports only what neither of them has.
    pub(crate) fn read_beside_scene(
        &self,
        path: &Path,
        console: &Console,
    ) -> Result<Model, Failure> {
        self.read.read_with_format(path, true, console).map(|(model, _)| model)
    }

    /// Reads a file and builds the mesh, with the repairs that are asked for and, without `--strict`, those that it
    /// needs. Some formats, for example glTF, split a vertex so that each part has one texture coordinate and one
    /// normal. The parts are welded unless `--weld` says otherwise: an edge between unconnected faces has no curvature
    /// and cannot flip. So are open edges that lie on each other, without `--strict`.
    pub(crate) fn load(&self, path: &Path, console: &Console) -> Result<Loaded, Failure> {
        let (model, format) = self.read.read_with_format(path, false, console)?;
        self.check_faces(path, &model)?;
        let mut repair = self.repairs(&model)?;
        let usual = usual_weld(&model, format);
        let joined = self.repair.weld.is_none()
            && repair.weld == Weld::None
            && (usual == Weld::Exact || !self.repair.strict);
        if joined {
            repair.weld = usual;
        }
        let made = if self.repair.strict { Made::AsTold } else { Made::AsNeeded };
        let loaded = assemble(path, model, &repair, (made, joined), console)?;
        if self.repair.weld.is_none() {
            tell_cracks(path, &loaded, console);
        }
        self.check_left(path, loaded)
    }

    /// Reads a file and builds the mesh with only the repairs that are asked for.
    pub(crate) fn load_as_told(&self, path: &Path, console: &Console) -> Result<Loaded, Failure> {
        let model = self.read(path, console)?;
        let repair = self.repairs(&model)?;
        self.check_left(path, assemble(path, model, &repair, (Made::AsTold, false), console)?)
    }

    /// Refuses points without faces, unless empty meshes are allowed.
    pub(crate) fn check_faces(&self, path: &Path, model: &Model) -> Result<(), Failure> {
        match (model.soup.vertex_count(), model.soup.face_count()) {
            (points @ 1.., 0) if !self.read.allow_empty => {
                Err(Failure::NoFaces { path: path.to_owned(), points })
            }
            _ => Ok(()),
        }
    }

    /// Refuses a mesh that the repairs have left empty, unless empty meshes are allowed.
    pub(crate) fn check_left(&self, path: &Path, loaded: Loaded) -> Result<Loaded, Failure> {
        match loaded.counts() {
            [0, 0] if !self.read.allow_empty => Err(Failure::NothingLeft(path.to_owned())),
            _ => Ok(loaded),
        }
    }

    /// The content of a file, or of the repaired mesh if there are any repairs.
    pub(crate) fn content(&self, path: &Path, console: &Console) -> Result<Model, Failure> {
        if !self.repair.any() {
            return self.read(path, console);
        }
        self.load_as_told(path, console)?.into_model().map_err(Failure::model)
    }

    /// As [`Loading::content`], without vertices at infinite or undefined positions, unless `--strict` is given.
    pub(crate) fn finite_content(&self, path: &Path, console: &Console) -> Result<Model, Failure> {
        let content = self.content(path, console)?;
        if self.repair.strict {
            return Ok(content);
        }
        let (content, report) = drop_not_finite(content).map_err(Failure::model)?;
        if !report.is_unchanged() {
            let name = printable(path.display());
            console.message(format_args!("{name}: {}", needed(report.repairs())));
            console.repaired(&name, report.repairs());
        }
        Ok(content)
    }

    /// The repairs for a file, lengths in its units.
    pub(crate) fn repairs(&self, model: &Model) -> Result<Repair, Failure> {
        let within = match self.repair.weld {
            Some(WeldName::Within(length)) => {
                let size = || diagonal(model.soup.measure().bounds.map(|b| b.diagonal()));
                Weld::Distance(length.in_units(self.relative, size).map_err(Failure::refused)?)
            }
            _ => Weld::None,
        };
        Ok(self.repair.repair(within))
    }
}

/// Which repairs are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Made {
    /// The repairs that are asked for.
    AsTold,
    /// The repairs that are asked for, and those that the mesh needs.
    AsNeeded,
}

/// Builds the mesh, and reports the repairs. `joined`: split vertices are welded without being asked for.
pub(crate) fn assemble(
    path: &Path,
    model: Model,
    asked: &Repair,
    (made, joined): (Made, bool),
    console: &Console,
) -> Result<Loaded, Failure> {
    let loaded = match made {
        Made::AsTold => Loaded::build(model, asked),
        Made::AsNeeded => Loaded::build_with_needed_repairs(model, asked),
    };
    let loaded = loaded.map_err(|source| Failure::Build {
        path: path.to_owned(),
        source: Box::new(source),
        joined,
    })?;
    let (report, name) = (&loaded.report, printable(path.display()));
    if report.is_unchanged() {
        return Ok(loaded);
    }
    if report.welded_vertices.count() > 0
        && let Some(lost) = loaded.source().lost_by_joining()
    {
        console.message(format_args!("{name}: lost {lost}"));
        console.lose(&name, "joining", &lost);
    }
    console.repaired(&name, report.repairs());
    let mut only_join = Repair::strict();
    only_join.weld = if joined { asked.weld } else { Weld::None };
    if made == Made::AsNeeded && *asked == only_join {
        console.message(format_args!("{name}: {}", needed(report.repairs())));
    } else {
        console.message(format_args!("{name}: {report}"));
    }
    Ok(loaded)
}

/// Names vertices that no face uses. They are not counted as vertices of a result, and take room in its file.
pub(crate) fn tell_unused(path: &Path, loaded: &Loaded, console: &Console) {
    let topology = loaded.mesh.topology();
    let unused = topology.vertices().filter(|&v| topology.is_isolated_vertex(v)).count();
    if unused > 0 {
        let name = printable(path.display());
        let unused = counted(unused, "vertices that no face uses");
        let stays = format!("{unused}: kept; --drop-unreferenced drops them");
        console.message(format_args!("{name}: {stays}"));
        console.stays(&name, &stays);
    }
}

/// As [`tell_crowded`] for a mesh.
pub(crate) fn tell_crowded_mesh(path: &Path, mesh: &TriMesh, console: &Console) {
    tell_crowded(path, mesh.positions().len(), mesh.topology().triangles(), console);
}

/// Number of faces at a vertex from which a command that searches for close faces is said to take long.
const CROWDED: u32 = 4096;

/// Says that a search for close faces takes long if thousands of faces share a vertex.
fn tell_crowded<F: AsRef<[u32]>>(
    path: &Path,
    vertices: usize,
    faces: impl IntoIterator<Item = F>,
    console: &Console,
) {
    let mut counts = vec![0_u32; vertices];
    for face in faces {
        for &v in face.as_ref() {
            counts.get_mut(v as usize).into_iter().for_each(|count| *count += 1);
        }
    }
    let most = counts.iter().enumerate().max_by_key(|(v, count)| (**count, Reverse(*v)));
    if let Some((v, &count)) = most.filter(|(_, count)| **count >= CROWDED) {
        console.message(format_args!(
            "{}: vertex {v} has {}; unless they lie in a plane, the time grows with the square of their number; \
             `simplify --preset fast` makes a mesh with fewer",
            printable(path.display()),
            counted(count as usize, "faces")
        ));
    }
}

/// Names narrow gaps between boundaries, and what joins them.
pub(crate) fn tell_cracks(path: &Path, loaded: &Loaded, console: &Console) {
    if let Some(Cracks { vertices, width }) = cracks(&loaded.mesh) {
        let name = printable(path.display());
        let stays = format!(
            "{vertices} boundary vertices stay apart from others within {width:.1e}; --weld {:.1e} joins them",
            2.0 * width
        );
        console.message(format_args!("{name}: {stays}"));
        console.stays(&name, &stays);
    }
}

/// One line about repairs that were not asked for.
pub(crate) fn needed(repairs: impl Iterator<Item = (&'static str, usize)>) -> String {
    let mut welds_only = true;
    let repairs = repairs.map(|(what, count)| {
        welds_only &= what == BuildReport::MERGED;
        format!("{what}: {count}")
    });
    let repairs = repairs.collect::<Vec<_>>().join(", ");
    let cure =
        if welds_only { "--weld none keeps them apart" } else { "--strict refuses such a mesh" };
    format!("{repairs} ({cure})")
}

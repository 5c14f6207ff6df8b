//! The commands that make meshes, with common options, and what each of them promises.

use mesh_core::SplitMix64;

use crate::judge::{Promise, Topology};

/// A command line and its promise.
#[derive(Clone, Debug)]
pub struct Command {
    /// The command and its variant.
    pub name: String,
    /// The command line. `{in}` stands for the input, `{out}` for an empty folder.
    pub line: String,
    /// The files that it writes into the folder; `{stem}` is the name of the input without extension.
    pub outputs: Vec<String>,
    /// What holds for each of them.
    pub promise: Promise,
    /// The density of the input; see [`crate::kinds::mesh`].
    pub density: f64,
}

impl Command {
    fn new(command: &str, options: &str, promise: Promise) -> Self {
        Self {
            name: format!("{command} {options}").trim_end().to_owned(),
            line: format!("{command} {{in}} -o {{out}}/m.ply {options}"),
            outputs: vec!["m.ply".to_owned()],
            promise,
            density: 1.0,
        }
    }

    /// The first word of the name.
    #[must_use]
    pub fn command(&self) -> &str {
        self.name.split(' ').next().unwrap_or_default()
    }

    /// The words of the command line.
    #[must_use]
    pub fn words(&self, input: &str, out: &str) -> Vec<String> {
        let fill = |word: &str| word.replace("{in}", input).replace("{out}", out);
        self.line.split(' ').filter(|word| !word.is_empty()).map(fill).collect()
    }
}

/// All commands.
#[must_use]
pub fn all() -> Vec<Command> {
    [simplify(), flip(), lod(), others(), larger_than_memory()].concat()
}

/// Groups of options of `simplify`. At most one option of a group is taken; an empty one is none.
const GROUPS: [&[&str]; 13] = [
    &[
        "",
        "--norm l1",
        "--preset draft",
        "--preset fast",
        "--preset quality",
        "--preset quality --norm max",
        "--preset thin-features",
    ],
    &["--ratio 0.4", "--ratio 0.15", "--ratio 0.04", "--faces 30", "--vertices 40", "--bytes 4kB"],
    &["", "", "--max-error 0.3%", "--max-error 2%"],
    &["", "", "--verify"],
    &["", "", "--lock-boundary"],
    &["", "", "--feature-angle 25", "--feature-angle 50"],
    &["", "", "--no-intersections"],
    &["", "", "--components keep", "--components 12"],
    &["", "", "", "--max-edge 20%"],
    &["", "", "", "--min-angle 3"],
    &["", "", "", "--max-valence 8"],
    &["", "", "", "--no-attributes", "--keep-seams", "--attribute-weight 3"],
    &["", "", "", "--placement endpoint", "--placement optimal", "--curvature-weight 0.3"],
];

/// `simplify` with options that chance puts together. All of them can be met together, or the report says what was not.
#[must_use]
pub fn combined(seed: u64) -> Command {
    let mut random = SplitMix64::new(seed);
    let chosen = GROUPS.map(|group| group[(random.bits() % group.len() as u64) as usize]);
    let has = |option: &str| chosen.iter().any(|other| other.starts_with(option));
    let words: Vec<&str> = chosen.into_iter().filter(|option| !option.is_empty()).collect();
    let promise = Promise {
        bound: has("--verify").then_some("/error/upper"),
        no_crossings: has("--no-intersections"),
        topology: if has("--components keep") { Topology::Same } else { Topology::Fewer },
        ..Promise::default()
    };
    Command::new("simplify", &words.join(" "), promise)
}

fn simplify() -> Vec<Command> {
    let job = |options: &str, promise: Promise| Command::new("simplify", options, promise);
    let promise = Promise::default();
    let mut all = Vec::new();
    for preset in ["draft", "fast", "default", "quality", "thin-features", "quadrics"] {
        for ratio in ["0.5", "0.3", "0.1", "0.05", "0.02"] {
            all.push(job(&format!("--preset {preset} --ratio {ratio}"), promise));
        }
    }
    // The butterfly point leaves the surface, and chains of turns that are each within the guard fold faces. At a
    // boundary no move turns them back.
    let foldable = Promise { unfolded: false, ..promise };
    all.push(job("--preset paper-l1-guarded --ratio 0.3", foldable));
    all.push(job("--preset paper-l2-guarded --ratio 0.3", promise));
    for placement in ["optimal-volume", "optimal", "endpoint", "midpoint", "butterfly"] {
        all.push(job(&format!("--ratio 0.2 --preset fast --placement {placement}"), promise));
    }
    for norm in ["l1", "max"] {
        all.push(job(&format!("--ratio 0.1 --preset quality --norm {norm}"), promise));
    }
    let proved = Promise { bound: Some("/error/upper"), ..promise };
    let apart = Promise { no_crossings: true, ..promise };
    let kept = Promise { topology: Topology::Same, ..promise };
    all.extend([
        job("--ratio 0.1 --preset extreme --anneal-time 2", promise),
        job("--ratio 0.5 --no-attributes", promise),
        job("--ratio 0.1 --no-attributes --preset quality", promise),
        job("--ratio 0.3 --keep-seams", promise),
        job("--max-error 0.1%", promise),
        job("--max-error 1% --verify", proved),
        job("--max-error 3% --preset quality --verify", proved),
        job("--ratio 0.2 --verify", proved),
        job("--ratio 0.3 --no-intersections", apart),
        job("--ratio 0.1 --no-intersections --preset quality", apart),
        job("--ratio 0.1 --components keep", kept),
        job("--faces 20 --components keep --preset quality", kept),
        job("--ratio 0.2 --lock-boundary", promise),
        job("--ratio 0.2 --feature-angle 30", promise),
        job("--ratio 0.2 --max-edge 10% --min-angle 5 --max-valence 9", promise),
        job("--ratio 0.3 --lenient", Promise { is_lenient: true, ..promise }),
    ]);
    all
}

fn flip() -> Vec<Command> {
    let promise = Promise { topology: Topology::Same, moves_no_vertex: true, ..Promise::default() };
    let job = |options: &str, promise: Promise| Command::new("flip", options, promise);
    let mut all: Vec<Command> = [
        "f1",
        "f2",
        "f3",
        "gauss",
        "gauss-extrinsic",
        "area",
        "delaunay",
        "willmore",
        "willmore-potential",
    ]
    .iter()
    .map(|cost| job(&format!("--cost {cost}"), promise))
    .collect();
    all.extend([
        job("--cost f2 --feature-angle 40 --max-fold 60", promise),
        job("--cost f1 --look-ahead 2", promise),
        job("--cost delaunay --anneal-steps 2", promise),
        job("--cost f2 --no-intersections", Promise { no_crossings: true, ..promise }),
    ]);
    all
}

fn lod() -> Vec<Command> {
    let job = |options: &str, promise: Promise| Command {
        name: format!("lod {options}"),
        line: format!("lod {{in}} -o {{out}} --levels 0.5,0.1,0.02 --to ply {options}"),
        outputs: (1..=3).map(|level| format!("{{stem}}-{level}.ply")).collect(),
        promise,
        density: 1.0,
    };
    let promise = Promise::default();
    vec![
        job("--preset fast", promise),
        job("--preset default", promise),
        job("--preset quality --no-attributes", promise),
        job("--no-intersections", Promise { no_crossings: true, ..promise }),
    ]
}

fn others() -> Vec<Command> {
    let same = Promise { topology: Topology::Same, ..Promise::default() };
    let lenient = Promise { is_lenient: true, ..same };
    let copy = Promise { topology: Topology::Copied, moves_no_vertex: true, ..same };
    let to = |format: &str| Command {
        name: format!("convert {format}"),
        line: format!("convert {{in}} -o {{out}}/m.{format}"),
        outputs: vec![format!("m.{format}")],
        // Numbers of 32 bits round the vertices.
        promise: Promise {
            moves_no_vertex: format == "ply",
            faces: format == "ply",
            slivers: format == "ply",
            unfolded: format == "ply",
            ..copy
        },
        density: 1.0,
    };
    vec![
        to("ply"),
        to("obj"),
        to("stl"),
        to("glb"),
        Command::new("repair", "", Promise { moves_no_vertex: true, ..lenient }),
        Command::new(
            "repair",
            "--fill-holes 30",
            Promise {
                topology: Topology::Any,
                // A slit between sides that a file has rounded apart has room for slivers alone.
                slivers: false,
                // A wall that two parts share is a duplicate and dropped from one of them. The faces that close this
                // part face the wall of the other one.
                unfolded: false,
                ..lenient
            },
        ),
        Command::new("subdivide", "", Promise { pieces: 4, ..same }),
        // Patches that overlap, drawn as triangles: no other mesh of the same surface.
        Command::new("patch", "--tolerance 1%", Promise::finite()),
        Command::new("curvature", "", Promise { moves_no_vertex: true, ..same }),
    ]
}

fn larger_than_memory() -> Vec<Command> {
    let promise = Promise::default();
    let job = |options: &str, promise: Promise| Command {
        density: 10.0,
        ..Command::new("simplify", &format!("--memory 32MiB {options}"), promise)
    };
    vec![
        job("--ratio 0.3 --preset fast", promise),
        job("--ratio 0.05", promise),
        // A piece is refined with its rim held, where no move turns a face back.
        job("--ratio 0.02 --preset quality", Promise { unfolded: false, ..promise }),
    ]
}

//! The documentation is correct: its commands run, its links have targets, its tables agree.
//!
//! Each page has a folder with small generated meshes, in which its `sh` blocks run line by line. With
//! `CURVMESH_BOOK=rewrite` the pictures that a page makes replace the pictures that it shows, and
//! `docs/reference.md` gets the current help texts. A picture with the name of a page is a picture of that page in
//! Chromium.
#![allow(clippy::unwrap_used)]
#![cfg(unix)]

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{json, write};
use crate::views::browser::Browser;
use mesh_core::glam::DVec3;
use mesh_core::{PolygonSoup, Repair, build};
use mesh_io::{Model, WriteOptions};
use mesh_shapes::{Saddle, Sphere, Torus, polyhedra};

const TORUS: Torus = Torus { major: 5.0, minor: 2.0 };

/// A cube without its top, with one duplicate face and one reversed face.
const BROKEN: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                      f 4 3 2 1\nf 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 1 4 8 5\n";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The pages of a folder of the repository.
fn pages(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<_> =
        entries.filter(|path| path.extension() == Some("md".as_ref())).collect();
    pages.sort();
    pages
}

/// A sphere with bumps, finer for pictures.
fn scan() -> PolygonSoup {
    let bumps = |p: DVec3| {
        0.10 * (3.0 * p.x + 1.0).sin() * (4.0 * p.y).cos()
            + 0.05 * (6.0 * p.z + 2.0 * p.x).sin()
            + 0.03 * (9.0 * p.y).sin() * (8.0 * p.x + 1.0).sin()
    };
    let level = if is_rewriting() { 5 } else { 4 };
    let mut soup = Sphere { radius: 1.0 }.icosphere(level).unwrap();
    soup.positions_mut().iter_mut().for_each(|p| *p *= 1.0 + bumps(*p));
    soup
}

/// A torus with texture coordinates.
fn truck() -> Model {
    let (around, across) = (40, 20);
    let soup = TORUS.mesh(around, across).unwrap();
    let corners = soup.corners().iter().map(|&v| soup.positions()[v as usize]);
    let uvs = corners.map(|p| [p.x, p.y].map(|x| (x / 14.0 + 0.5) as f32)).collect();
    Model { corner_uvs: Some(uvs), ..Model::from(soup) }
}

/// The files that the commands use.
fn files(folder: &Path) {
    let file = |name: &str| folder.join(name);
    for name in ["scan.ply", "huge.ply", "huge.stl"] {
        write(scan(), &file(name));
    }
    write(TORUS.shifted_mesh(12, 6).unwrap(), &file("coarse.ply"));
    write(polyhedra::cube(), &file("part.stl"));
    let open = Saddle { coefficient: 0.5, half_width: 1.0 }.mesh(12, Default::default()).unwrap();
    write(open, &file("open.ply"));
    fs::create_dir(file("scans")).unwrap();
    for (name, around) in [("a", 20), ("b", 30), ("c", 40)] {
        write(TORUS.mesh(around, 10).unwrap(), &file(&format!("scans/{name}.ply")));
    }
    mesh_io::write(file("truck.glb"), &truck(), &WriteOptions::default()).unwrap();
    fs::write(file("broken.obj"), BROKEN).unwrap();
}

/// The search path, with the folder of the program first.
fn search_path() -> OsString {
    let program = Path::new(env!("CARGO_BIN_EXE_curvmesh"));
    let mut path = program.parent().unwrap().as_os_str().to_owned();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    path
}

/// Runs the commands of a page, and returns their number.
fn run(page: &Path) -> usize {
    let text = fs::read_to_string(page).unwrap();
    let lines: Vec<&str> = text
        .split("```sh\n")
        .skip(1)
        .flat_map(|block| block.split("```").next().unwrap().lines())
        .collect();
    if lines.is_empty() {
        return 0;
    }
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    for line in &lines {
        let mut shell = Command::new("sh");
        let run = shell.args(["-c", line]).current_dir(&folder).env("PATH", search_path());
        let output = run.output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {line}: {stderr}", page.display());
    }
    if is_rewriting() {
        for image in targets(&text).into_iter().filter(|link| is_picture(link)) {
            let made = folder.path().join(Path::new(image).file_name().unwrap());
            photograph(&made.with_extension("html"), &made);
            if made.exists() {
                fs::copy(made, page.parent().unwrap().join(image)).unwrap();
            }
        }
    }
    lines.len()
}

/// Takes a picture of a page, if there is one.
fn photograph(page: &Path, picture: &Path) {
    let browser = page.exists().then(|| Browser::start([960, 600])).flatten();
    if let Some(mut browser) = browser {
        browser.open_view(page);
        browser.eval("canvas.style.outline = 'none'; 1");
        browser.settle();
        fs::write(picture, browser.picture(None).png).unwrap();
    }
}

/// Whether a link leads to a picture that commands make.
fn is_picture(link: &str) -> bool {
    [".png", ".svg"].iter().any(|extension| link.ends_with(extension))
}

/// Every tutorial shows what its commands make.
#[test]
fn every_tutorial_has_a_picture_of_its_own() {
    for page in pages("docs/tutorials") {
        let text = fs::read_to_string(&page).unwrap();
        let code: String = text.split("```").skip(1).step_by(2).collect();
        let shown = targets(&text).into_iter().filter(|link| is_picture(link));
        let made = shown.filter(|link| code.contains(&link.replace("../images/", ""))).count();
        assert!(made > 0, "{}", page.display());
    }
}

fn is_rewriting() -> bool {
    std::env::var_os("CURVMESH_BOOK").is_some_and(|wish| wish == "rewrite")
}

/// The targets of the links and pictures of a page.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let code_free = text.split("```").step_by(2);
    code_free
        .flat_map(|part| part.split("](").skip(1))
        .filter_map(|rest| rest.split(')').next())
        .filter(|link| !link.contains("://"))
}

/// The same, without the part after `#`.
fn targets(text: &str) -> Vec<&str> {
    let files = links(text).map(|link| link.split('#').next().unwrap());
    files.filter(|link| !link.is_empty()).collect()
}

/// The anchors of the headings of a page, as mdBook and hosts of repositories make them.
fn anchors(text: &str) -> Vec<String> {
    let lines = text.split("```").step_by(2).flat_map(str::lines);
    let headings = lines.filter(|line| line.starts_with('#'));
    let mut found: Vec<String> = Vec::new();
    for heading in headings.map(|line| line.trim_start_matches('#').trim().to_lowercase()) {
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let again = found.iter().filter(|other| **other == anchor).count();
        found.push(if again == 0 { anchor } else { format!("{anchor}-{again}") });
    }
    found
}

#[test]
fn commands_of_the_tutorials_run() {
    let count: usize = pages("docs/tutorials").iter().map(|page| run(page)).sum();
    assert!(count > 40, "{count}");
}

#[test]
fn commands_of_the_guides_run() {
    let count: usize = pages("docs/guides").iter().map(|page| run(page)).sum();
    assert!(count > 20, "{count}");
}

#[test]
fn commands_of_the_other_pages_run() {
    let others = pages("docs").into_iter().chain(pages(""));
    let count: usize = others.map(|page| run(&page)).sum();
    assert!(count > 30, "{count}");
}

#[test]
fn links_lead_to_files() {
    let pages = ["", "docs", "docs/tutorials", "docs/guides", "docs/results"].map(pages).concat();
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        for link in targets(&text) {
            assert!(page.parent().unwrap().join(link).exists(), "{}: {link}", page.display());
        }
        for (file, anchor) in links(&text).filter_map(|link| link.split_once('#')) {
            let target = match file {
                "" => page.clone(),
                file => page.parent().unwrap().join(file),
            };
            let found = anchors(&fs::read_to_string(target).unwrap());
            assert!(found.iter().any(|found| found == anchor), "{}: #{anchor}", page.display());
        }
    }
}

/// Links of the book that lead out of its folder lead nowhere in the built book.
#[test]
fn the_book_links_to_itself() {
    let book = root().join("docs").canonicalize().unwrap();
    for page in ["docs", "docs/tutorials", "docs/guides", "docs/results"].map(pages).concat() {
        let text = fs::read_to_string(&page).unwrap();
        for link in targets(&text) {
            let target = page.parent().unwrap().join(link).canonicalize().unwrap();
            assert!(target.starts_with(&book), "{}: {link}", page.display());
        }
    }
}

#[test]
fn the_summary_lists_every_page() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed = targets(&summary).into_iter().map(|link| root().join("docs").join(link));
    let listed: Vec<_> = listed.map(|path| path.canonicalize().unwrap()).collect();
    for page in ["docs", "docs/tutorials", "docs/guides", "docs/results"].map(pages).concat() {
        let is_listed = listed.contains(&page.canonicalize().unwrap());
        assert!(is_listed || page.ends_with("SUMMARY.md"), "{}", page.display());
    }
}

/// Appends the help of a command and its subcommands.
fn push_help(page: &mut String, command: &[&str]) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_curvmesh"));
    let output = program.args(command).arg("--help").env("COLUMNS", "100").output().unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    let name = [&["curvmesh"], command].concat().join(" ");
    let lines: Vec<&str> = help.trim().lines().map(str::trim_end).collect();
    *page += &format!("## {name}\n\n```text\n{}\n```\n\n", lines.join("\n"));
    let commands = lines.iter().skip_while(|line| **line != "Commands:").skip(1);
    for line in commands.take_while(|line| !line.is_empty()) {
        let is_name = line.starts_with("  ") && !line.starts_with("   ");
        match line.split_whitespace().next() {
            Some(below) if is_name && below != "help" => {
                push_help(page, &[command, &[below]].concat());
            }
            _ => {}
        }
    }
}

#[test]
fn the_reference_has_the_help_of_all_commands() {
    let path = root().join("docs/reference.md");
    let mut page = "# Command reference\n\nThese are the help texts of the program.\n\n".to_owned();
    push_help(&mut page, &[]);
    let page = format!("{}\n", page.trim_end());
    if is_rewriting() {
        fs::write(&path, &page).unwrap();
    }
    let cure = "CURVMESH_BOOK=rewrite cargo test -p curvmesh-cli --test main book writes it anew";
    assert!(fs::read_to_string(&path).unwrap() == page, "docs/reference.md is out of date; {cure}");
}

/// The cells of the rows of a page whose first cell has this text.
fn row(text: &str, name: &str) -> Option<Vec<String>> {
    let rows = text
        .lines()
        .map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()));
    rows.map(Iterator::collect::<Vec<_>>).find(|cells| cells[0] == name)
}

/// The README shows some columns of the full table of programs.
#[test]
fn the_two_tables_of_programs_agree() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let full = fs::read_to_string(root().join("docs/results/peers.md")).unwrap();
    let head = |text: &str| {
        let line = text.lines().find(|line| line.starts_with("| | time |")).unwrap();
        line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>()
    };
    let (columns, all) = (head(&readme), head(&full));
    for name in ["`draft`", "`default`", "CGAL Lindstrom-Turk", "MeshLab", "fast-simplification"] {
        let (short, long) = (row(&readme, name).unwrap(), row(&full, name).unwrap());
        for (value, column) in short.iter().zip(&columns) {
            let index = all.iter().position(|other| other == column).unwrap();
            assert_eq!(*value, long[index], "{name}, {column}");
        }
    }
}

/// The five lines of Rust in `docs/questions.md`.
#[test]
fn vertices_are_followed() {
    let soup = TORUS.mesh(60, 30).unwrap();
    let mesh = build(&soup, &Repair::strict()).unwrap().mesh;
    let result = simplify::simplify(&mesh, &simplify::Options::default().to_faces(500)).unwrap();
    assert_eq!(result.vertex_map.iter().count(), 1800);
    assert!(result.vertex_map.iter().all(|(_, new)| new.is_some()));
}

/// The statement of `docs/questions.md` about the report of a run that cannot reach its target.
#[test]
fn a_run_that_stops_early_says_why() {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    let [open, out] = ["open.ply", "out.ply"].map(|name| folder.path().join(name));
    let [open, out] = [&open, &out].map(|path| path.to_str().unwrap());
    let report = json(&["simplify", open, "-o", out, "--faces", "4", "--lock-boundary"]);
    assert_eq!(report["stop"], "nothing_left", "{report}");
    assert!(report["rejected"].as_object().is_some_and(|counts| !counts.is_empty()), "{report}");
}

/// The lines of a manifest from a heading to the next one.
fn section<'m>(manifest: &'m str, heading: &str) -> Vec<&'m str> {
    let lines = manifest.lines().skip_while(|line| *line != heading).skip(1);
    lines.take_while(|line| !line.starts_with('[')).collect()
}

#[test]
fn unsafe_code_is_where_the_guarantees_say() {
    let read = |path: &str| fs::read_to_string(root().join(path)).unwrap();
    let workspace = read("Cargo.toml");
    let lints = section(&workspace, "[workspace.lints.rust]");
    assert!(lints.contains(&"unsafe_code = \"forbid\""), "{lints:?}");
    let members = workspace.lines().find_map(|line| line.strip_prefix("members = [")).unwrap();
    let mut manifests = Vec::new();
    for member in members.trim_end_matches(']').split(", ").map(|name| name.trim_matches('"')) {
        match member.strip_suffix("/*") {
            None => manifests.push(root().join(member)),
            Some(folder) => {
                let entries = fs::read_dir(root().join(folder)).unwrap();
                manifests.extend(entries.map(|entry| entry.unwrap().path()));
            }
        }
    }
    manifests.retain(|folder| !folder.ends_with("python") && folder.join("Cargo.toml").exists());
    assert!(manifests.len() > 20);
    for folder in manifests {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        assert!(section(&manifest, "[lints]").contains(&"workspace = true"), "{folder:?}");
    }
    let python = read("crates/python/Cargo.toml");
    assert!(section(&python, "[lints.rust]").contains(&"unsafe_code = \"deny\""));
    let guarantees = read("docs/guarantees.md");
    let row = guarantees.lines().find(|line| line.contains("`unsafe`")).unwrap();
    for entry in fs::read_dir(root().join("crates/python/src")).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("`{}`", path.file_name().unwrap().to_string_lossy());
        let is_allowed = fs::read_to_string(&path).unwrap().contains("allow(unsafe_code");
        assert_eq!(is_allowed, row.contains(&name), "{name}");
    }
}

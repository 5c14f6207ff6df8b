//! Pictures of materials in `view` and `render`: which files they read, and how much memory they take.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

const SECRET: &[u8] = b"-----BEGIN OPENSSH PRIVATE KEY-----";

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_curvmesh");
    Command::new(program).args(arguments).current_dir(folder).output().unwrap()
}

/// A square with a material for each picture.
fn square(folder: &Path, pictures: &[&str]) {
    let mut library = String::new();
    let mut text =
        "mtllib in.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
            .to_owned();
    for (number, picture) in pictures.iter().enumerate() {
        library += &format!("newmtl m{number}\nmap_Kd {picture}\n");
        text += &format!("usemtl m{number}\nf 1/1 2/2 3/3 4/4\n");
    }
    fs::write(folder.join("in.mtl"), library).unwrap();
    fs::write(folder.join("in.obj"), text).unwrap();
}

fn png(path: &Path, [width, height]: [u32; 2]) {
    let color = |x, y| image::Rgb([x as u8, y as u8, (x ^ y) as u8]);
    image::RgbImage::from_fn(width, height, color).save(path).unwrap();
}

/// A page never contains private files.
#[test]
fn a_page_holds_no_files_but_pictures_and_names_them() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join(".ssh")).unwrap();
    fs::write(folder.path().join(".ssh/id_rsa"), SECRET).unwrap();
    fs::write(folder.path().join("notes.png"), SECRET).unwrap();
    png(&folder.path().join(".hidden.png"), [9, 9]);
    png(&folder.path().join("good.png"), [7, 5]);
    square(folder.path(), &[".ssh/id_rsa", "notes.png", ".hidden.png", "good.png"]);
    let output = run(folder.path(), &["view", "in.obj", "-o", "page.html", "--json"]);
    let messages = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{messages}");
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    for (name, is_there) in
        [(".ssh/id_rsa", false), ("notes.png", false), (".hidden.png", false), ("good.png", true)]
    {
        let content = base64(&fs::read(folder.path().join(name)).unwrap());
        assert_eq!(page.contains(&content), is_there, "{name}");
        let word = if is_there { "holds the files" } else { "left out the picture" };
        let said = messages.lines().any(|line| line.contains(word) && line.contains(name));
        assert!(said, "{name}: {messages}");
    }
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["embedded_files"], serde_json::json!(["good.png"]));
    let output = run(folder.path(), &["render", "in.obj", "--lenient", "-o", "out.png"]);
    let messages = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && messages.contains("notes.png"), "{messages}");
}

/// The same content is stored once on a page, and a picture larger than its file justifies is not decoded.
#[test]
fn pages_and_pictures_take_no_more_than_their_files() {
    let folder = tempfile::tempdir().unwrap();
    png(&folder.path().join("same.png"), [300, 300]);
    let bytes = fs::read(folder.path().join("same.png")).unwrap();
    let names: Vec<String> = (0..60).map(|i| format!("copy-{i}.png")).collect();
    names.iter().for_each(|name| fs::write(folder.path().join(name), &bytes).unwrap());
    let names: Vec<&str> = names.iter().map(String::as_str).chain(["same.png"; 60]).collect();
    square(folder.path(), &names);
    assert!(run(folder.path(), &["view", "in.obj", "-o", "page.html"]).status.success());
    let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert_eq!(page.matches(&base64(&bytes)).count(), 1);
    // A header that states 30,000 by 30,000 pixels, with a correct checksum.
    let mut lying = bytes.clone();
    lying[16..24].copy_from_slice(&[30_000_u32.to_be_bytes(); 2].concat());
    let checksum = crc(&lying[12..29]);
    lying[29..33].copy_from_slice(&checksum.to_be_bytes());
    fs::write(folder.path().join("lying.png"), lying).unwrap();
    square(folder.path(), &["lying.png"]);
    for arguments in [
        &["view", "in.obj", "-o", "page.html"][..],
        &["render", "in.obj", "--lenient", "-o", "out.png"],
    ] {
        let output = run(folder.path(), arguments);
        let messages = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{messages}");
        assert!(messages.contains("30000 by 30000 pixels"), "{messages}");
    }
}

/// The checksum of PNG.
fn crc(bytes: &[u8]) -> u32 {
    let step = |sum: u32, &byte: &u8| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            if sum & 1 == 1 { 0xEDB8_8320 ^ (sum >> 1) } else { sum >> 1 }
        })
    };
    !bytes.iter().fold(u32::MAX, step)
}

fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Every command that writes a file with materials into another folder copies the pictures there.
#[test]
fn an_output_in_another_folder_has_its_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    png(&path.join("a picture.png"), [7, 5]);
    square(path, &["missing.png", "a picture.png"]);
    let grid = run(path, &["convert", "in.obj", "-o", "in.gltf"]);
    assert!(grid.status.success());
    let picture = fs::read(path.join("a picture.png")).unwrap();
    let commands: [&[&str]; 9] = [
        &["convert", "in.gltf", "-o", "OUT/a.glb"],
        &["convert", "in.obj", "-o", "OUT/a.gltf"],
        &["convert", "in.obj", "-o", "OUT/a.obj"],
        &["simplify", "in.gltf", "--ratio", "0.5", "-o", "OUT/a.gltf"],
        &["simplify", "in.obj", "--ratio", "0.5", "-o", "OUT/a.obj"],
        &["repair", "in.gltf", "-o", "OUT/a.glb"],
        &["lod", "in.gltf", "--levels", "0.5", "-o", "OUT"],
        &["lod", "in.gltf", "--levels", "0.5", "-o", "OUT/a.glb"],
        &["lod", "in.obj", "--levels", "0.5", "-o", "OUT/"],
    ];
    for (number, command) in commands.iter().enumerate() {
        let name = format!("out{number}");
        fs::create_dir(path.join(&name)).unwrap();
        let command: Vec<String> = command.iter().map(|word| word.replace("OUT", &name)).collect();
        let mut words: Vec<&str> = command.iter().map(String::as_str).collect();
        words.push("--json");
        let output = run(path, &words);
        let messages = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{command:?}: {messages}");
        let copy = fs::read(path.join(&name).join("a picture.png"));
        assert_eq!(copy.ok(), Some(picture.clone()), "{command:?}: {messages}");
        assert!(
            messages.contains("copied 1 picture that it names, such as"),
            "{command:?}: {messages}"
        );
        assert!(messages.contains("missing.png: No such file"), "{command:?}: {messages}");
        let report = String::from_utf8(output.stdout).unwrap();
        assert!(report.contains("could not be copied"), "{command:?}: {report}");
    }
}

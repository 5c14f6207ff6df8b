//! OFF as text, with one vertex or face per line, and binary big-endian OFF.

use std::path::Path;

use super::super::content::{Complaint, Content};

pub(super) fn read(path: &Path) -> Result<Content, Complaint> {
    let bytes = std::fs::read(path)?;
    let end = bytes.iter().position(|&byte| byte == b'\n').unwrap_or(bytes.len());
    let (first, rest) = bytes.split_at(end);
    let first = String::from_utf8_lossy(first);
    let mut words = first.split_whitespace();
    let kind = words.next().and_then(|word| word.strip_suffix("OFF")).ok_or("no OFF header")?;
    if words.next() == Some("BINARY") {
        binary(kind, rest.get(1..).unwrap_or_default())
    } else {
        text(rest)
    }
}

fn text(bytes: &[u8]) -> Result<Content, Complaint> {
    let text = str::from_utf8(bytes)?;
    let bare = |line: &'_ str| -> String { line.split('#').next().unwrap_or("").trim().to_owned() };
    let mut lines = text.lines().map(bare).filter(|line| !line.is_empty());
    let mut next = || lines.next().ok_or("the file ends early");
    let counts = next()?;
    let mut counts = counts.split_whitespace().map(str::parse::<usize>);
    let (vertices, faces) =
        (counts.next().ok_or("no vertices")??, counts.next().ok_or("no faces")??);
    let mut content = Content::indexed();
    for _ in 0..vertices {
        let line = next()?;
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match *numbers? {
            [x, y, z, ref others @ ..] => {
                content.positions.push([x, y, z]);
                others.iter().for_each(|&number| content.see("number of a vertex", number));
            }
            _ => return Err(format!("a vertex of fewer than three coordinates: {line}").into()),
        }
    }
    for _ in 0..faces {
        let line = next()?;
        let mut numbers = line.split_whitespace();
        let corners: usize = numbers.next().ok_or("an empty face")?.parse()?;
        let face: Result<Vec<u32>, _> = numbers.by_ref().take(corners).map(str::parse).collect();
        let face = face?;
        if face.len() < corners {
            return Err(format!("a face that ends early: {line}").into());
        }
        content.push_face(face);
        for color in numbers {
            content.see("colour of a face", color.parse()?);
        }
    }
    if lines.next().is_some() {
        Err("the file goes on after its faces".into())
    } else {
        Ok(content)
    }
}

fn binary(kind: &str, mut bytes: &[u8]) -> Result<Content, Complaint> {
    let mut next = || -> Result<[u8; 4], Complaint> {
        let (number, rest) = bytes.split_first_chunk::<4>().ok_or("the file ends early")?;
        bytes = rest;
        Ok(*number)
    };
    let mut content = Content::indexed();
    let [vertices, faces, _] = [next()?, next()?, next()?].map(u32::from_be_bytes);
    let others = 3 * usize::from(kind.contains('N'))
        + 4 * usize::from(kind.contains('C'))
        + 2 * usize::from(kind.contains("ST"));
    for _ in 0..vertices {
        content
            .positions
            .push([next()?, next()?, next()?].map(|x| f64::from(f32::from_be_bytes(x))));
        for _ in 0..others {
            content.see("number of a vertex", f64::from(f32::from_be_bytes(next()?)));
        }
    }
    for _ in 0..faces {
        let mut numbers = || -> Result<Vec<[u8; 4]>, Complaint> {
            (0..u32::from_be_bytes(next()?)).map(|_| next()).collect()
        };
        content.push_face(numbers()?.into_iter().map(u32::from_be_bytes));
        for color in numbers()? {
            content.see("colour of a face", f64::from(f32::from_be_bytes(color)));
        }
    }
    if bytes.is_empty() { Ok(content) } else { Err("the file goes on after its faces".into()) }
}

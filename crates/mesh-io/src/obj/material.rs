//! Reading material libraries.

use crate::budget::{Budget, GROWING};
use crate::error::ReadErrorKind;
use crate::external::{Files, open};
use crate::input::{Input, Line, Words, number};
use crate::lost::Lost;
use crate::notes::Notes;
use crate::numbering::Numbering;
use crate::text::quote;
use crate::{Alpha, Image, ImageData, Material};
use std::collections::{BTreeSet, HashSet};
use std::fs::File;

/// The memory of a material, in addition to its name.
pub(super) const COST: u64 = size_of::<Material>() as u64 + 32;

/// The largest number of libraries that are read.
const MOST_LIBRARIES: usize = 1000;

/// A material without properties except its name.
pub(super) fn named(name: String) -> Material {
    Material { name, ..Material::default() }
}

/// The materials with these names, with the data of the libraries, and the pictures that they refer to. A library that
/// is missing or must not be read only causes a note, because the mesh is complete without it.
pub(super) fn read_libraries(
    names: &Numbering,
    libraries: &[String],
    input: &mut Input<'_>,
    files: &Files<'_>,
    notes: &mut Notes,
) -> Result<(Vec<Material>, Vec<Image>), ReadErrorKind> {
    let mut reader = Reader {
        materials: names.names().iter().cloned().map(named).collect(),
        names,
        images: Numbering::default(),
        place: None,
        has_opacity: false,
        unread: BTreeSet::new(),
        notes,
    };
    // A stream has no libraries; this causes no note.
    let libraries = if files.folder.is_some() { libraries } else { &[] };
    let mut known = HashSet::new();
    for library in libraries.iter().take(MOST_LIBRARIES) {
        let opened = files
            .resolve(&library.replace('\\', "/"))
            .and_then(|path| Ok((!known.contains(&path)).then_some((open(&path)?, path))));
        let read = match opened {
            Ok(Some(((mut file, size), path))) => {
                known.insert(path);
                input.add_file(size);
                reader.library(&mut file, size, input)
            }
            Ok(None) => Ok(()),
            Err(reason) => {
                let name = quote(library.as_bytes());
                reader.notes.add(format!("cannot read the material library {name}: {reason}"));
                Ok(())
            }
        };
        match read {
            Err(error @ ReadErrorKind::Memory { .. }) => return Err(error),
            Err(error) => {
                let name = quote(library.as_bytes());
                reader.notes.add(format!("the material library {name} ends early: {error}"));
            }
            Ok(()) => {}
        }
    }
    if libraries.len() > MOST_LIBRARIES {
        let count = libraries.len();
        reader.notes.add(format!("read the first {MOST_LIBRARIES} of {count} material libraries"));
    }
    if !reader.unread.is_empty() {
        let names: Vec<String> = reader.unread.into_iter().collect();
        let why = "a material has a base colour with its texture, opacity and emission";
        let what = format!("material properties {}", names.join(", "));
        reader.notes.lose(Lost::some(what, names.len() as u64, why));
    }
    let image =
        |uri| Image { name: String::new(), media_type: String::new(), data: ImageData::Uri(uri) };
    Ok((reader.materials, reader.images.into_names().into_iter().map(image).collect()))
}

struct Reader<'r> {
    names: &'r Numbering,
    materials: Vec<Material>,
    /// The names of the pictures.
    images: Numbering,
    /// The current material, if the mesh uses it.
    place: Option<u32>,
    /// Whether the current material has a line `d`.
    has_opacity: bool,
    /// Keywords of the materials that are ignored.
    unread: BTreeSet<String>,
    notes: &'r mut Notes,
}

/// The largest number of keywords in a note.
const MOST_KEYWORDS: usize = 20;

impl Reader<'_> {
    fn library(
        &mut self,
        file: &mut File,
        size: u64,
        account: &mut Input<'_>,
    ) -> Result<(), ReadErrorKind> {
        let mut input = Input::new(file, Some(size), Budget::new(Some(u64::MAX)));
        self.place = None;
        while let Some(line) = input.line()? {
            let cost = self.line(line);
            account.spend_on_line(cost)?;
        }
        Ok(())
    }

    /// Processes a line and returns its memory. Invalid lines are skipped.
    fn line(&mut self, line: Line<'_>) -> u64 {
        let mut words = line.words();
        let keyword = words.next().unwrap_or_default();
        if keyword == b"newmtl" {
            let name = String::from_utf8_lossy(words.remainder()).into_owned();
            self.place = self.names.get(&name);
            if let Some(material) =
                self.place.and_then(|place| self.materials.get_mut(place as usize))
            {
                *material = named(name);
            }
            self.has_opacity = false;
            return 0;
        }
        let Some(material) = self.place.and_then(|place| self.materials.get_mut(place as usize))
        else {
            return 0;
        };
        match keyword {
            b"Kd" => {
                if let Some([r, g, b]) = color(words) {
                    material.base_color = [r, g, b, material.base_color[3]];
                }
            }
            b"Ke" => material.emissive = color(words).unwrap_or(material.emissive),
            b"d" => {
                let value = words.find(|word| *word != b"-halo").and_then(number);
                self.has_opacity |= value.is_some();
                set_opacity(material, value);
            }
            // `Tr` is the opposite of `d`. A library may have both; some programs then write `d` twice.
            b"Tr" if !self.has_opacity => {
                set_opacity(material, words.next().and_then(number).map(|value| 1.0 - value));
            }
            b"Tr" => {}
            b"map_Kd" => return self.picture(line, words),
            b"" => {}
            other if self.unread.len() < MOST_KEYWORDS => {
                self.unread.insert(quote(other));
            }
            _ => {}
        }
        0
    }

    fn picture(&mut self, line: Line<'_>, words: Words<'_>) -> u64 {
        let Some(Picture { name, changed }) = Picture::read(words) else { return 0 };
        if changed {
            let keyword = quote(line.text);
            self.notes.add(format!("options of a texture are not applied: {keyword}"));
        }
        let (image, is_new) = self.images.number(&name);
        if let Some(material) = self.place.and_then(|place| self.materials.get_mut(place as usize))
        {
            material.base_color_image = Some(image);
        }
        if is_new { Numbering::COST + GROWING * 80 + name.len() as u64 } else { 0 }
    }
}

fn set_opacity(material: &mut Material, opacity: Option<f64>) {
    if let Some(opacity) = opacity {
        material.base_color[3] = opacity as f32;
        material.alpha = if opacity < 1.0 { Alpha::Blend } else { Alpha::Opaque };
    }
}

/// Three numbers, or one for all three.
fn color(words: Words<'_>) -> Option<[f32; 3]> {
    let mut numbers = words.map_while(number).map(|value| value as f32);
    let r = numbers.next()?;
    match (numbers.next(), numbers.next()) {
        (Some(g), Some(b)) => Some([r, g, b]),
        (None, _) => Some([r; 3]),
        _ => None,
    }
}

/// The argument of `map_Kd`.
struct Picture {
    /// The name of the file, with `/` between its parts.
    name: String,
    /// Whether an option before it changes the appearance of the picture.
    changed: bool,
}

impl Picture {
    /// Options start with a hyphen and are followed by numbers or a word. The rest is the name, which may contain
    /// spaces.
    fn read(mut words: Words<'_>) -> Option<Self> {
        let mut changed = false;
        loop {
            let mut ahead = words.clone();
            let option = ahead.next()?.to_ascii_lowercase();
            // The largest number of arguments, of which all except the first must be numbers, and the neutral argument.
            let (most, neutral) = match option.as_slice() {
                b"-s" => (3, Some(1.0)),
                b"-o" | b"-t" => (3, Some(0.0)),
                b"-mm" => (2, None),
                b"-bm" => (1, None),
                b"-boost" | b"-texres" | b"-blendu" | b"-blendv" | b"-cc" | b"-clamp"
                | b"-imfchan" | b"-type" => (1, Some(f64::NAN)),
                _ => break,
            };
            for argument in 0..most {
                let mut next = ahead.clone();
                let word = next.next().unwrap_or_default();
                let value = number(word);
                // A number at the end is a name.
                if (argument > 0 && value.is_none()) || next.is_at_end() {
                    break;
                }
                changed |= match neutral {
                    Some(neutral) => {
                        value.is_some_and(|value| !neutral.is_nan() && value != neutral)
                    }
                    None => value != Some(if argument == 0 && most == 2 { 0.0 } else { 1.0 }),
                };
                ahead = next;
            }
            words = ahead;
        }
        let name = String::from_utf8_lossy(words.remainder()).replace('\\', "/");
        Some(Self { name, changed })
    }
}

#[cfg(test)]
mod tests {
    use super::Picture;
    use crate::input::Line;

    #[test]
    fn the_name_of_a_picture_is_what_follows_its_options() {
        for (text, name, changed) in [
            ("map_Kd x.png", "x.png", false),
            ("map_Kd -s 1 1 1 x.png", "x.png", false),
            ("map_Kd -s 2 2 1 -o 0.5 my wood.png", "my wood.png", true),
            ("map_Kd -clamp on -blendu off -mm 0 1 sub\\x y.png", "sub/x y.png", false),
            ("map_Kd -o 0 0 0 -s 1 7", "7", false),
            ("map_Kd -bm 1 -imfchan l -texres 512 1.png", "1.png", false),
            ("map_Kd -odd.png", "-odd.png", false),
        ] {
            let line = Line { number: 1, text: text.as_bytes() };
            let mut words = line.words();
            words.next();
            let picture = Picture::read(words).expect(text);
            assert_eq!((picture.name.as_str(), picture.changed), (name, changed), "{text}");
        }
    }

    /// A look at the end of the line for each option would make long lines quadratic.
    #[test]
    fn options_do_not_look_at_the_end_of_the_line() {
        let mut words = Line { number: 1, text: b"  x  " }.words();
        assert!(!words.is_at_end());
        words.next();
        assert!(words.is_at_end() && words.remainder().is_empty());
        let text = format!("{}a.png{}", "-s 1 1 1 ".repeat(50_000), " ".repeat(500_000));
        let picture = Picture::read(Line { number: 1, text: text.as_bytes() }.words());
        assert_eq!(picture.map(|picture| picture.name), Some("a.png".to_owned()));
    }
}

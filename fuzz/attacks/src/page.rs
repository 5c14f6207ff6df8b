//! Pages of meshes whose names are arbitrary text.

use std::collections::HashMap;

use glam::DVec3;
use mesh_io::{Format, Material, Pictures, ReadOptions, Scalars};
use mesh_view::{Exhibit, Field, Lines, On, Page, Section};

/// Puts the text, as lossy UTF-8, everywhere where a page shows text of a file or of a caller. The page must have the
/// same elements as with plain text.
pub fn attack(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let found = elements(&page(&text));
    let plain = elements(&page("plain"));
    assert!(found == plain, "text became markup: {text:?}");
}

/// A page that shows a text as the name of everything.
fn page(text: &str) -> String {
    let mut exhibit = Exhibit {
        name: text.into(),
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
        facts: vec![(text.into(), text.into())],
        ..Exhibit::default()
    };
    let field = Field::new(text, On::Vertices, vec![0.0, 1.0, 2.0]);
    exhibit.fields.push(Field { unit: text.into(), ..field });
    exhibit.lines.push(Lines::through(text, [0; 3], &[DVec3::ZERO, DVec3::X]));
    let mut page = Page::new(text, vec![exhibit, of_file(text)]);
    page.start.color = Some(text.into());
    page.start.overlays.push(text.into());
    page.report.push(Section {
        title: text.into(),
        text: text.into(),
        rows: vec![(text.into(), text.into())],
        header: vec![text.into()],
        lines: vec![vec![text.into()]],
        labels: Some(text.into()),
        folded: false,
    });
    page.to_html().expect("a triangle can be shown")
}

/// A triangle from an OBJ file with the text as the name of its object, group, material and material library, and with
/// numbers and a material of that name.
fn of_file(text: &str) -> Exhibit {
    // Names of OBJ files end with the line, and a backslash at its end continues it.
    let name: String = text.chars().filter(|c| !c.is_control() && *c != '\\').collect();
    let file = format!(
        "mtllib {name}\no {name}\ng {name}\nusemtl {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    );
    let options = ReadOptions { format: Some(Format::Obj), ..ReadOptions::default() };
    let mut model = mesh_io::read_from(&mut file.as_bytes(), &options).expect("an OBJ file");
    model.vertex_scalars.push(Scalars::new(text, vec![0.0, 1.0, 2.0]));
    model.materials = vec![Material { name: text.into(), ..Material::default() }];
    model.face_materials = Some(vec![0]);
    Exhibit::of_model(text, &model, Pictures::default()).expect("a triangle can be shown")
}

/// The start and end tags of a page with the names of their attributes, by a tokenizer that follows the HTML standard
/// where markup can begin. Text of scripts, styles and the title counts by the sequences that change its end.
fn elements(html: &str) -> HashMap<String, usize> {
    let mut found = HashMap::new();
    let mut count = |what: String| *found.entry(what).or_insert(0) += 1;
    let lower = html.to_ascii_lowercase();
    let mut at = 0;
    while let Some(start) = lower[at..].find('<').map(|offset| at + offset) {
        let rest = &lower[start + 1..];
        let is_tag = rest.starts_with(|c: char| c.is_ascii_alphabetic() || "/!?".contains(c));
        at = start + 1;
        if !is_tag {
            continue;
        }
        let (tag, end) = tag(rest);
        at += end;
        let name = tag.split(' ').next().unwrap_or_default().to_owned();
        count(tag);
        if ["script", "style", "title", "textarea"].contains(&name.as_str()) {
            let close = format!("</{name}");
            let text = &lower[at..];
            let text = &text[..text.find(&close).expect("the element ends")];
            for changes in ["<!--", "<script", "-->"] {
                count(format!("{name} text {changes} {}", text.matches(changes).count()));
            }
            at += text.len();
        }
    }
    found
}

/// The name of a tag with the names of its attributes, and its length.
fn tag(rest: &str) -> (String, usize) {
    let (mut shown, mut quote, mut is_value) = (String::new(), None, false);
    for (i, c) in rest.char_indices() {
        match (quote, c) {
            (Some(open), c) if c == open => (quote, is_value) = (None, false),
            (Some(_), _) => {}
            (None, '>') => return (shown, i + 1),
            (None, '"' | '\'') if is_value => quote = Some(c),
            (None, '=') => is_value = true,
            (None, c) if c.is_whitespace() => {
                is_value = false;
                shown.push(' ');
            }
            (None, c) if !is_value => shown.push(c),
            _ => {}
        }
    }
    panic!("a tag without end: {rest:.60}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_a_page_is_seen() {
        let count = |html: &str| elements(html).values().sum::<usize>();
        let plain = "<title>t</title><p class='a'>x &lt; y</p><script>1 < 2</script>";
        assert_eq!(count(plain), 6 + 6);
        assert!(elements(plain) != elements(&plain.replace('t', "</title><b>")));
        assert!(elements(plain) != elements(&plain.replace("&lt; y", "<i>")));
        assert!(elements(plain) != elements(&plain.replace("1 <", "<!-- <script> 1 <")));
        assert!(elements(plain) != elements(&plain.replace("'a'", "'a' onload='b'")));
        assert!(elements(plain) == elements(&plain.replace("x ", "another ")));
    }
}

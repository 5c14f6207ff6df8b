//! Pictures as vectors, for figures of papers.
//!
//! A face is written if it is seen in any sample of the picture, and in no other case; this is decided by a depth
//! buffer that holds the indices of faces. The faces are written from the farthest to the nearest, by the depth of
//! their middle, so that a face that is partly hidden is overdrawn by those in front of it. Where faces pass through
//! each other or differ much in size, this order can be wrong. Every face has one colour: that of its middle. A face
//! between labels is divided where its colours meet. Lines are written if any part of them is seen.

use crate::colorbar::ColorBar;
use crate::error::RenderError;
use crate::legend::{INK, Legend, swatches};
use crate::picture::check_size;
use crate::raster::{Canvas, Cover, EDGE, Triangle, visible};
use crate::render::{camera, canvas, lines, shaded};
use crate::scale::Scale;
use crate::scene::{Scene, Style};
use crate::{camera::View, stroke};

/// A picture as vectors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawing {
    /// The file.
    pub svg: String,
    /// Width and height in pixels, with the legend.
    pub size: [u32; 2],
    /// The number of faces in the file.
    pub faces: usize,
    /// The number of lines in the file.
    pub lines: usize,
}

/// Distance between the rows of a legend, in sizes of letters.
const ROW: f64 = 1.4;
/// Width in pixels of the border that faces have in their own colour, so that no gap shows between neighbours.
const SEAM: f64 = 0.4;

/// Draws a mesh and the lines on it as an SVG file, with a legend and its title to the right. The style means the same
/// as for [`render`](crate::render()).
///
/// # Errors
/// As [`render`](crate::render()).
pub fn draw_svg(
    scene: &Scene<'_>,
    view: &View,
    style: &Style,
    legend: Option<(&Legend, &str)>,
) -> Result<Drawing, RenderError> {
    scene.check()?;
    style.check()?;
    let camera = camera(view, style);
    let normals = style.smooth.then(|| scene.mesh.vertex_normals());
    let mut triangles = shaded(scene, &camera, normals.as_ref(), style.edge_width > 0.0);
    let faces = triangles.len();
    // Without edges, which would be part of the colour.
    let canvas = Canvas { line: 0.0, ..canvas(scene, style) };
    let seen = visible(&canvas, &triangles);
    let mut order: Vec<usize> = (0..faces).filter(|&face| seen[face]).collect();
    let depth = |face: usize| triangles[face].at.iter().map(|corner| corner[2]).sum::<f32>();
    order.sort_by(|&a, &b| depth(b).total_cmp(&depth(a)));

    let lines = lines(scene, style, &camera, normals.as_ref());
    let mut starts = Vec::with_capacity(lines.len() + 1);
    for line in &lines {
        starts.push(triangles.len());
        stroke::draw(line, style.supersampling, &camera, &mut triangles);
    }
    starts.push(triangles.len());
    let seen = visible(&canvas, &triangles);
    let is_seen = |line: usize| seen[starts[line]..starts[line + 1]].iter().any(|&seen| seen);
    let shown: Vec<usize> = (0..lines.len()).filter(|&line| is_seen(line)).collect();

    let mut page = Page { text: String::new(), scale: 1.0 / f64::from(style.supersampling) };
    let [width, height] = style.size;
    let key = legend.map(|(legend, name)| Key::new(legend, name, f64::from(height)));
    let whole = width + key.as_ref().map_or(0, Key::width);
    check_size([u64::from(whole), u64::from(height)])?;
    page.head([whole, height], style);
    let border = trimmed(if style.edge_width > 0.0 { style.edge_width } else { SEAM });
    page.line(&format!(r#"<g id="faces" stroke-linejoin="round" stroke-width="{border}">"#));
    for &face in &order {
        page.face(&canvas, &triangles[face]);
    }
    page.line("</g>");
    page.line(r#"<g id="lines" fill="none" stroke-linecap="round" stroke-linejoin="round">"#);
    for &line in &shown {
        let points: Vec<[f64; 3]> = lines[line].points.iter().map(|&p| camera.project(p)).collect();
        let (color, width) = (hex(lines[line].color), trimmed(lines[line].width));
        // A dot is a line of length zero with round ends.
        let path = page.path(points.iter().chain(points.first().filter(|_| points.len() == 1)));
        page.line(&format!(r#"<path d="{path}" stroke="{color}" stroke-width="{width}"/>"#));
    }
    page.line("</g>");
    if let Some(key) = &key {
        key.write(&mut page, f64::from(width));
    }
    page.line("</svg>");
    let size = [whole, height];
    Ok(Drawing { svg: page.text, size, faces: order.len(), lines: shown.len() })
}

/// The text of a file, and pixels per sample.
struct Page {
    text: String,
    scale: f64,
}

impl Page {
    fn line(&mut self, text: &str) {
        self.text += text;
        self.text.push('\n');
    }

    fn head(&mut self, [width, height]: [u32; 2], style: &Style) {
        self.line(&format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">"#
        ));
        if let Some(color) = style.background {
            let fill = hex(color);
            self.line(&format!(r#"<rect width="100%" height="100%" fill="{fill}"/>"#));
        }
    }

    /// A face, in the colour of its middle; divided if its corners have different labels.
    fn face(&mut self, canvas: &Canvas<'_>, triangle: &Triangle) {
        let corners = triangle.at.map(|p| p.map(f64::from));
        let is_edged = triangle.heights[0].is_finite();
        let [a, b, c] = triangle.color;
        if let Cover::Nearest(light) = triangle.cover
            && (a != b || b != c)
        {
            self.line("<g>");
            let middle = mean(&corners);
            let light = light.iter().sum::<f32>() / 3.0;
            for (i, color) in triangle.color.into_iter().enumerate() {
                let [p, q, r] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
                let part = [p, mean(&[p, q]), middle, mean(&[p, r])];
                let fill = hex_of(color.map(|c| c * light));
                self.polygon(&part, &fill, &fill);
            }
            if is_edged {
                self.polygon(&corners, "none", &hex_of(EDGE));
            }
            return self.line("</g>");
        }
        // The middle of a face that has a hole there has the colour of a corner.
        let fill = hex_of(canvas.shade(triangle, [1.0 / 3.0; 3]).unwrap_or(a));
        let edge = if is_edged { hex_of(EDGE) } else { fill.clone() };
        self.polygon(&corners, &fill, &edge);
    }

    fn polygon(&mut self, points: &[[f64; 3]], fill: &str, stroke: &str) {
        let path = self.path(points);
        self.line(&format!(r#"<path d="{path}Z" fill="{fill}" stroke="{stroke}"/>"#));
    }

    fn word(&mut self, [x, y]: [f64; 2], word: &str) {
        let ([x, y], word) = ([x, y].map(trimmed), escaped(word));
        self.line(&format!(r#"<text x="{x}" y="{y}">{word}</text>"#));
    }

    fn rectangle(&mut self, [x, y]: [f64; 2], size: [f64; 2], fill: &str) {
        let ([x, y], [width, height]) = ([x, y].map(trimmed), size.map(trimmed));
        self.line(&format!(
            r#"<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="{fill}"/>"#
        ));
    }

    /// The points in pixels, to a hundredth.
    fn path<'p>(&self, points: impl IntoIterator<Item = &'p [f64; 3]>) -> String {
        let mut path = String::new();
        for (i, [x, y, _]) in points.into_iter().enumerate() {
            let [x, y] = [x, y].map(|t| trimmed(t * self.scale));
            path += &format!("{}{x} {y}", if i == 0 { 'M' } else { 'L' });
        }
        path
    }
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64)
}

/// A number to a hundredth, in few characters. Numbers that no picture has are cut.
fn trimmed(x: f64) -> String {
    let rounded = (100.0 * x.clamp(-1e6, 1e6)).round() / 100.0;
    // Adding zero turns -0 into 0.
    (if rounded.is_nan() { 0.0 } else { rounded } + 0.0).to_string()
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn hex_of(color: [f32; 3]) -> String {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
    let byte = |c: f32| (255.0 * c).round().clamp(0.0, 255.0) as u8;
    hex(color.map(byte))
}

/// A legend as vectors.
struct Key<'a> {
    legend: &'a Legend,
    name: &'a str,
    height: f64,
    /// The size of letters in pixels.
    letter: f64,
    /// The labels that fit, and the notes below them.
    rows: (Vec<([u8; 3], String)>, Vec<String>),
}

impl<'a> Key<'a> {
    fn new(legend: &'a Legend, name: &'a str, height: f64) -> Self {
        let letter = (height / 36.0).clamp(10.0, 30.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a picture has few rows"
        )]
        let most = (height / (ROW * letter) - 4.0).max(1.0) as usize;
        let rows = match legend {
            Legend::Labels(labels) => swatches(labels, most),
            Legend::Scale(_) => Default::default(),
        };
        Self { legend, name, height, letter, rows }
    }

    /// The width in pixels. Letters differ in width between programs; this is enough for all.
    fn width(&self) -> u32 {
        let beside = match self.legend {
            Legend::Scale(scale) => longest(marks(*scale).iter().map(|(_, text)| text)),
            Legend::Labels(_) => longest(self.rows.0.iter().map(|(_, text)| text)),
        };
        let notes = longest(&self.rows.1);
        let letters = (beside as f64 + 3.5).max(notes.max(self.name.chars().count()) as f64 + 0.5);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast of a float beyond the range gives its end"
        )]
        let width = (0.65 * self.letter * letters.max(8.0) + self.letter).ceil() as u32;
        width
    }

    fn write(&self, page: &mut Page, left: f64) {
        let (letter, x) = (self.letter, left + 0.5 * self.letter);
        let (size, ink) = (trimmed(letter), hex(INK));
        page.line(&format!(
            r#"<g id="legend" font-family="Helvetica, Arial, sans-serif" font-size="{size}" fill="{ink}">"#
        ));
        page.word([x, 1.25 * letter], self.name);
        let top = 2.0 * letter;
        match self.legend {
            Legend::Scale(scale) => self.bar(page, *scale, [x, top]),
            Legend::Labels(_) => {
                let (shown, notes) = &self.rows;
                let mut y = top;
                for (color, label) in shown {
                    page.rectangle([x, y], [letter; 2], &hex(*color));
                    page.word([x + 1.5 * letter, y + 0.85 * letter], label);
                    y += ROW * letter;
                }
                for note in notes {
                    page.word([x, y + 0.85 * letter], note);
                    y += ROW * letter;
                }
            }
        }
        page.line("</g>");
    }

    fn bar(&self, page: &mut Page, scale: Scale, [x, top]: [f64; 2]) {
        const STOPS: u32 = 32;
        let letter = self.letter;
        let tall = (self.height - top - letter).max(1.0);
        page.line(r#"<linearGradient id="colours" x1="0" y1="1" x2="0" y2="0">"#);
        for stop in 0..=STOPS {
            let place = f64::from(stop) / f64::from(STOPS);
            let color = hex(scale.colors.at(place));
            page.line(&format!(r#"<stop offset="{place}" stop-color="{color}"/>"#));
        }
        page.line("</linearGradient>");
        page.rectangle([x, top], [letter, tall], "url(#colours)");
        let [below, above] = scale.beyond;
        for (is_there, y, tip, end) in [(above, top, -0.5, 1.0), (below, top + tall, 0.5, 0.0)] {
            if is_there {
                let corners = [x, x + letter, x + 0.5 * letter, y, y + tip * letter].map(trimmed);
                let [left, right, middle, base, tip] = corners;
                let (color, ink) = (hex(scale.colors.at(end)), hex(INK));
                page.line(&format!(
                    r#"<path fill="{color}" stroke="{ink}" d="M{left} {base}L{right} {base}L{middle} {tip}Z"/>"#
                ));
            }
        }
        for (place, label) in marks(scale) {
            let y = top + (1.0 - place) * tall;
            let [from, to, at] = [x + letter, x + 1.3 * letter, y].map(trimmed);
            let ink = hex(INK);
            page.line(&format!(r#"<path d="M{from} {at}L{to} {at}" stroke="{ink}"/>"#));
            page.word([x + 1.6 * letter, y + 0.35 * letter], &label);
        }
    }
}

fn marks(scale: Scale) -> Vec<(f64, String)> {
    ColorBar::new(scale, "").marks()
}

fn longest<'t>(texts: impl IntoIterator<Item = &'t String>) -> usize {
    texts.into_iter().map(|text| text.chars().count()).max().unwrap_or(0)
}

/// A text for the content of an element. What XML cannot hold becomes `?`.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            // Control letters, marks of direction, and two code points that are none.
            '\0'..='\u{1f}'
            | '\u{7f}'..='\u{9f}'
            | '\u{200e}'
            | '\u{200f}'
            | '\u{202a}'..='\u{202e}'
            | '\u{2066}'..='\u{2069}'
            | '\u{fffe}'
            | '\u{ffff}' => escaped.push('?'),
            other => escaped.push(other),
        }
    }
    escaped
}

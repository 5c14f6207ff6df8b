//! Streams of triangles (`TRIANGLES`).
//!
//! Most triangles share an edge with one of the last 15 edges, and take one byte. New vertices are mostly numbered in
//! the order in which triangles need them.

use super::stream::{Broken, Reader, unzigzag, write_number, zigzag};

const HEADER: u8 = 0xe1;
/// The bytes of the table at the end.
const TABLE: usize = 16;
/// The entries of the table that codes can name; the others must be zero.
const USED: usize = 14;

/// Decodes `count` triangles, and returns their corners.
pub(crate) fn decode(bytes: &[u8], count: usize) -> Result<Vec<u32>, Broken> {
    let (&header, rest) = bytes.split_first().ok_or(Broken::Short)?;
    if header != HEADER {
        return Err(Broken::Header(header));
    }
    let (codes, rest) = rest.split_at_checked(count).ok_or(Broken::Short)?;
    let (data, table) = rest.split_last_chunk::<TABLE>().ok_or(Broken::Short)?;
    let is_sound = |(place, &pair): (usize, &u8)| {
        if place < USED { pair >> 4 != 15 && pair & 15 != 15 } else { pair == 0 }
    };
    if !table.iter().enumerate().all(is_sound) {
        return Err(Broken::Table);
    }
    let mut decoder = Decoder { recent: Recent::new(), next: 0, last: 0, data: Reader(data) };
    let mut corners = Vec::with_capacity(3 * count);
    for &code in codes {
        let triangle = match (code >> 4, code & 15) {
            (15, place @ ..14) => {
                let pair = table.get(usize::from(place)).copied().unwrap_or_default();
                decoder.corners(Corner::Next, pair)?
            }
            (15, kind) => {
                let pair = decoder.data.byte()?;
                // The numbering starts again.
                if pair == 0 {
                    decoder.next = 0;
                }
                let first = if kind == 14 { Corner::Next } else { Corner::Apart };
                decoder.corners(first, pair)?
            }
            (edge, corner) => decoder.beside(edge, corner)?,
        };
        corners.extend(triangle);
    }
    decoder.data.end()?;
    Ok(corners)
}

/// The edges and vertices that were met last, which codes refer to.
struct Recent {
    edges: [[u32; 2]; 16],
    vertices: [u32; 16],
    /// The numbers of edges and vertices so far, modulo 16.
    edge: u8,
    vertex: u8,
}

impl Recent {
    fn new() -> Self {
        // No vertex has this number.
        Self { edges: [[u32::MAX; 2]; 16], vertices: [u32::MAX; 16], edge: 0, vertex: 0 }
    }

    fn push_edge(&mut self, edge: [u32; 2]) {
        self.edges[usize::from(self.edge & 15)] = edge;
        self.edge = self.edge.wrapping_add(1);
    }

    fn push_vertex(&mut self, vertex: u32) {
        self.vertices[usize::from(self.vertex & 15)] = vertex;
        self.vertex = self.vertex.wrapping_add(1);
    }

    /// An edge; 0 is the last one.
    fn edge(&self, age: u8) -> [u32; 2] {
        self.edges[usize::from(self.edge.wrapping_sub(1).wrapping_sub(age) & 15)]
    }

    /// How many vertices ago a vertex was met.
    fn age(&self, vertex: u32) -> Option<u8> {
        (0..16).find(|&age| self.vertex(age) == vertex)
    }

    /// A vertex; 0 is the last one.
    fn vertex(&self, age: u8) -> u32 {
        self.vertices[usize::from(self.vertex.wrapping_sub(1).wrapping_sub(age) & 15)]
    }
}

/// Where a corner comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Corner {
    /// It is the next new vertex.
    Next,
    /// It was met so many vertices ago.
    Recent(u8),
    /// It is stored apart, as the difference from the last such vertex.
    Apart,
}

impl Corner {
    fn of(code: u8) -> Self {
        match code {
            0 => Self::Next,
            15 => Self::Apart,
            age => Self::Recent(age - 1),
        }
    }
}

struct Decoder<'b> {
    recent: Recent,
    /// The next new vertex.
    next: u32,
    /// The last vertex that was stored apart.
    last: u32,
    data: Reader<'b>,
}

impl Decoder<'_> {
    fn corner(&mut self, corner: Corner) -> Result<u32, Broken> {
        match corner {
            Corner::Next => {
                let vertex = self.next;
                self.next = vertex.wrapping_add(1);
                Ok(vertex)
            }
            Corner::Recent(age) => Ok(self.recent.vertex(age)),
            Corner::Apart => {
                self.last = self.last.wrapping_add(unzigzag(self.data.number()?));
                Ok(self.last)
            }
        }
    }

    /// A triangle without an edge of the recent ones; `pair` says where its second and third corner come from.
    fn corners(&mut self, first: Corner, pair: u8) -> Result<[u32; 3], Broken> {
        let (second, third) = (Corner::of(pair >> 4), Corner::of(pair & 15));
        let a = self.corner(first)?;
        let b = self.corner(second)?;
        let c = self.corner(third)?;
        for (corner, vertex) in [(first, a), (second, b), (third, c)] {
            if !matches!(corner, Corner::Recent(_)) {
                self.recent.push_vertex(vertex);
            }
        }
        for edge in [[b, a], [c, b], [a, c]] {
            self.recent.push_edge(edge);
        }
        Ok([a, b, c])
    }

    /// A triangle beside a recent edge.
    fn beside(&mut self, edge: u8, corner: u8) -> Result<[u32; 3], Broken> {
        let [a, b] = self.recent.edge(edge);
        let (c, is_new) = match corner {
            0 => (self.corner(Corner::Next)?, true),
            13 | 14 => {
                let step = if corner == 13 { u32::MAX } else { 1 };
                self.last = self.last.wrapping_add(step);
                (self.last, true)
            }
            15 => (self.corner(Corner::Apart)?, true),
            age => (self.recent.vertex(age), false),
        };
        if is_new {
            self.recent.push_vertex(c);
        }
        self.recent.push_edge([c, b]);
        self.recent.push_edge([a, c]);
        Ok([a, b, c])
    }
}

/// The pairs of second and third corners that take no byte of their own, the usual ones first.
const PAIRS: [u8; TABLE] =
    [0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xa9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0, 0];

/// Encodes triangles. A triangle may start with another of its corners afterwards.
pub(crate) fn encode(triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut encoder = Encoder { recent: Recent::new(), next: 0, last: 0, data: Vec::new() };
    let mut stream = Vec::with_capacity(1 + 2 * triangles.len() + TABLE);
    stream.push(HEADER);
    stream.extend(triangles.iter().map(|&triangle| encoder.triangle(triangle)));
    stream.extend(encoder.data);
    stream.extend(PAIRS);
    stream
}

struct Encoder {
    recent: Recent,
    next: u32,
    last: u32,
    data: Vec<u8>,
}

impl Encoder {
    /// The code of a triangle; what does not fit into it is appended to the data.
    fn triangle(&mut self, triangle: [u32; 3]) -> u8 {
        for edge in 0..15 {
            let [start, end] = self.recent.edge(edge);
            let [a, b, c] = triangle;
            let rotations = [[a, b, c], [b, c, a], [c, a, b]];
            if let Some([a, b, c]) = rotations.into_iter().find(|t| t[0] == start && t[1] == end) {
                return edge << 4 | self.beside([a, b, c]);
            }
        }
        self.alone(triangle)
    }

    /// A triangle whose first edge is one of the recent ones.
    fn beside(&mut self, [a, b, c]: [u32; 3]) -> u8 {
        let age = self.recent.age(c);
        let code = match age {
            Some(age @ 1..13) => age,
            _ if c == self.next => {
                self.next = c.wrapping_add(1);
                0
            }
            _ if c.wrapping_add(1) == self.last => 13,
            _ if c == self.last.wrapping_add(1) => 14,
            _ => 15,
        };
        match code {
            13 | 14 => self.last = c,
            15 => self.apart(c),
            _ => {}
        }
        if !matches!(code, 1..13) {
            self.recent.push_vertex(c);
        }
        self.recent.push_edge([c, b]);
        self.recent.push_edge([a, c]);
        code
    }

    fn alone(&mut self, [a, b, c]: [u32; 3]) -> u8 {
        // A first corner that is new takes no bits.
        let [a, b, c] = match self.next {
            next if b == next => [b, c, a],
            next if c == next => [c, a, b],
            _ => [a, b, c],
        };
        let starts_again = [a, b, c] == [0, 1, 2] && self.next > 0;
        if starts_again {
            self.next = 0;
            // Vertices before are of another mesh.
            self.recent.vertices = [u32::MAX; 16];
        }
        let (second, third) = (self.recent.age(b), self.recent.age(c));
        let first = if self.is_next(a) { 0 } else { 15 };
        let [second, third] = [(second, b), (third, c)].map(|(age, vertex)| match age {
            Some(age @ 0..14) => age + 1,
            _ if self.is_next(vertex) => 0,
            _ => 15,
        });
        let pair = second << 4 | third;
        let place = PAIRS[..USED].iter().position(|&other| other == pair);
        let code = match u8::try_from(place.unwrap_or(USED)) {
            Ok(place @ ..14) if first == 0 && !starts_again => place,
            _ => {
                self.data.push(pair);
                if first == 0 { 14 } else { 15 }
            }
        };
        for (corner, vertex) in [(first, a), (second, b), (third, c)] {
            if corner == 15 {
                self.apart(vertex);
            }
        }
        for (corner, vertex) in [(first, a), (second, b), (third, c)] {
            if matches!(corner, 0 | 15) {
                self.recent.push_vertex(vertex);
            }
        }
        for edge in [[b, a], [c, b], [a, c]] {
            self.recent.push_edge(edge);
        }
        15 << 4 | code
    }

    /// Whether a vertex is the next new one, which is then counted.
    fn is_next(&mut self, vertex: u32) -> bool {
        let is_next = vertex == self.next;
        self.next = self.next.wrapping_add(u32::from(is_next));
        is_next
    }

    fn apart(&mut self, vertex: u32) {
        write_number(&mut self.data, zigzag(vertex.wrapping_sub(self.last).cast_signed()));
        self.last = vertex;
    }
}

//! Meshes of the kinds that CAD programs and scanners make, with random sizes.

use core::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use mesh_core::PolygonSoup;

use crate::parts::{Choices, Parts};

/// A kind of mesh: its name, and a function that makes one from random choices.
type Kind = (&'static str, fn(&mut Choices, f64) -> Parts);

/// All kinds.
const KINDS: [Kind; 26] = [
    ("box", cuboid),
    ("plate", plate),
    ("extrusion", extrusion),
    ("cylinder", cylinder),
    ("cone", cone),
    ("disc", disc),
    ("pipe bend", pipe_bend),
    ("thick pipe", thick_pipe),
    ("flat grid", flat_grid),
    ("flat grid with holes", flat_grid_with_holes),
    ("folded sheet", folded_sheet),
    ("steps", steps),
    ("voxels", voxels),
    ("marching", marching),
    ("marched plate", marched_plate),
    ("height field", height_field),
    ("thin wall", thin_wall),
    ("thin shell", thin_shell),
    ("touching boxes", touching_boxes),
    ("apart", apart),
    ("globe", globe),
    ("dome with holes", dome_with_holes),
    ("outline", outline),
    ("rooms", rooms),
    ("patches", patches),
    ("depth image", depth_image),
];

/// The number of kinds.
#[must_use]
pub fn count() -> usize {
    KINDS.len()
}

/// The name of a kind; kinds repeat after [`count`].
#[must_use]
pub fn name(kind: usize) -> &'static str {
    KINDS[kind % KINDS.len()].0
}

/// The kind of a name.
#[must_use]
pub fn named(name: &str) -> Option<usize> {
    KINDS.iter().position(|kind| kind.0 == name)
}

/// A mesh of a kind. With `density` 1 it has a few hundred to a few thousand faces, with 10 a hundred times as many.
#[must_use]
pub fn mesh(kind: usize, seed: u64, density: f64) -> PolygonSoup {
    let (_, make) = KINDS[kind % KINDS.len()];
    make(&mut Choices::new(seed), density).soup()
}

impl Choices {
    /// A number of cells.
    fn cells(&mut self, low: usize, high: usize, density: f64) -> usize {
        ((self.count(low, high) as f64 * density) as usize).max(1)
    }
}

fn circle(count: usize, radius: f64, height: f64) -> Vec<DVec3> {
    let at = |index| DVec2::from_angle(TAU * index as f64 / count as f64) * radius;
    (0..count).map(|index| at(index).extend(height)).collect()
}

fn cuboid(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts::default();
    let size = DVec3::from_array([0; 3].map(|_| choose.scale(0.2, 3.0)));
    let cells = [0; 3].map(|_| choose.cells(2, 14, density));
    parts.cuboid(DVec3::ZERO, size, cells);
    parts
}

fn plate(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts::default();
    let size =
        DVec3::new(choose.scale(1.0, 10.0), choose.scale(1.0, 10.0), choose.scale(0.01, 0.3));
    let cells =
        [choose.cells(8, 30, density), choose.cells(8, 30, density), choose.cells(1, 2, density)];
    parts.cuboid(DVec3::ZERO, size, cells);
    parts
}

/// A profile along z, with caps as fans from the centre, which sees all of the profile.
fn extrusion(choose: &mut Choices, density: f64) -> Parts {
    let corners = choose.count(3, 12);
    let is_star = choose.one_in(2);
    let radius = |index: usize| if is_star && index % 2 == 1 { 0.5 } else { 1.0 };
    let corner = |index: usize| {
        DVec2::from_angle(TAU * index as f64 / corners as f64) * radius(index % corners)
    };
    let per_side = choose.cells(1, 5, density);
    let mut profile = Vec::new();
    for index in 0..corners {
        let [from, to] = [corner(index), corner(index + 1)];
        profile.extend((0..per_side).map(|i| from.lerp(to, i as f64 / per_side as f64)));
    }
    let (layers, height) = (choose.cells(1, 16, density), choose.scale(0.1, 8.0));
    prism(&profile, layers, height)
}

/// A star, gear or blade, flat or extruded: teeth around a polygon, which is a fan from one of its corners.
fn outline(choose: &mut Choices, density: f64) -> Parts {
    let teeth = choose.cells(8, 200, density);
    let (inner, lean) = (choose.between(0.3, 0.95), choose.between(-0.5, 1.5).clamp(0.0, 1.0));
    let is_flat = choose.one_in(2);
    let height = if is_flat { 0.0 } else { choose.scale(0.01, 1.0) };
    let mut parts = Parts::default();
    let rims = [0.0, height].map(|height| -> Vec<DVec3> {
        let at = |place: f64, radius: f64| {
            (DVec2::from_angle(TAU * place / teeth as f64) * radius).extend(height)
        };
        let tooth = |tooth: usize| [at(tooth as f64, inner), at(tooth as f64 + lean, 1.0)];
        (0..teeth).flat_map(tooth).collect()
    });
    for (side, rim) in rims.iter().enumerate().skip(usize::from(is_flat)) {
        for tooth in 0..teeth {
            let next = rim[(2 * tooth + 2) % rim.len()];
            parts.push([rim[2 * tooth], rim[2 * tooth + 1], next]);
            if tooth > 0 && tooth + 1 < teeth {
                parts.push([rim[0], rim[2 * tooth], next]);
            }
        }
        if side == 0 {
            parts.reverse_from(0);
        }
    }
    if !is_flat {
        parts.ring(&rims[0], &rims[1]);
    }
    parts
}

/// Walls on a floor, or fins on a box: edges of three faces, and of four where walls meet.
fn rooms(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts::default();
    let size = choose.cells(6, 16, density);
    let is_solid = choose.one_in(2);
    let low = if is_solid { choose.between(-3.0, -1.0) } else { 0.0 };
    let high = DVec3::new(size as f64, size as f64, 0.0);
    if is_solid {
        parts.cuboid(DVec3::new(0.0, 0.0, low), high, [size, size, 2]);
    } else {
        parts.grid([size, size], |u, v| high * DVec3::new(u, v, 0.0));
    }
    let (rows, tall) = (choose.count(1, 3), choose.between(0.5, 4.0));
    for wall in 0..choose.count(1, 4) {
        let place = choose.count(1, size - 1) as f64;
        let (from, to) = (choose.count(0, size / 2), choose.count(size / 2 + 1, size));
        let turns = wall % 2 == 1;
        let first = parts.triangles.len();
        parts.grid([to - from, rows], |u, v| {
            let along = from as f64 + u * (to - from) as f64;
            let [x, y] = if turns { [place, along] } else { [along, place] };
            DVec3::new(x, y, v * tall)
        });
        if choose.one_in(2) {
            parts.reverse_from(first);
        }
    }
    parts
}

/// A closed surface whose patches, or even faces, have vertices of their own.
fn patches(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts { is_apart: true, ..Parts::default() };
    let (n, size) = (choose.cells(3, 16, density), choose.scale(0.5, 3.0));
    let is_round = choose.one_in(2);
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
        parts.grid([n, n], |u, v| {
            let mut p = DVec3::splat(sign);
            let [u, v] = if sign > 0.0 { [u, v] } else { [v, u] };
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            // Equal points of two sides are equal bit by bit.
            let p = if is_round { p / (p * p).to_array().iter().sum::<f64>().sqrt() } else { p };
            (p * 1e6).round() / 1e6 * size
        });
    }
    if choose.one_in(3) { parts.scattered() } else { parts }
}

fn prism(profile: &[DVec2], layers: usize, height: f64) -> Parts {
    let mut parts = Parts::default();
    let at = |layer: usize| -> Vec<DVec3> {
        profile.iter().map(|p| p.extend(height * layer as f64 / layers as f64)).collect()
    };
    for layer in 0..layers {
        parts.ring(&at(layer), &at(layer + 1));
    }
    parts.fan(DVec3::Z * height, &at(layers));
    parts.fan(DVec3::ZERO, &at(0).into_iter().rev().collect::<Vec<_>>());
    parts
}

/// Long faces: 5 to 50 times as high as wide, or as wide as high.
fn cylinder(choose: &mut Choices, density: f64) -> Parts {
    let sides = choose.cells(12, 64, density);
    let layers = choose.cells(1, 12, density);
    let aspect = choose.scale(5.0, 50.0);
    let width = TAU / sides as f64;
    let height = if choose.one_in(3) { width / aspect } else { width * aspect };
    let profile: Vec<DVec2> = circle(sides, 1.0, 0.0).iter().map(|p| p.truncate()).collect();
    prism(&profile, layers, height * layers as f64)
}

fn cone(choose: &mut Choices, density: f64) -> Parts {
    let (sides, layers) = (choose.cells(8, 64, density), choose.cells(1, 8, density));
    let (height, top) = (choose.scale(0.2, 5.0), if choose.one_in(2) { 0.0 } else { 0.3 });
    let mut parts = Parts::default();
    let at = |layer: usize| {
        let up = layer as f64 / layers as f64;
        circle(sides, 1.0 + (top - 1.0) * up, height * up)
    };
    for layer in 0..layers {
        parts.ring(&at(layer), &at(layer + 1));
    }
    if top > 0.0 {
        parts.fan(DVec3::Z * height, &at(layers));
    }
    parts.fan(DVec3::ZERO, &at(0).into_iter().rev().collect::<Vec<_>>());
    parts
}

/// Concentric rings, or one fan.
fn disc(choose: &mut Choices, density: f64) -> Parts {
    let (sides, rings) = (choose.cells(8, 120, density), choose.count(1, 6));
    let mut parts = Parts::default();
    let at = |ring: usize| circle(sides, ring as f64, 0.0);
    parts.fan(DVec3::ZERO, &at(1));
    for ring in 1..rings {
        parts.ring(&at(ring + 1), &at(ring));
    }
    parts
}

fn bend(radius: f64, angle: f64) -> impl Fn(f64, f64) -> DVec3 {
    // From the start of the bend to its end, and round the tube.
    move |u, v| {
        let (along, round) = (angle * u, TAU * v);
        let out = 4.0 + radius * round.cos();
        DVec3::new(out * along.cos(), out * along.sin(), radius * round.sin())
    }
}

fn pipe_bend(choose: &mut Choices, density: f64) -> Parts {
    let round = choose.cells(12, 48, density);
    let aspect = choose.scale(5.0, 50.0);
    let angle = choose.between(0.4, 0.9 * PI);
    let width = TAU / round as f64;
    let along = match choose.one_in(2) {
        true => (4.0 * angle / (width * aspect)).ceil() as usize,
        false => (4.0 * angle / width * 0.2 * aspect.sqrt()) as usize,
    };
    let mut parts = Parts::default();
    let surface = bend(1.0, angle);
    parts.grid([along.max(1), round], &surface);
    if choose.one_in(2) {
        let end =
            |u: f64| (0..round).map(|i| surface(u, i as f64 / round as f64)).collect::<Vec<_>>();
        let centre = |u: f64| 4.0 * DVec3::new((angle * u).cos(), (angle * u).sin(), 0.0);
        parts.fan(centre(0.0), &end(0.0));
        parts.fan(centre(1.0), &end(1.0).into_iter().rev().collect::<Vec<_>>());
    }
    parts
}

fn thick_pipe(choose: &mut Choices, density: f64) -> Parts {
    let (round, along) = (choose.cells(12, 40, density), choose.cells(2, 12, density));
    let (inner, angle) = (1.0 - choose.scale(0.01, 0.4), choose.between(0.4, 0.9 * PI));
    let mut parts = Parts::default();
    let (outside, inside) = (bend(1.0, angle), bend(inner, angle));
    parts.grid([along, round], &outside);
    parts.grid([1, round], |u, v| inside(0.0, v).lerp(outside(0.0, v), u));
    let first = parts.triangles.len();
    parts.grid([along, round], &inside);
    parts.grid([1, round], |u, v| inside(1.0, v).lerp(outside(1.0, v), u));
    parts.reverse_from(first);
    parts
}

fn flat_grid(choose: &mut Choices, density: f64) -> Parts {
    let cells = [choose.cells(4, 30, density), choose.cells(4, 30, density)];
    let (long, pattern) = (choose.scale(1.0, 30.0), choose.count(0, 2));
    let jitter = if choose.one_in(2) { 0.3 / cells[0].max(cells[1]) as f64 } else { 0.0 };
    let mut parts = Parts::default();
    let mut random = Choices::new(choose.count(0, 1 << 30) as u64);
    parts.grid_with(
        cells,
        |u, v| DVec3::new(u, v, 0.0),
        |x, y| match pattern {
            0 => false,
            1 => (x + y) % 2 == 0,
            _ => random.one_in(2),
        },
    );
    for point in &mut parts.points {
        let is_inside = |x: f64| x > 1e-9 && x < 1.0 - 1e-9;
        let shift = [jitter * choose.between(-1.0, 1.0), jitter * choose.between(-1.0, 1.0)];
        point.x += if is_inside(point.x) { shift[0] } else { 0.0 };
        point.y += if is_inside(point.y) { shift[1] } else { 0.0 };
        point.x *= long;
    }
    parts
}

fn flat_grid_with_holes(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = flat_grid(choose, density);
    let holes: Vec<(DVec3, f64)> = (0..choose.count(1, 5))
        .map(|_| {
            (
                DVec3::new(choose.between(0.0, 1.0), choose.between(0.0, 1.0), 0.0),
                choose.between(0.03, 0.2),
            )
        })
        .collect();
    let long = parts.points.iter().fold(0.0_f64, |long, p| long.max(p.x));
    let points = &parts.points;
    parts.triangles.retain(|corners| {
        let centre = corners.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 3.0;
        let centre = centre / DVec3::new(long, 1.0, 1.0);
        !holes.iter().any(|&(hole, radius)| centre.distance(hole) < radius)
    });
    if parts.triangles.is_empty() {
        return flat_grid(choose, density);
    }
    parts
}

/// A sheet with straight folds, as bent from metal.
fn folded_sheet(choose: &mut Choices, density: f64) -> Parts {
    let folds = choose.count(1, 4);
    let (per_fold, wide) = (choose.cells(2, 10, density), choose.cells(3, 30, density));
    let (mut at, mut direction) = (DVec2::ZERO, 0.0);
    let mut corners = vec![at];
    for _ in 0..=folds {
        at += DVec2::from_angle(direction);
        corners.push(at);
        direction += choose.between(-1.5, 1.5);
    }
    let width = choose.scale(0.3, 5.0);
    let mut parts = Parts::default();
    let columns = per_fold * (folds + 1);
    parts.grid([columns, wide], |u, v| {
        let along = u * (folds + 1) as f64;
        let piece = (along as usize).min(folds);
        let point = corners[piece].lerp(corners[piece + 1], along - piece as f64);
        DVec3::new(point.x, v * width, point.y)
    });
    parts
}

/// The surface of cells of a lattice, each side divided.
fn lattice(
    is_solid: impl Fn([i32; 3]) -> bool,
    size: [i32; 3],
    cell: DVec3,
    divide: usize,
) -> Parts {
    let mut parts = Parts::default();
    for x in 0..size[0] {
        for y in 0..size[1] {
            for z in 0..size[2] {
                if !is_solid([x, y, z]) {
                    continue;
                }
                let low = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                let at = |u: f64, v: f64, w: f64| (low + DVec3::new(u, v, w)) * cell;
                let cells = [divide, divide];
                let mut side = |[i, j, k]: [i32; 3], point: &dyn Fn(f64, f64) -> DVec3| {
                    if !is_solid([x + i, y + j, z + k]) {
                        parts.grid(cells, point);
                    }
                };
                side([0, 0, 1], &|u, v| at(u, v, 1.0));
                side([0, 0, -1], &|u, v| at(v, u, 0.0));
                side([1, 0, 0], &|u, v| at(1.0, u, v));
                side([-1, 0, 0], &|u, v| at(0.0, v, u));
                side([0, 1, 0], &|u, v| at(v, 1.0, u));
                side([0, -1, 0], &|u, v| at(u, 0.0, v));
            }
        }
    }
    parts
}

fn steps(choose: &mut Choices, density: f64) -> Parts {
    let count = choose.count(2, 6) as i32;
    let wide = choose.count(1, 4) as i32;
    let cell = DVec3::new(choose.scale(0.3, 3.0), choose.scale(0.3, 3.0), choose.scale(0.1, 1.0));
    let is_solid =
        |[x, y, z]: [i32; 3]| x >= 0 && x < count && y >= 0 && y < wide && z >= 0 && z <= x;
    let divide = choose.cells(1, 4, density);
    lattice(is_solid, [count, wide, count], cell, divide)
}

/// Random voxels: edges and vertices with more than one fan occur.
fn voxels(choose: &mut Choices, density: f64) -> Parts {
    let size = 5;
    let solid: Vec<bool> = (0..size * size * size).map(|_| !choose.one_in(4)).collect();
    let is_solid = |at: [i32; 3]| {
        let [x, y, z] = at;
        at.iter().all(|i| (0..size).contains(i)) && solid[((x * size + y) * size + z) as usize]
    };
    lattice(is_solid, [size; 3], DVec3::ONE, choose.cells(1, 2, density))
}

/// The level zero of a function on a lattice, cut out of tetrahedra: many slivers.
fn march(cells: usize, value: impl Fn(DVec3) -> f64) -> Parts {
    let mut parts = Parts::default();
    let step = 2.0 / cells as f64;
    let at = |corner: [usize; 3]| DVec3::from_array(corner.map(|i| i as f64 * step - 1.0));
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    for cell in 0..cells.pow(3) {
        let corner = [cell % cells, cell / cells % cells, cell / cells / cells];
        for order in orders {
            let mut corners = [corner; 4];
            for (step, &axis) in order.iter().enumerate() {
                corners[step + 1] = corners[step];
                corners[step + 1][axis] += 1;
            }
            let points = corners.map(at);
            cut(&mut parts, points, points.map(&value));
        }
    }
    parts
}

/// The cut through one tetrahedron, seen from where values are positive.
fn cut(parts: &mut Parts, points: [DVec3; 4], values: [f64; 4]) {
    let (inside, outside): (Vec<usize>, Vec<usize>) = (0..4).partition(|&i| values[i] < 0.0);
    let between = |i: usize, j: usize| {
        // The same bits from both sides.
        let (i, j) = if points[i].to_array() < points[j].to_array() { (i, j) } else { (j, i) };
        points[i].lerp(points[j], values[i] / (values[i] - values[j]))
    };
    let polygon = match (&inside[..], &outside[..]) {
        (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
            vec![between(a, b), between(a, c), between(a, d)]
        }
        (&[a, b], &[c, d]) => vec![between(a, c), between(a, d), between(b, d), between(b, c)],
        _ => return,
    };
    let centre = |indices: &[usize]| {
        indices.iter().map(|&i| points[i]).sum::<DVec3>() / indices.len() as f64
    };
    let outward = centre(&outside) - centre(&inside);
    for index in 2..polygon.len() {
        let [a, b, c] = [polygon[0], polygon[index - 1], polygon[index]];
        let is_outward = (b - a).cross(c - a).dot(outward) > 0.0;
        parts.push(if is_outward { [a, b, c] } else { [a, c, b] });
    }
}

fn marching(choose: &mut Choices, density: f64) -> Parts {
    let balls: Vec<(DVec3, f64)> = (0..choose.count(1, 3))
        .map(|_| (0.4 * choose.direction(), choose.between(0.25, 0.5)))
        .collect();
    let distance =
        move |p: DVec3| balls.iter().map(|&(c, r)| p.distance(c) - r).fold(9.0, f64::min);
    march(choose.cells(5, 12, density), distance)
}

/// A thin block, turned against the lattice.
fn marched_plate(choose: &mut Choices, density: f64) -> Parts {
    let turn = glam::DQuat::from_axis_angle(choose.direction(), choose.between(0.0, 3.0));
    let half = DVec3::new(0.6, choose.between(0.3, 0.6), choose.between(0.15, 0.3));
    march(choose.cells(7, 12, density), move |p| ((turn * p).abs() - half).max_element())
}

fn height_field(choose: &mut Choices, density: f64) -> Parts {
    let waves: Vec<(DVec2, f64)> = (0..choose.count(2, 6))
        .map(|_| {
            ((choose.direction() * choose.between(3.0, 20.0)).truncate(), choose.scale(0.003, 0.1))
        })
        .collect();
    // Rounded heights, as sensors have.
    let unit = if choose.one_in(2) { 0.01 } else { 1e-6 };
    let mut parts = Parts::default();
    parts.grid([choose.cells(10, 32, density), choose.cells(10, 32, density)], |u, v| {
        let at = DVec2::new(u, v);
        let height = waves.iter().map(|&(wave, size)| size * wave.dot(at).sin()).sum::<f64>();
        DVec3::new(u, v, (height / unit).round() * unit)
    });
    parts
}

/// A height field whose points have no height in some places.
fn depth_image(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = height_field(choose, density);
    for _ in 0..choose.count(1, 5) {
        let (at, radius) =
            (DVec2::from_array([0; 2].map(|_| choose.between(0.0, 1.0))), choose.between(0.0, 0.2));
        let is_near = |p: &&mut DVec3| p.truncate().distance(at) <= radius;
        parts.points.iter_mut().filter(is_near).for_each(|p| p.z = f64::NAN);
    }
    let last = parts.points.len() - 1;
    parts.points[choose.count(0, last)].z = [f64::NAN, f64::INFINITY][choose.count(0, 1)];
    parts.is_apart = true;
    parts
}

/// A bent wall whose sides are close to each other.
fn thin_wall(choose: &mut Choices, density: f64) -> Parts {
    let cells = [choose.cells(6, 24, density), choose.cells(4, 16, density)];
    let (thickness, bend) = (choose.scale(1e-4, 0.05), choose.between(-1.0, 1.0));
    let at = move |u: f64, v: f64, w: f64| {
        let out = DVec2::from_angle(bend * u);
        DVec3::new(u, 0.0, 0.0)
            + DVec3::new(-out.y, 0.0, out.x) * (w * thickness)
            + DVec3::new(0.0, v, 0.5 * bend * u * u)
    };
    let mut parts = Parts::default();
    parts.grid(cells, |u, v| at(u, v, 1.0));
    parts.grid([cells[1], cells[0]], |v, u| at(u, v, 0.0));
    parts.grid([cells[1], 1], |v, w| at(1.0, v, w));
    parts.grid([1, cells[1]], |w, v| at(0.0, v, w));
    parts.grid([1, cells[0]], |w, u| at(u, 1.0, w));
    parts.grid([cells[0], 1], |u, w| at(u, 0.0, w));
    parts
}

/// Two spheres, one inside the other.
fn thin_shell(choose: &mut Choices, density: f64) -> Parts {
    let (round, up) = (choose.cells(12, 32, density), choose.cells(6, 16, density));
    let inner = 1.0 - choose.scale(1e-3, 0.1);
    let mut parts = Parts::default();
    parts.grid([round, up], ball);
    let first = parts.triangles.len();
    parts.grid([round, up], |u, v| inner * ball(u, v));
    parts.reverse_from(first);
    parts
}

/// The unit sphere by longitude and latitude.
fn ball(u: f64, v: f64) -> DVec3 {
    let (round, up) = (TAU * u, PI * (v - 0.5));
    let flat = if v == 0.0 || v == 1.0 { 0.0 } else { up.cos() };
    DVec3::new(flat * round.cos(), flat * round.sin(), up.sin())
}

/// Boxes that share sides, edges and corners; equal vertices are one.
fn touching_boxes(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts::default();
    let divide = choose.cells(2, 5, density);
    let shifts = [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE, DVec3::new(1.0, 0.5, 0.0)];
    parts.cuboid(DVec3::ZERO, DVec3::ONE, [divide; 3]);
    for _ in 0..choose.count(1, 2) {
        let low = shifts[choose.count(0, 3)];
        parts.cuboid(low, low + DVec3::ONE, [divide; 3]);
    }
    parts
}

/// Many small parts, such as screws, beside a large one.
fn apart(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts::default();
    let divide = choose.cells(3, 10, density);
    parts.cuboid(DVec3::ZERO, DVec3::splat(4.0), [divide; 3]);
    for index in 0..choose.count(2, 12) {
        let low = DVec3::new(5.0, 0.7 * index as f64, 0.0);
        let size = choose.scale(0.02, 0.5);
        parts.cuboid(low, low + DVec3::splat(size), [choose.count(1, 3); 3]);
    }
    parts
}

fn globe(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts::default();
    let squeeze = choose.scale(0.05, 5.0);
    let cells = [choose.cells(8, 48, density), choose.cells(4, 24, density)];
    parts.grid(cells, |u, v| ball(u, v) * DVec3::new(1.0, 1.0, squeeze));
    parts
}

/// A hemisphere with round holes and an open rim.
fn dome_with_holes(choose: &mut Choices, density: f64) -> Parts {
    let mut parts = Parts::default();
    let cells = [choose.cells(20, 60, density), choose.cells(8, 20, density)];
    parts.grid(cells, |u, v| ball(u, 0.5 + 0.5 * v));
    let holes: Vec<(DVec3, f64)> = (0..choose.count(1, 4))
        .map(|_| {
            let direction = choose.direction();
            (direction * direction.z.signum(), choose.between(0.1, 0.3))
        })
        .collect();
    let points = &parts.points;
    parts.triangles.retain(|corners| {
        let centre = corners.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 3.0;
        !holes.iter().any(|&(hole, radius)| centre.distance(hole) < radius)
    });
    parts
}

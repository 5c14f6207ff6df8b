//! Accuracy of the curvatures over samples of faces, compared with tables of an independent implementation: no error
//! may be more than 20 % larger.
#![allow(clippy::unwrap_used)]

use crate::common;
use crate::common::{accuracy, inner, mean_edge};
use curvpatch::{CurvatureEstimator, DiscCurvature, Params};
use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::{AnalyticSurface, Irregular, RowPhase, Sphere, add_normal_noise};

#[derive(Clone, Copy, Debug)]
enum Mesh {
    AlignedCylinder,
    StaggeredCylinder,
    UvSphere,
    Icosphere(u32),
    RandomSphere(usize),
    Saddle(usize),
    Torus(usize),
}

impl Mesh {
    fn build(self) -> TriMesh {
        match self {
            Self::AlignedCylinder => common::cylinder(48, 32, RowPhase::Aligned),
            Self::StaggeredCylinder => common::cylinder(48, 32, RowPhase::Staggered),
            Self::UvSphere => common::uv_sphere(24, 48),
            Self::Icosphere(level) => common::icosphere(level),
            Self::RandomSphere(points) => {
                common::mesh(&Sphere::UNIT.random_hull(points, 1).unwrap())
            }
            Self::Saddle(cells) => common::saddle(cells),
            Self::Torus(rings) => common::torus(rings, rings / 2),
        }
    }

    fn surface(self) -> Box<dyn AnalyticSurface> {
        match self {
            Self::AlignedCylinder | Self::StaggeredCylinder => Box::new(common::CYLINDER),
            Self::Saddle(_) => Box::new(common::SADDLE),
            Self::Torus(_) => Box::new(common::TORUS),
            _ => Box::new(Sphere::UNIT),
        }
    }

    fn keep(self) -> fn(&DiscCurvature) -> bool {
        if matches!(self, Self::Saddle(_)) { inner } else { |_| true }
    }
}

/// Medians and 95th percentiles of the errors: curvature in percent, direction in degrees.
type Bands = ([f64; 2], Option<[f64; 2]>);

/// A mesh, the radius in mean edge lengths, the number of samples, and the errors with the parameters of the paper and
/// with the robust ones.
#[derive(Clone, Copy, Debug)]
struct Row(Mesh, f64, usize, Bands, Bands);

/// Medians may exceed the reference by at most 20 %. 95th percentiles may exceed it by at most 30 %, since in some
/// samples three faces determine them. The rounding of the printed numbers is added.
fn check(what: &str, ours: [f64; 2], reference: [f64; 2], rounding: f64) {
    let [median, tail] = [1.2 * reference[0], 1.3 * reference[1]].map(|limit| limit + rounding);
    assert!(ours[0] <= median && ours[1] <= tail, "{what}: {ours:?} against {reference:?}");
}

#[test]
fn curvatures_and_directions_keep_the_bands_of_the_table() {
    for row in TABLE {
        let &Row(kind, edges, samples, paper, robust) = row;
        let mesh = kind.build();
        let radius = edges * mean_edge(&mesh);
        let surface = kind.surface();
        for (params, (curvature, direction)) in
            [(Params::paper(), paper), (Params::robust(), robust)]
        {
            let ours = accuracy(&mesh, surface.as_ref(), params, radius, kind.keep());
            let what = format!("{row:?} {params:?}");
            assert!(ours.samples.abs_diff(samples) <= samples / 50, "{}", ours.samples);
            check(&what, ours.curvature, curvature, 0.005);
            if let Some(direction) = direction {
                check(&what, ours.direction.unwrap(), direction, 0.005);
            }
        }
    }
}

#[rustfmt::skip]
const TABLE: &[Row] = &[
    Row(Mesh::AlignedCylinder, 2.0, 268, ([2.26, 2.26], Some([0.0, 0.0])), ([1.2, 1.2], Some([0.0, 0.0]))),
    Row(Mesh::AlignedCylinder, 3.0, 240, ([0.08, 0.08], Some([0.0, 0.0])), ([0.32, 0.32], Some([0.0, 0.0]))),
    Row(Mesh::AlignedCylinder, 5.0, 192, ([1.01, 1.01], Some([0.0, 0.0])), ([1.16, 1.16], Some([0.0, 0.0]))),
    Row(Mesh::StaggeredCylinder, 2.0, 268, ([10.7, 10.73], Some([0.98, 0.98])), ([1.02, 1.02], Some([0.05, 0.05]))),
    Row(Mesh::StaggeredCylinder, 3.0, 250, ([7.16, 7.16], Some([0.98, 0.98])), ([0.32, 0.32], Some([0.01, 0.01]))),
    Row(Mesh::StaggeredCylinder, 5.0, 202, ([4.3, 4.3], Some([0.98, 0.98])), ([1.1, 1.1], Some([0.02, 0.02]))),
    Row(Mesh::UvSphere, 2.0, 316, ([5.82, 8.57], None), ([2.3, 2.98], None)),
    Row(Mesh::UvSphere, 3.0, 316, ([2.73, 3.84], None), ([0.82, 1.32], None)),
    Row(Mesh::UvSphere, 5.0, 316, ([1.22, 1.65], None), ([0.28, 0.46], None)),
    Row(Mesh::Icosphere(3), 2.0, 320, ([4.53, 5.07], None), ([1.93, 3.43], None)),
    Row(Mesh::Icosphere(3), 3.0, 320, ([1.29, 2.07], None), ([0.99, 1.62], None)),
    Row(Mesh::Icosphere(3), 5.0, 320, ([1.66, 1.91], None), ([0.17, 0.2], None)),
    Row(Mesh::Icosphere(4), 2.0, 302, ([4.08, 5.56], None), ([2.09, 3.07], None)),
    Row(Mesh::Icosphere(4), 3.0, 302, ([1.84, 2.57], None), ([1.02, 1.58], None)),
    Row(Mesh::Icosphere(4), 5.0, 302, ([0.7, 0.9], None), ([0.3, 0.59], None)),
    Row(Mesh::RandomSphere(642), 2.0, 320, ([17.45, 27.68], None), ([10.9, 23.11], None)),
    Row(Mesh::RandomSphere(642), 3.0, 320, ([8.57, 14.02], None), ([4.92, 8.96], None)),
    Row(Mesh::RandomSphere(642), 5.0, 320, ([2.72, 4.21], None), ([1.82, 3.06], None)),
    Row(Mesh::RandomSphere(2562), 2.0, 302, ([16.41, 26.02], None), ([10.57, 24.17], None)),
    Row(Mesh::RandomSphere(2562), 3.0, 302, ([7.95, 13.37], None), ([4.39, 9.49], None)),
    Row(Mesh::RandomSphere(2562), 5.0, 302, ([3.04, 5.17], None), ([1.52, 3.02], None)),
    Row(Mesh::Saddle(32), 2.0, 66, ([1.18, 2.38], Some([1.03, 3.48])), ([0.81, 1.09], Some([0.06, 0.11]))),
    Row(Mesh::Saddle(32), 3.0, 66, ([0.52, 1.17], Some([1.03, 3.07])), ([0.89, 1.05], Some([0.15, 0.2]))),
    Row(Mesh::Saddle(32), 5.0, 66, ([3.77, 4.65], Some([1.03, 2.32])), ([2.05, 2.88], Some([0.38, 0.53]))),
    Row(Mesh::Saddle(64), 2.0, 61, ([1.34, 2.21], Some([1.11, 3.65])), ([0.56, 0.7], Some([0.02, 0.03]))),
    Row(Mesh::Saddle(64), 3.0, 61, ([0.87, 1.17], Some([1.06, 2.91])), ([0.24, 0.39], Some([0.04, 0.05]))),
    Row(Mesh::Saddle(64), 5.0, 61, ([0.9, 1.21], Some([1.06, 2.82])), ([0.6, 0.86], Some([0.1, 0.14]))),
    Row(Mesh::Torus(64), 2.0, 316, ([1.08, 2.67], Some([0.98, 2.36])), ([0.97, 2.13], Some([0.04, 0.09]))),
    Row(Mesh::Torus(64), 3.0, 316, ([1.5, 5.35], Some([0.98, 2.36])), ([1.0, 4.79], Some([0.02, 0.09]))),
    Row(Mesh::Torus(64), 5.0, 316, ([4.83, 13.98], Some([0.98, 2.31])), ([3.6, 13.12], Some([0.04, 0.1]))),
    Row(Mesh::Torus(128), 2.0, 304, ([1.24, 1.28], Some([0.47, 0.49])), ([0.9, 2.12], Some([0.01, 0.03]))),
    Row(Mesh::Torus(128), 3.0, 304, ([0.43, 1.28], Some([0.47, 0.49])), ([0.59, 0.8], Some([0.02, 0.04]))),
    Row(Mesh::Torus(128), 5.0, 304, ([1.39, 4.15], Some([0.47, 0.49])), ([0.86, 3.41], Some([0.01, 0.03]))),
];

/// Median curvature errors in percent.
fn medians(mesh: &TriMesh, surface: &dyn AnalyticSurface, radius: f64, kind: Mesh) -> [f64; 2] {
    [Params::paper(), Params::robust()]
        .map(|params| accuracy(mesh, surface, params, radius, kind.keep()).curvature[0])
}

#[test]
fn errors_converge_as_the_law_of_the_radius_says() {
    // Medians [paper, robust] for a fixed radius of 0.4, for three mean edges, and for 0.9 √h.
    type Level = (Mesh, [[f64; 2]; 3]);
    #[rustfmt::skip]
    let families: [&[Level]; 3] = [
        &[
            (Mesh::Icosphere(2), [[9.625, 5.434], [2.503, 0.706], [7.783, 0.968]]),
            (Mesh::Icosphere(3), [[2.728, 0.711], [1.763, 0.844], [2.900, 1.626]]),
            (Mesh::Icosphere(4), [[0.746, 0.228], [1.860, 1.021], [1.662, 0.785]]),
            (Mesh::Icosphere(5), [[0.474, 0.066], [1.938, 1.067], [0.833, 0.400]]),
        ],
        &[
            (Mesh::Torus(32), [[17.700, 6.296], [7.516, 5.836], [3.653, 2.173]]),
            (Mesh::Torus(64), [[4.498, 1.592], [1.492, 0.843], [2.842, 1.400]]),
            (Mesh::Torus(128), [[0.826, 0.518], [0.424, 0.608], [1.825, 0.600]]),
            (Mesh::Torus(256), [[0.844, 0.400], [0.571, 0.578], [0.403, 0.364]]),
        ],
        &[
            (Mesh::Saddle(16), [[2.194, 1.784], [4.832, 3.148], [1.817, 1.809]]),
            (Mesh::Saddle(32), [[3.842, 1.975], [0.510, 0.911], [0.801, 0.793]]),
            (Mesh::Saddle(64), [[4.113, 2.092], [0.877, 0.253], [0.587, 0.590]]),
            (Mesh::Saddle(128), [[4.076, 2.064], [1.175, 0.130], [0.252, 0.215]]),
        ],
    ];
    for family in families {
        let mut by_root = Vec::new();
        for &(kind, reference) in family {
            let mesh = kind.build();
            let surface = kind.surface();
            let h = mean_edge(&mesh);
            for (radius, reference) in [0.4, 3.0 * h, 0.9 * h.sqrt()].into_iter().zip(reference) {
                let ours = medians(&mesh, surface.as_ref(), radius, kind);
                for (ours, reference) in ours.into_iter().zip(reference) {
                    assert!(ours <= 1.2 * reference + 0.0005, "{kind:?}: {ours}, not {reference}");
                }
            }
            by_root.push(medians(&mesh, surface.as_ref(), 0.9 * h.sqrt(), kind)[1]);
        }
        // A radius in proportion to √h converges: three halvings of h at least halve the error. (The theory predicts an
        // eighth; on saddle and sphere, errors partly cancel.)
        assert!(by_root[3] < 0.5 * by_root[0], "{by_root:?}");
    }
    // A radius in proportion to h does not converge: the error is the same on 64 times as many faces.
    let error = |level: u32| {
        let kind = Mesh::Icosphere(level);
        let mesh = kind.build();
        medians(&mesh, &Sphere::UNIT, 3.0 * mean_edge(&mesh), kind)[1]
    };
    assert!(error(5) > 0.9 * error(2));
}

#[test]
fn noise_is_averaged_by_larger_discs() {
    // Medians and 95th percentiles [paper, robust] for 3, 5 and 8 mean edges.
    type Level = (Mesh, f64, [[[f64; 2]; 2]; 3]);
    #[rustfmt::skip]
    let rows: [Level; 9] = [
        (Mesh::Icosphere(4), 0.01, [[[5.16, 7.31], [2.14, 4.66]], [[1.85, 2.63], [0.67, 1.46]], [[1.32, 1.71], [0.24, 0.50]]]),
        (Mesh::Icosphere(4), 0.03, [[[16.50, 26.09], [6.43, 12.46]], [[6.21, 9.21], [1.97, 4.22]], [[2.08, 3.03], [0.71, 1.45]]]),
        (Mesh::Icosphere(4), 0.1, [[[83.86, 122.05], [21.65, 43.01]], [[34.97, 49.68], [6.79, 14.37]], [[13.75, 19.52], [2.35, 5.09]]]),
        (Mesh::Torus(128), 0.01, [[[2.16, 6.46], [1.19, 2.79]], [[1.39, 4.07], [1.09, 3.17]], [[3.45, 9.42], [2.25, 8.65]]]),
        (Mesh::Torus(128), 0.03, [[[11.30, 24.44], [3.22, 8.00]], [[3.01, 12.25], [1.66, 4.21]], [[3.19, 8.69], [2.37, 8.38]]]),
        (Mesh::Torus(128), 0.1, [[[74.29, 127.66], [11.80, 28.25]], [[31.38, 58.06], [4.33, 10.03]], [[11.00, 29.04], [2.98, 8.59]]]),
        (Mesh::Saddle(64), 0.01, [[[7.60, 14.55], [3.03, 7.26]], [[2.09, 4.98], [1.36, 3.36]], [[1.92, 2.92], [1.32, 2.21]]]),
        (Mesh::Saddle(64), 0.03, [[[45.34, 63.97], [9.48, 21.37]], [[15.92, 26.44], [3.45, 9.15]], [[4.47, 7.99], [1.63, 4.13]]]),
        (Mesh::Saddle(64), 0.1, [[[287.02, 373.87], [30.79, 75.11]], [[126.90, 180.65], [11.34, 29.09]], [[54.54, 79.58], [3.85, 11.33]]]),
    ];
    for (kind, noise, reference) in rows {
        // The saddle has only 61 faces away from its boundary, and their errors are correlated. So the median over
        // several noise seeds is used there.
        let saddle = matches!(kind, Mesh::Saddle(_));
        let seeds = if saddle { 11..20 } else { 11..12 };
        let meshes: Vec<TriMesh> =
            seeds.map(|seed| with_noise(&kind.build(), noise, seed)).collect();
        let surface = kind.surface();
        let h = mean_edge(&kind.build());
        for (edges, [paper, robust]) in [3.0, 5.0, 8.0].into_iter().zip(reference) {
            for (params, reference) in [(Params::paper(), paper), (Params::robust(), robust)] {
                if saddle && params == Params::robust() {
                    // See `noise_on_the_saddle_is_that_of_an_independent_program`.
                    continue;
                }
                let draws = meshes.iter().map(|mesh| {
                    accuracy(mesh, surface.as_ref(), params, edges * h, kind.keep()).curvature
                });
                let (medians, tails) = draws.map(|[median, tail]| (median, tail)).unzip();
                let ours = [medians, tails].map(|values| common::percentiles(values)[0]);
                check(&format!("{kind:?} noise {noise}, {edges} h"), ours, reference, 0.005);
            }
        }
    }
}

/// For the noisy saddle, the robust medians of the table are lower than its own formulas and noise give. A second
/// implementation, in another language, gives the numbers below for seed 11. For no seed from 11 to 19 does it give the
/// value of the table at noise 0.03 and 8 h. So these numbers are the reference.
#[test]
fn noise_on_the_saddle_is_that_of_an_independent_program() {
    // Medians and 95th percentiles [paper, robust] for 3, 5 and 8 mean edges.
    #[rustfmt::skip]
    let rows: [(f64, [[[f64; 2]; 2]; 3]); 3] = [
        (0.01, [[[7.118, 14.392], [3.602, 8.707]], [[1.724, 4.354], [1.330, 2.964]], [[2.077, 2.958], [1.574, 2.305]]]),
        (0.03, [[[45.041, 70.716], [10.461, 26.325]], [[14.953, 24.794], [3.631, 8.165]], [[4.855, 8.758], [2.305, 4.026]]]),
        (0.1, [[[279.751, 375.163], [35.465, 87.810]], [[128.417, 175.436], [12.327, 26.795]], [[55.290, 72.387], [5.221, 12.695]]]),
    ];
    let saddle = Mesh::Saddle(64);
    let h = mean_edge(&saddle.build());
    for (noise, reference) in rows {
        let mesh = with_noise(&saddle.build(), noise, 11);
        for (edges, presets) in [3.0, 5.0, 8.0].into_iter().zip(reference) {
            for (params, reference) in [Params::paper(), Params::robust()].into_iter().zip(presets)
            {
                let surface = saddle.surface();
                let ours = accuracy(&mesh, surface.as_ref(), params, edges * h, saddle.keep());
                for (ours, reference) in ours.curvature.into_iter().zip(reference) {
                    assert!((ours - reference).abs() < 6e-4, "{noise} {edges} {ours} {reference}");
                }
            }
        }
    }
}

fn with_noise(mesh: &TriMesh, noise: f64, seed: u64) -> TriMesh {
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let mut soup = PolygonSoup::from_triangles(mesh.positions(), &triangles).unwrap();
    add_normal_noise(&mut soup, noise, seed);
    common::mesh(&soup)
}

#[test]
fn irregular_spheres_keep_their_bands_where_vertex_based_ones_need_not() {
    // [paper, robust] for 3 h, r = 0.4 and 0.9 √h.
    #[rustfmt::skip]
    let rows: [(u32, [[[f64; 2]; 2]; 3]); 4] = [
        (2, [[[2.58, 3.46], [1.13, 2.14]], [[12.83, 19.29], [6.68, 14.62]], [[9.27, 13.30], [3.53, 7.91]]]),
        (3, [[[2.57, 3.74], [1.06, 2.56]], [[3.71, 5.21], [1.33, 3.36]], [[4.44, 6.20], [1.80, 4.68]]]),
        (4, [[[2.85, 4.13], [1.14, 2.50]], [[0.88, 1.14], [0.33, 0.81]], [[2.46, 3.42], [0.88, 2.16]]]),
        (5, [[[2.91, 3.93], [1.12, 2.66]], [[0.50, 0.58], [0.08, 0.19]], [[1.26, 1.67], [0.41, 1.07]]]),
    ];
    for (level, reference) in rows {
        let irregular = Irregular { jitter: 0.2, seed: 7 };
        let mesh = common::mesh(&Sphere::UNIT.irregular_icosphere(level, irregular).unwrap());
        let h = mean_edge(&mesh);
        for (radius, [paper, robust]) in [3.0 * h, 0.4, 0.9 * h.sqrt()].into_iter().zip(reference) {
            for (params, reference) in [(Params::paper(), paper), (Params::robust(), robust)] {
                let ours = accuracy(&mesh, &Sphere::UNIT, params, radius, |_| true);
                check(&format!("level {level}, r = {radius}"), ours.curvature, reference, 0.005);
            }
        }
    }
}

/// SN10 takes principal directions from "the maximal and minimal diameters". A chord for κ is as short as one for -κ,
/// so on a saddle the longest chord lies along an asymptotic direction.
#[test]
fn literal_diameters_fail_on_a_saddle() {
    let mesh = common::saddle(32);
    let radius = 2.5 * mean_edge(&mesh);
    let params = Params { planes: 36, ..Params::paper() };
    let estimator = CurvatureEstimator::new(&mesh, params).unwrap();
    let mut literal = Vec::new();
    let mut directions = Vec::new();
    for face in common::sample(&mesh, 300) {
        let disc = estimator.at(face, radius).unwrap();
        if disc.truncated || !inner(&disc) {
            continue;
        }
        let exact = common::SADDLE.principal_curvatures(disc.center);
        let traces = (0..36).map(|i| {
            let angle = core::f64::consts::PI * f64::from(i) / 36.0;
            (angle, estimator.trace(face, &disc, angle))
        });
        let longest = traces.max_by(|a, b| a.1.chord().total_cmp(&b.1.chord())).unwrap();
        let scale = exact.max.max(-exact.min);
        // It should be the smaller of the two curvatures, but neither of them is small.
        let smaller = exact.max.min(-exact.min);
        literal.push(100.0 * (smaller - longest.1.curvature.abs()) / scale);
        let angle = longest.0.to_degrees() % 90.0;
        directions.push(angle.min(90.0 - angle));
    }
    let [wrong, _] = common::percentiles(literal);
    assert!(wrong > 80.0, "{wrong}");
    let [turned, _] = common::percentiles(directions);
    assert!(turned > 20.0, "{turned}");
    let signed = accuracy(&mesh, &common::SADDLE, params, radius, inner).curvature[0];
    assert!(signed < 3.0, "{signed}");
}

//! Single faces of analytic meshes, compared with an independent implementation in all printed digits.
#![allow(clippy::unwrap_used)]

use crate::common;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use curvpatch::{CurvatureEstimator, FitTest, Params, PointClass, Shape};
use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_shapes::RowPhase;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mesh {
    BareHalfCylinder,
    AlignedCylinder,
    StaggeredCylinder,
    UvSphere,
    Icosphere,
    Saddle,
    Torus,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Preset {
    Paper,
    Robust,
}

/// Reference values for `r_g` = 0.4, in the convention of SN10.
///
/// The curvature with the larger absolute value is first. Curvatures are positive where the surface bends
/// towards the normal: the sign is opposite to that of the library. Errors are in percent of the radius.
#[derive(Debug)]
struct Row {
    mesh: Mesh,
    face: u32,
    preset: Preset,
    k: [f64; 2],
    tau: f64,
    truncated: bool,
    normal: [f64; 3],
    e1: [f64; 3],
    q: [f64; 3],
    errors: [f64; 4],
}

const RADIUS: f64 = 0.4;

fn build(which: Mesh) -> TriMesh {
    match which {
        Mesh::BareHalfCylinder => common::bare_half_cylinder(),
        Mesh::AlignedCylinder => common::cylinder(48, 32, RowPhase::Aligned),
        Mesh::StaggeredCylinder => common::cylinder(48, 32, RowPhase::Staggered),
        Mesh::UvSphere => common::uv_sphere(24, 48),
        Mesh::Icosphere => common::icosphere(3),
        Mesh::Saddle => common::saddle(32),
        Mesh::Torus => common::torus(64, 32),
    }
}

#[test]
fn curvatures_translations_and_frames_are_reproduced() {
    // A straight section has S - d = 0 up to a few units in the last place. The third-order rule takes the square root
    // of this difference.
    let straight = (24.0 * 8.0 * f64::EPSILON).sqrt() / (2.0 * RADIUS);
    for row in ROWS {
        let mesh = build(row.mesh);
        let params = match row.preset {
            Preset::Paper => Params::paper(),
            Preset::Robust => Params::robust(),
        };
        let estimator = CurvatureEstimator::new(&mesh, params).unwrap();
        let fit = estimator.patch(FaceId::new(row.face), RADIUS, Shape::Circle).unwrap();
        let axes = common::sn10_order(&fit.curvature);
        for (ours, theirs) in axes.map(|axis| fit.curvature.curvatures[axis]).into_iter().zip(row.k)
        {
            let noise = ours.abs().max(theirs.abs()) < straight && row.preset == Preset::Paper;
            assert!((ours + theirs).abs() < 1e-8 || noise, "{row:?}: {ours}");
        }
        assert!((fit.patch.translation() - row.tau).abs() < 1e-8, "{row:?}: {fit:?}");
        assert_eq!(fit.curvature.truncated, row.truncated, "{row:?}");
        assert!(!fit.curvature.wrapped && !fit.curvature.face_normal_kept);
        let normal = fit.curvature.normal();
        assert!(normal.distance(DVec3::from_array(row.normal)) < 2e-8, "{row:?} {normal}");
        if fit.curvature.class() == PointClass::Umbilic {
            continue;
        }
        let e1 = fit.curvature.frame[axes[0]];
        let theirs = DVec3::from_array(row.e1);
        assert!(e1.distance(theirs).min(e1.distance(-theirs)) < 2e-8, "{row:?}: {e1}");
        // A direction with the opposite sign rotates the patch by half a turn.
        let turn = if e1.dot(theirs) > 0.0 { 0.0 } else { core::f64::consts::PI };
        let start = FRAC_PI_2 * axes[0] as f64;
        let q = fit.patch.point(1.0, start + FRAC_PI_4 + turn);
        assert!(q.distance(DVec3::from_array(row.q)) < 3e-8, "{row:?}: {q}");
        if turn > 0.0 {
            continue;
        }
        let errors = FitTest::new(&mesh).quarter_errors(&fit);
        for (ours, theirs) in errors.into_iter().zip(row.errors) {
            assert!((100.0 * ours / RADIUS - theirs).abs() < 1e-4, "{row:?}: {errors:?}");
        }
    }
}

#[rustfmt::skip]
const ROWS: &[Row] = &[
    Row { mesh: Mesh::BareHalfCylinder, face: 22, preset: Preset::Paper, k: [-1.017_455_407_4, 0.0], tau: 0.0, truncated: false, normal: [0.065_403_13, 0.997_858_92, 0.0], e1: [-0.997_858_92, 0.065_403_13, 0.0], q: [-0.233_626_55, 0.975_087_01, 2.282_842_71], errors: [1.774_9, 1.423_8, 0.650_5, 0.0] },
    Row { mesh: Mesh::BareHalfCylinder, face: 22, preset: Preset::Robust, k: [-1.001_720_975_9, 0.004_439_058_2], tau: 0.0, truncated: false, normal: [0.043_118_3, 0.999_069_97, 0.0], e1: [0.999_069_97, -0.043_118_3, 0.0], q: [0.316_890_39, 0.945_954_88, 1.717_157_44], errors: [0.085_5, 0.489_9, 0.235_5, 0.088_8] },
    Row { mesh: Mesh::BareHalfCylinder, face: 24, preset: Preset::Paper, k: [-1.017_455_407_4, 0.0], tau: 0.0, truncated: false, normal: [-0.065_403_13, 0.997_858_92, 0.0], e1: [-0.997_858_92, -0.065_403_13, 0.0], q: [-0.358_902_24, 0.936_250_62, 2.282_842_71], errors: [1.774_9, 1.423_8, 0.650_5, 0.0] },
    Row { mesh: Mesh::BareHalfCylinder, face: 24, preset: Preset::Robust, k: [-1.001_720_975_9, 0.004_439_058_2], tau: 0.0, truncated: false, normal: [-0.087_655_39, 0.996_150_86, 0.0], e1: [0.996_150_86, 0.087_655_39, 0.0], q: [0.190_707_46, 0.979_224_6, 1.717_157_44], errors: [0.085_5, 0.489_9, 0.235_5, 0.088_8] },
    Row { mesh: Mesh::BareHalfCylinder, face: 1, preset: Preset::Paper, k: [-1.019_320_197_1, 0.000_000_128_3], tau: 0.0, truncated: true, normal: [0.997_858_92, 0.065_403_13, 0.0], e1: [0.065_387_59, -0.997_621_87, 0.021_795_86], q: [0.975_412_72, -0.239_689_51, 3.723_219_89], errors: [88.638_9, 75.905, 39.919_3, 0.0] },
    Row { mesh: Mesh::BareHalfCylinder, face: 1, preset: Preset::Robust, k: [-0.782_640_073_0, 0.021_937_229_9], tau: 0.0, truncated: true, normal: [0.996_686_95, 0.081_333_45, -4.169e-05], e1: [0.081_333_42, -0.996_685_96, 0.001_403_91], q: [0.989_726_16, -0.236_665_31, 3.717_553_08], errors: [88.812_2, 75.228_9, 38.558_3, 0.436_8] },
    Row { mesh: Mesh::AlignedCylinder, face: 1536, preset: Preset::Paper, k: [-1.017_455_407_4, 0.0], tau: 0.0, truncated: false, normal: [0.997_858_92, 0.065_403_13, 0.0], e1: [-0.065_403_13, 0.997_858_92, 0.0], q: [0.936_250_62, 0.358_902_24, 2.324_509_38], errors: [1.774_9, 1.423_8, 0.650_5, 0.0] },
    Row { mesh: Mesh::AlignedCylinder, face: 1536, preset: Preset::Robust, k: [-1.001_720_975_9, 0.004_439_058_2], tau: 0.001_899_738_3, truncated: false, normal: [0.996_150_86, 0.087_655_39, 0.0], e1: [-0.087_655_39, 0.996_150_86, 0.0], q: [0.932_847_87, 0.358_009_02, 2.324_509_23], errors: [0.348, 0.254_7, 0.180_6, 0.563_6] },
    Row { mesh: Mesh::AlignedCylinder, face: 1537, preset: Preset::Paper, k: [-1.016_988_401_7, 0.000_000_072_1], tau: 0.0, truncated: false, normal: [0.997_858_92, 0.065_403_13, 0.0], e1: [0.065_386_29, -0.997_601_98, 0.022_692_03], q: [0.975_520_49, -0.239_966_26, 1.806_806_17], errors: [1.774_6, 1.856_7, 1.158_4, 0.0] },
    Row { mesh: Mesh::AlignedCylinder, face: 1537, preset: Preset::Robust, k: [-1.003_365_912_3, 0.006_818_591_9], tau: 0.001_898_787_4, truncated: false, normal: [0.999_068_59, 0.043_149_1, 0.000_333_94], e1: [0.043_149_11, -0.999_068_64, -1.756e-05], q: [0.971_729_44, -0.233_151_07, 1.800_473_65], errors: [0.318_2, 0.258_6, 0.235_6, 0.644_3] },
    Row { mesh: Mesh::StaggeredCylinder, face: 1536, preset: Preset::Paper, k: [-1.008_681_528_9, 0.074_016_556_2], tau: 0.0, truncated: false, normal: [0.997_712_57, 0.065_393_54, -0.017_126_1], e1: [-0.065_403_13, 0.997_858_92, 0.0], q: [0.946_508_39, 0.337_858_92, 2.325_057_55], errors: [0.154_1, 0.738_1, 2.480_6, 3.119_6] },
    Row { mesh: Mesh::StaggeredCylinder, face: 1536, preset: Preset::Robust, k: [-0.998_778_286_8, 0.002_939_030_6], tau: 0.001_421_152_9, truncated: false, normal: [0.997_858_86, 0.065_403_12, -0.000_363_53], e1: [0.065_403_13, -0.997_858_92, 0.0], q: [0.976_539_87, -0.211_963_54, 1.758_837_81], errors: [0.372_7, 0.224_3, 0.105_5, 0.092_2] },
    Row { mesh: Mesh::StaggeredCylinder, face: 1537, preset: Preset::Paper, k: [-1.007_107_857_5, 0.074_383_932_8], tau: 0.0, truncated: false, normal: [0.991_299_45, 0.130_507_05, 0.017_126_1], e1: [0.131_119_47, -0.990_493_95, -0.041_586_38], q: [0.992_935_86, -0.134_803_01, 1.788_741_99], errors: [0.160_5, 0.001_2, 1.782_9, 3.124] },
    Row { mesh: Mesh::StaggeredCylinder, face: 1537, preset: Preset::Robust, k: [-0.999_920_171_2, 0.003_716_368_1], tau: 0.001_421_438_9, truncated: false, normal: [0.991_437_86, 0.130_578_41, 0.000_501_05], e1: [0.130_578_36, -0.991_437_98, 0.000_147_27], q: [0.988_560_02, -0.147_635_24, 1.800_512_33], errors: [0.355_5, 0.106_9, 0.434_4, 0.408_4] },
    Row { mesh: Mesh::UvSphere, face: 0, preset: Preset::Paper, k: [-1.021_391_263_9, -0.999_439_717_5], tau: 0.001_946_304_1, truncated: false, normal: [0.065_402_53, 0.004_286_71, 0.997_849_75], e1: [0.764_224_07, 0.642_781_7, -0.052_851_25], q: [0.115_065_52, 0.393_078_62, 0.912_809_75], errors: [1.888_6, 1.038_3, 0.128_9, 0.759_8] },
    Row { mesh: Mesh::UvSphere, face: 0, preset: Preset::Robust, k: [-1.007_692_275_0, -0.996_639_013_2], tau: 0.001_933_699_7, truncated: false, normal: [0.086_991_07, 0.005_715_64, 0.996_192_7], e1: [0.993_823_59, 0.068_663_33, -0.087_178_14], q: [0.334_501_89, 0.298_892_89, 0.893_504_03], errors: [0.374_4, 0.429_6, 0.618_9, 0.304_8] },
    Row { mesh: Mesh::UvSphere, face: 1100, preset: Preset::Paper, k: [-1.025_024_612_4, -0.996_671_225_9], tau: 0.003_826_467_3, truncated: false, normal: [0.978_694_3, -0.194_674_4, 0.065_263_69], e1: [0.161_973_58, 0.927_366_65, 0.337_276_82], q: [0.907_139_04, -0.033_519_69, 0.389_946_54], errors: [2.314_4, 2.366_4, 1.863_2, 0.556_9] },
    Row { mesh: Mesh::UvSphere, face: 1100, preset: Preset::Robust, k: [-0.995_293_790_4, -0.990_714_186_9], tau: 0.003_774_956_5, truncated: false, normal: [0.975_342_78, -0.216_382_56, 0.043_417_26], e1: [0.217_983_17, 0.975_277_96, -0.036_279_87], q: [0.949_427_54, 0.081_807_97, 0.305_332_34], errors: [0.958_3, 0.744_8, 0.477_5, 1.139_9] },
    Row { mesh: Mesh::UvSphere, face: 1101, preset: Preset::Paper, k: [-1.028_292_920_5, -0.994_926_366_1], tau: 0.003_850_545_7, truncated: false, normal: [0.978_694_3, -0.194_674_4, 0.065_263_69], e1: [0.205_203, 0.916_536_84, -0.343_295_71], q: [0.961_345_74, 0.190_828_66, 0.245_746_16], errors: [1.757_7, 2.763_3, 3.663_3, 3.645_4] },
    Row { mesh: Mesh::UvSphere, face: 1101, preset: Preset::Robust, k: [-0.995_196_875_4, -0.990_622_100_2], tau: 0.003_758_592_0, truncated: false, normal: [0.981_089_26, -0.172_722_49, 0.087_354_52], e1: [0.178_004_1, 0.982_392_45, -0.056_741_69], q: [0.932_218_23, 0.130_913_38, 0.338_869_48], errors: [1.032_1, 0.670_3, 0.907_6, 0.815_5] },
    Row { mesh: Mesh::Icosphere, face: 0, preset: Preset::Paper, k: [-1.016_960_015_8, -0.984_103_649_3], tau: 0.003_604_183_5, truncated: false, normal: [-0.546_249_63, 0.833_679_43, 0.081_178_45], e1: [0.678_359_99, 0.383_452_97, 0.626_730_84], q: [-0.178_726_17, 0.985_319_72, 0.023_476_55], errors: [0.193, 0.624_2, 1.635_5, 1.764_9] },
    Row { mesh: Mesh::Icosphere, face: 0, preset: Preset::Robust, k: [-0.996_146_992_1, -0.990_507_589_0], tau: 0.003_570_339_3, truncated: false, normal: [-0.543_789_17, 0.836_213_59, 0.070_994_16], e1: [0.834_672_4, 0.530_106_01, 0.149_363_98], q: [-0.247_307_35, 0.955_248_18, -0.165_121_72], errors: [0.699_9, 0.901_7, 0.590_2, 0.976] },
    Row { mesh: Mesh::Icosphere, face: 640, preset: Preset::Paper, k: [-1.016_960_015_8, -0.984_103_649_3], tau: 0.003_604_183_5, truncated: false, normal: [0.546_249_63, -0.833_679_43, 0.081_178_45], e1: [-0.678_359_99, -0.383_452_97, 0.626_730_84], q: [0.178_726_17, -0.985_319_72, 0.023_476_55], errors: [0.193, 0.624_2, 1.635_5, 1.764_9] },
    Row { mesh: Mesh::Icosphere, face: 640, preset: Preset::Robust, k: [-0.996_146_992_1, -0.990_507_589_0], tau: 0.003_570_339_3, truncated: false, normal: [0.543_789_17, -0.836_213_59, 0.070_994_16], e1: [-0.834_672_4, -0.530_106_01, 0.149_363_98], q: [0.247_307_35, -0.955_248_18, -0.165_121_72], errors: [0.699_9, 0.901_7, 0.590_2, 0.976] },
    Row { mesh: Mesh::Icosphere, face: 1279, preset: Preset::Paper, k: [-1.014_300_000_7, -0.986_695_357_3], tau: 0.004_530_637_4, truncated: false, normal: [0.934_172_36, 0.356_822_09, 0.0], e1: [0.122_040_34, -0.319_505_76, 0.939_692_62], q: [0.986_370_64, -0.001_161_81, 0.164_307_33], errors: [0.640_7, 0.500_9, 0.980_8, 0.494_5] },
    Row { mesh: Mesh::Icosphere, face: 1279, preset: Preset::Robust, k: [-0.980_531_608_4, -0.980_531_608_4], tau: 0.004_439_818_2, truncated: false, normal: [0.934_172_36, 0.356_822_09, 0.0], e1: [0.159_989_82, -0.418_858_78, -0.893_845_95], q: [0.817_930_19, 0.443_867_07, -0.369_978_47], errors: [0.885_6, 0.875_2, 0.970_4, 1.184_5] },
    Row { mesh: Mesh::Saddle, face: 1055, preset: Preset::Paper, k: [0.954_665_176_9, -0.954_022_613_0], tau: 0.0, truncated: false, normal: [0.031_219_53, 0.031_219_53, 0.999_024_87], e1: [-0.999_512_55, 0.000_975_13, 0.031_204_29], q: [-0.296_716_57, -0.233_956_4, 0.016_608_33], errors: [0.999_2, 0.327_5, 0.276_2, 0.589_7] },
    Row { mesh: Mesh::Saddle, face: 1055, preset: Preset::Robust, k: [0.970_456_510_4, -0.969_121_084_0], tau: -0.000_000_825_2, truncated: false, normal: [0.020_200_3, 0.040_040_87, 0.998_993_83], e1: [0.999_795_87, -0.000_407_26, -0.020_200_19], q: [0.254_793_17, 0.317_147_05, -0.017_215_32], errors: [0.148_7, 0.249_3, 0.073_7, 0.342] },
    Row { mesh: Mesh::Saddle, face: 1020, preset: Preset::Paper, k: [-0.719_812_318_3, 0.483_960_518_8], tau: 0.0, truncated: true, normal: [-0.671_339_47, -0.023_149_64, 0.740_788_38], e1: [-0.015_545_43, 0.999_732_01, 0.017_153_58], q: [0.689_461_56, 0.237_424_68, 0.209_538_89], errors: [0.543, 0.047_1, 0.247_7, 0.530_5] },
    Row { mesh: Mesh::Saddle, face: 1020, preset: Preset::Robust, k: [-0.738_667_791_5, 0.428_050_356_0], tau: -0.000_017_894_6, truncated: true, normal: [-0.666_262_81, -0.030_049_05, 0.745_111_35], e1: [-0.013_899_2, 0.999_514_63, 0.027_880_33], q: [0.690_278_97, 0.239_625_37, 0.211_464_88], errors: [0.246_3, 0.536_7, 0.109, 0.984_2] },
    Row { mesh: Mesh::Saddle, face: 300, preset: Preset::Paper, k: [0.669_104_132_8, -0.534_632_734_1], tau: 0.0, truncated: true, normal: [-0.313_275_75, -0.554_257_1, 0.771_140_31], e1: [-0.948_616_15, 0.144_535_28, -0.281_490_58], q: [0.162_396_63, -0.921_793_39, -0.413_910_08], errors: [0.736_8, 0.358_2, 0.667_5, 11.791_4] },
    Row { mesh: Mesh::Saddle, face: 300, preset: Preset::Robust, k: [0.672_764_573_9, -0.519_887_875_9], tau: 0.000_005_009_4, truncated: true, normal: [-0.312_011_34, -0.554_860_32, 0.771_219_13], e1: [0.945_722_39, -0.103_741_62, 0.307_972_14], q: [0.653_539_97, -0.529_710_38, 0.068_118_25], errors: [0.730_2, 0.728_2, 0.632_1, 0.888_7] },
    Row { mesh: Mesh::Torus, face: 0, preset: Preset::Paper, k: [-1.043_086_096_3, -0.336_307_488_0], tau: 0.007_718_781_8, truncated: false, normal: [0.993_997_48, 0.048_831_96, 0.097_900_21], e1: [-0.097_782_28, -0.004_803_74, 0.995_196_24], q: [2.924_416_71, -0.089_850_91, 0.333_832_75], errors: [2.126, 3.722_4, 1.421_8, 0.190_7] },
    Row { mesh: Mesh::Torus, face: 0, preset: Preset::Robust, k: [-0.992_088_881_9, -0.301_134_922_6], tau: 0.007_146_989_2, truncated: false, normal: [0.995_944_85, 0.063_055_55, 0.064_170_56], e1: [-0.064_011_03, -0.004_549_04, 0.997_938_82], q: [2.940_328_47, -0.090_219_05, 0.336_973_48], errors: [2.015_9, 0.514_1, 2.050_3, 2.154_6] },
    Row { mesh: Mesh::Torus, face: 15, preset: Preset::Paper, k: [-1.045_769_546_8, -0.047_434_971_4], tau: 0.004_810_503_5, truncated: false, normal: [0.098_016, 0.004_815_22, 0.995_173_19], e1: [-0.994_890_41, -0.023_848_98, 0.098_103_55], q: [1.791_648_52, -0.224_132_24, 0.983_108_29], errors: [3.451_2, 2.469_4, 1.214_7, 1.371_9] },
    Row { mesh: Mesh::Torus, face: 15, preset: Preset::Robust, k: [-0.997_980_059_5, -0.016_013_069_5], tau: 0.004_422_206_1, truncated: false, normal: [0.073_278_42, 0.002_245_53, 0.997_308_99], e1: [-0.996_808_66, -0.031_586_92, 0.073_312_78], q: [1.793_655_61, -0.226_132_86, 0.978_248_76], errors: [1.889_2, 0.926_5, 0.335_2, 1.723_5] },
    Row { mesh: Mesh::Torus, face: 16, preset: Preset::Paper, k: [-1.046_329_242_8, 0.079_921_065_6], tau: 0.0, truncated: false, normal: [-0.098_016, -0.004_815_22, 0.995_173_19], e1: [-0.993_974_46, -0.048_830_83, -0.098_134_21], q: [1.673_465_93, -0.171_366_97, 0.928_776_27], errors: [3.913_1, 4.824_5, 2.832, 0.736_2] },
    Row { mesh: Mesh::Torus, face: 16, preset: Preset::Robust, k: [-0.998_270_701_0, 0.042_942_870_5], tau: 0.004_026_025_4, truncated: false, normal: [-0.054_015_25, -0.003_507_16, 0.998_533_95], e1: [-0.996_449_29, -0.064_489_27, -0.054_128_99], q: [1.674_538_98, -0.175_564_26, 0.945_075_5], errors: [2.225_7, 0.128_2, 0.440_7, 0.850_8] },
    Row { mesh: Mesh::Torus, face: 33, preset: Preset::Paper, k: [-1.042_209_760_1, 0.990_186_944_4], tau: 0.0, truncated: false, normal: [-0.993_997_48, -0.048_831_96, -0.097_900_21], e1: [0.096_181_07, 0.036_398_49, -0.994_698_12], q: [1.053_944_46, -0.231_596_82, -0.411_803_08], errors: [2.335_4, 3.195_8, 2.242_1, 1.381_6] },
    Row { mesh: Mesh::Torus, face: 33, preset: Preset::Robust, k: [-1.020_451_380_9, 0.992_827_505_2], tau: 0.003_263_214_6, truncated: false, normal: [-0.990_139_29, -0.032_188_76, -0.136_338_05], e1: [0.136_265, 0.004_462_64, -0.990_662_37], q: [1.055_424_88, -0.240_864_23, -0.402_854_85], errors: [0.235_6, 0.764_3, 1.793_1, 0.990_8] },
    Row { mesh: Mesh::Torus, face: 1000, preset: Preset::Paper, k: [-1.044_978_957_1, 0.475_595_410_3], tau: 0.0, truncated: false, normal: [-0.031_150_62, -0.634_085_41, -0.772_635_31], e1: [0.037_911_42, 0.771_704_64, -0.634_850_12], q: [0.334_148_85, 1.553_599_9, -0.905_766_68], errors: [3.902_5, 2.613_2, 1.020_2, 1.259_3] },
    Row { mesh: Mesh::Torus, face: 1000, preset: Preset::Robust, k: [-1.001_474_401_4, 0.496_081_146_6], tau: 0.003_403_801_7, truncated: false, normal: [-0.020_280_33, -0.647_925_38, -0.761_433_79], e1: [0.024_150_66, 0.761_050_73, -0.648_242_65], q: [0.330_073_39, 1.552_605_26, -0.914_542_24], errors: [0.559_4, 0.130_3, 2.537_1, 1.402_4] },
];

#[test]
fn what_is_not_stopped_is_the_same_and_what_is_gives_nothing() {
    use std::sync::atomic::{AtomicUsize, Ordering};

    let mesh = common::icosphere(3);
    let estimator = CurvatureEstimator::new(&mesh, Params::default()).unwrap();
    let all = estimator.all_faces(0.4).unwrap();
    let asked = AtomicUsize::new(0);
    let count = || asked.fetch_add(1, Ordering::Relaxed);
    let found = estimator.all_faces_until(0.4, &|| count() == usize::MAX).unwrap().unwrap();
    assert_eq!(found.as_slice(), all.as_slice());
    let often = asked.load(Ordering::Relaxed);
    assert!(often >= mesh.topology().face_count());
    for limit in [0, 100, often - 1] {
        asked.store(0, Ordering::Relaxed);
        assert!(estimator.all_faces_until(0.4, &|| count() >= limit).unwrap().is_none());
    }
    assert!(estimator.all_faces_until(-1.0, &|| true).is_err());
}

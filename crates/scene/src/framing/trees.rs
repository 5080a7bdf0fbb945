//! Boosted trees that tell which of two poses is upright.
//!
//! Each tree asks three questions of the features of both poses and adds the logarithm of the odds at its leaf. Fitted by
//! gradient boosting (logistic loss, depth 3, rate 0.2, L2 5, 40 samples in a leaf) to 3,264 models of 31 sources, glTF (+Y up by
//! its format) and printed parts in STL (+Z up, as they lie on the printer), each as a file of +Y and as one of +Z, with and
//! without texture coordinates, and at a fifth of the weight without the floor of the file; models of sources with more than
//! 60 count less each.

use super::evidence::{CONTACT_BELOW, FEATURES, Features, without_floor};

/// A tree of depth 3: its questions as a heap, the children of `k` being `2 k + 1` and `2 k + 2`, and its leaves.
struct Tree {
    /// Number of a feature, of the pose with +Y up and then of the one with +Z up, and the most of it, in ten thousandths, on the
    /// way to the left.
    splits: [(u8, i16); 7],
    /// Logarithms of the odds that +Y is up, in thousandths.
    leaves: [i16; 8],
}

/// Logarithm of the odds that turns a model, in thousandths: 9 to 1. The custom of a format is right for most files, and a wrong
/// turn is worse than none.
const ENOUGH: i32 = 2200;

/// Logarithm of the odds that turns a model that would fall over as it is usual: 4 to 1.
const ENOUGH_TO_STAND: i32 = 1400;

/// Difference of features by which poses differ, in ten thousandths.
const DIFFERS: u16 = 5;

/// True if by strong evidence +Y is up, or +Z where `z_is_usual` is false, of the poses in which they are. Less is strong where the
/// usual pose is none in which the body could rest. Without the floor of the file the poses have to differ: a cube has no top,
/// wherever it lies.
pub(super) fn is_turned(poses: &[Features; 2], z_is_usual: bool) -> bool {
    let [y, z] = poses.map(|pose| whole(&without_floor(&pose)));
    let differ = y.iter().zip(z).any(|(a, b)| a.abs_diff(b) > DIFFERS);
    let (other, usual, odds) = match (poses, odds_of_y(poses)) {
        ([y, z], odds) if z_is_usual => (y, z, odds),
        ([y, z], odds) => (z, y, -odds),
    };
    differ && odds > if stands(other) && falls(usual) { ENOUGH_TO_STAND } else { ENOUGH }
}

/// True if a body stands firmly in a pose: on more than half of its footprint, with its centre of mass well inside of that.
fn stands(pose: &Features) -> bool {
    let [share, depth] = CONTACT_BELOW.map(|k| pose[k]);
    share > 0.5 && depth > 0.1
}

/// True if a body falls over in a pose, its centre of mass not being above its contact.
fn falls(pose: &Features) -> bool {
    let [_, depth] = CONTACT_BELOW.map(|k| pose[k]);
    depth < 0.0
}

/// Logarithm of the odds that +Y is up and not +Z, in thousandths.
pub(super) fn odds_of_y([y, z]: &[Features; 2]) -> i32 {
    let [y, z] = [y, z].map(whole);
    let answer = |(feature, most): (u8, i16)| {
        let feature = usize::from(feature);
        let value = if feature < FEATURES { y[feature] } else { z[feature - FEATURES] };
        usize::from(value > most)
    };
    let leaf = |tree: &Tree| {
        let place = (0..3).fold(0, |k, _| 2 * k + 1 + answer(tree.splits[k]));
        i32::from(tree.leaves[place - tree.splits.len()])
    };
    TREES.iter().map(leaf).sum()
}

/// Features in ten thousandths, as whole numbers; a number that is none is 0.
fn whole(features: &Features) -> [i16; FEATURES] {
    features.map(|v| {
        // A cast saturates.
        (10_000.0 * v + 0.5).floor() as i16
    })
}

#[rustfmt::skip]
const TREES: [Tree; 60] = [
    Tree { splits: [(44, -1948), (96, -7223), (92, 118), (25, 1739), (32, 2198), (43, -399), (3, 3487)], leaves: [370, 134, -70, 159, -257, 158, -36, -366] },
    Tree { splits: [(44, -2786), (96, -7223), (36, 140), (10, 40), (36, 2677), (43, -399), (60, -693)], leaves: [122, 312, 56, -155, -194, 159, 75, -300] },
    Tree { splits: [(44, -1948), (43, -986), (40, 16312), (32, 2198), (26, 3857), (36, -1084), (47, 320)], leaves: [-49, 138, 279, -22, -100, -268, -163, 241] },
    Tree { splits: [(44, -2786), (96, -5341), (40, 12634), (32, -309), (4, 5590), (7, 28), (47, 214)], leaves: [54, 245, 26, -180, -237, -51, -166, 192] },
    Tree { splits: [(44, -918), (43, -986), (40, 16312), (7, 419), (25, 1739), (92, -330), (47, 320)], leaves: [-29, 254, 239, 8, -96, -226, -137, 183] },
    Tree { splits: [(44, -918), (43, -986), (26, 307), (36, 2163), (11, 4493), (43, -63), (36, -1084)], leaves: [44, -118, 220, -62, -136, 125, -30, -218] },
    Tree { splits: [(44, -2786), (43, -986), (43, -2777), (4, 5590), (25, 1739), (23, 2432), (48, 3468)], leaves: [41, -149, 207, -25, -201, 84, 177, -163] },
    Tree { splits: [(44, -350), (43, -986), (44, 1790), (3, 4567), (60, 385), (42, -12), (23, 871)], leaves: [137, -40, 195, -83, 40, -192, -81, 216] },
    Tree { splits: [(32, 1603), (36, 1718), (35, 8248), (4, 5509), (5, 3), (57, 3), (19, 132)], leaves: [52, -147, -6, -197, -1, 199, 92, -127] },
    Tree { splits: [(44, -4356), (96, -5341), (43, -986), (60, 1238), (42, 32), (96, -3341), (48, 3468)], leaves: [156, -190, 23, -171, -169, -10, 204, -126] },
    Tree { splits: [(32, 2198), (36, 1718), (35, 7913), (4, 5104), (5, 3), (57, 3), (19, 132)], leaves: [65, -95, 28, -166, -11, 193, 92, -110] },
    Tree { splits: [(44, -350), (43, -986), (26, 239), (79, 1415), (79, 0), (11, 0), (92, -1803)], leaves: [-54, 71, -81, 167, 202, -47, 36, -165] },
    Tree { splits: [(7, 265), (44, -4356), (1, 6056), (47, 550), (47, 407), (28, 26), (47, 2816)], leaves: [-27, 105, -161, -41, 2, 234, -160, 86] },
    Tree { splits: [(32, 1603), (36, 1377), (35, 8797), (79, 1376), (41, 4637), (79, 418), (26, 560)], leaves: [-68, 86, -138, 163, 4, 156, 77, -112] },
    Tree { splits: [(26, 275), (12, 216), (57, 205), (1, 4325), (50, 1346), (41, 4637), (79, 1304)], leaves: [101, -44, 187, -23, -104, 170, -51, 125] },
    Tree { splits: [(42, 2850), (32, 1150), (10, 3750), (15, 248), (7, 1), (43, -399), (0, 32767)], leaves: [60, -76, 39, 175, -219, 14, 34, 34] },
    Tree { splits: [(44, -350), (96, -9601), (44, 1790), (27, 163), (42, 1237), (42, -12), (25, 1076)], leaves: [-66, 159, 14, -155, 80, -135, 126, -107] },
    Tree { splits: [(5, 128), (21, 218), (79, 1341), (41, 635), (42, 1237), (26, 208), (92, 2231)], leaves: [-19, 151, 147, -84, 79, -139, 97, -117] },
    Tree { splits: [(7, 419), (5, 128), (1, 6056), (27, 640), (47, 625), (50, 374), (32, 3294)], leaves: [-37, 86, -103, 26, -22, 200, -111, 61] },
    Tree { splits: [(42, -1354), (51, 487), (31, 8022), (0, 32767), (10, 302), (35, 3710), (35, 7913)], leaves: [3, 3, 7, 225, -3, -108, 138, 11] },
    Tree { splits: [(57, 128), (26, 642), (10, 1221), (40, 1277), (41, 1282), (5, 26), (92, 1972)], leaves: [-40, 70, -109, 75, 116, -33, 191, 31] },
    Tree { splits: [(42, 3714), (94, -45), (39, 9760), (4, 5951), (36, 2294), (43, 0), (0, 32767)], leaves: [141, -123, 27, -69, -202, 19, 32, 32] },
    Tree { splits: [(60, 1238), (96, -9601), (5, 530), (48, 2467), (50, 671), (27, 743), (0, 32767)], leaves: [176, -48, -65, 21, -283, -31, 16, 16] },
    Tree { splits: [(42, 3714), (57, 128), (10, 3750), (19, 217), (79, 1304), (96, -9829), (0, 32767)], leaves: [7, -94, -16, 104, 12, -188, 30, 30] },
    Tree { splits: [(7, 693), (5, 1), (28, 753), (21, 475), (57, 26), (21, 0), (0, 32767)], leaves: [26, 173, -96, -5, -135, 135, 200, 200] },
    Tree { splits: [(60, 1238), (44, -350), (27, 415), (57, 1), (19, 8), (14, 1300), (14, 443)], leaves: [-48, 41, 43, -105, -260, -28, 74, -85] },
    Tree { splits: [(26, 307), (12, 110), (27, 378), (21, 0), (31, 9039), (48, 1880), (96, -9601)], leaves: [36, -81, 30, 165, -51, -226, 121, -14] },
    Tree { splits: [(42, -2876), (34, 4142), (31, 8643), (33, 134), (0, 32767), (49, 705), (56, 5000)], leaves: [12, 201, -39, -39, 18, -66, -17, 96] },
    Tree { splits: [(5, 5), (21, 475), (79, 1304), (25, 995), (44, -1948), (26, 307), (56, 4426)], leaves: [48, -76, 192, -71, 30, -87, 155, -14] },
    Tree { splits: [(42, 3714), (94, -1282), (17, 189), (36, -2471), (36, 1575), (10, 2083), (94, -3572)], leaves: [-109, 162, 27, -49, -76, 56, -14, -182] },
    Tree { splits: [(50, 705), (43, -399), (7, 1), (46, 407), (39, 2922), (27, 640), (17, 2731)], leaves: [-15, -102, 160, -24, -49, 54, 139, -82] },
    Tree { splits: [(60, 1238), (4, 5590), (5, 530), (3, 5651), (34, -3009), (0, 32767), (0, 32767)], leaves: [1, 103, 113, -101, -199, -199, 21, 21] },
    Tree { splits: [(42, 1237), (94, -1282), (96, -9601), (30, 137), (92, 5502), (48, 4448), (29, 137)], leaves: [-42, 194, 20, -51, 106, -37, -10, -145] },
    Tree { splits: [(31, 8022), (49, 705), (12, 110), (34, -305), (48, 218), (0, 2579), (25, 702)], leaves: [-39, 92, -22, -124, -114, 39, 143, -13] },
    Tree { splits: [(7, 693), (5, 1), (28, 753), (51, 728), (47, 550), (21, 0), (23, 1685)], leaves: [121, 15, -47, 17, -138, 118, 176, 10] },
    Tree { splits: [(50, 671), (92, -573), (30, 1652), (19, 132), (2, 3378), (10, 173), (92, 5502)], leaves: [-51, 82, -2, -121, -58, 72, 30, -127] },
    Tree { splits: [(26, 715), (10, 362), (79, 705), (23, 7), (12, 110), (2, 7197), (56, 4426)], leaves: [77, -89, 2, 101, -150, 40, 88, -29] },
    Tree { splits: [(44, -4356), (60, 132), (43, -986), (57, 1), (1, 3884), (2, 3167), (48, 3468)], leaves: [-31, 45, -159, 15, 25, -102, 158, -66] },
    Tree { splits: [(42, -2876), (34, 4142), (32, 464), (18, 2841), (0, 32767), (20, 442), (47, 6538)], leaves: [166, -4, -45, -45, 7, -102, 27, -102] },
    Tree { splits: [(30, 2724), (4, 5590), (25, 477), (57, 223), (56, 4630), (43, -2777), (51, 1080)], leaves: [-9, 59, -147, 3, -34, 111, -232, -25] },
    Tree { splits: [(42, 1237), (94, -1282), (96, -9829), (36, -2102), (92, 605), (57, 10), (29, 137)], leaves: [-71, 148, 28, -26, -40, 83, -2, -128] },
    Tree { splits: [(15, 3245), (32, 1485), (50, 1693), (14, 878), (1, 7197), (31, 417), (31, 2953)], leaves: [7, -78, 39, -114, -52, 184, 105, -127] },
    Tree { splits: [(26, 3326), (17, 90), (12, 968), (50, 887), (36, 2819), (29, 392), (57, 113)], leaves: [-17, 98, 11, -82, -190, -6, -78, 112] },
    Tree { splits: [(96, -9829), (48, 5000), (0, 7717), (79, 0), (92, 5027), (3, 3961), (47, 1412)], leaves: [-119, 137, 105, -219, 66, -31, 95, -105] },
    Tree { splits: [(1, 7894), (29, 3136), (3, 5012), (2, 7894), (43, 2038), (10, 15), (21, 752)], leaves: [-9, 124, 115, -110, 7, -192, 88, -66] },
    Tree { splits: [(7, 693), (5, 1), (28, 753), (51, 728), (47, 407), (21, 0), (23, 1685)], leaves: [100, 12, -40, 10, -130, 101, 161, 4] },
    Tree { splits: [(30, 2724), (50, 671), (19, 52), (50, 442), (10, 173), (35, 2910), (2, 7894)], leaves: [48, -54, -40, 43, -52, 79, -164, 103] },
    Tree { splits: [(42, 3714), (12, 110), (0, 705), (0, 2579), (23, 1035), (0, 32767), (6, 40)], leaves: [-124, 2, 3, 104, 41, 41, -151, -13] },
    Tree { splits: [(44, -4356), (25, 1374), (18, 1102), (1, 3297), (17, 310), (27, 0), (12, 1098)], leaves: [-27, 42, 4, -160, 64, -73, -2, 180] },
    Tree { splits: [(4, 5229), (30, 1652), (35, 50), (37, 921), (0, 5739), (13, 1917), (50, 797)], leaves: [-9, 66, 6, -163, 172, -23, -100, 23] },
    Tree { splits: [(57, 1), (17, 2731), (18, 1102), (44, -7500), (92, 1498), (49, 442), (43, -4011)], leaves: [97, -74, -100, 126, -113, 10, 17, 154] },
    Tree { splits: [(42, -2876), (34, 4142), (41, -1285), (8, 53), (0, 32767), (27, 1921), (60, 1238)], leaves: [149, 1, -43, -43, -136, 4, 4, -117] },
    Tree { splits: [(39, 7), (96, -5341), (10, 116), (52, 4639), (49, 493), (51, 545), (36, 1467)], leaves: [7, 183, -107, 36, 58, -143, 31, -31] },
    Tree { splits: [(1, 7894), (29, 4130), (47, 550), (2, 6056), (44, -1948), (92, 230), (43, -16)], leaves: [-11, 47, 158, -51, 76, -43, -188, -3] },
    Tree { splits: [(36, -5000), (56, 5614), (92, 605), (19, 1291), (6, 107), (22, 5), (41, 1282)], leaves: [-132, 67, -48, 133, -20, 67, -27, 92] },
    Tree { splits: [(42, 3714), (5, 223), (16, 209), (15, 37), (15, 248), (33, 9885), (6, 65)], leaves: [-64, 33, 59, -49, -44, 68, -143, -13] },
    Tree { splits: [(23, 1318), (47, 6538), (12, 56), (96, -9937), (48, 218), (35, 2910), (92, 5502)], leaves: [84, -11, 90, -177, -134, 52, 140, -9] },
    Tree { splits: [(39, 7), (33, 291), (17, 2818), (29, 540), (16, 860), (27, 640), (11, 416)], leaves: [-72, 67, -13, 107, -35, 24, -148, 64] },
    Tree { splits: [(49, 705), (34, -457), (26, 560), (10, 1110), (57, 274), (36, -5000), (10, 2322)], leaves: [-45, 60, 5, 136, -111, 39, -59, 44] },
    Tree { splits: [(26, 3326), (14, 127), (12, 968), (8, -20), (17, 2932), (27, 672), (57, 113)], leaves: [185, 9, 1, -101, -145, 25, -63, 94] },
];

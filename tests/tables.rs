//! Pre-integrated tables: against those of the engines, and what they mean.

use crate::reference::table::Table;
use overcoat_core::math::lanes::{Float, Lanes, Scalar};
use overcoat_shading::brdf::integrate;
use overcoat_shading::brdf::table::Table as Texels;
use overcoat_shading::brdf::tables::{self, Definition};
use std::path::Path;

/// A table of an engine's numbers.
fn read(name: &str) -> Table {
    Table::read(&Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/reference").join(name))
        .expect("the table exists")
}

fn columns<const N: usize>(table: &Table, names: [&str; N]) -> [Vec<f64>; N] {
    names.map(|name| table.column(name).expect("the column exists").to_vec())
}

/// The rows that share a roughness: that number, their cosines and their indices.
fn rows_of(roughness: &[f64], cosines: &[f64]) -> Vec<(f64, Vec<f64>, Vec<usize>)> {
    let mut groups: Vec<(f64, Vec<f64>, Vec<usize>)> = Vec::new();
    for (k, (r, cosine)) in roughness.iter().zip(cosines).enumerate() {
        match groups.iter_mut().find(|(v, _, _)| v == r) {
            Some((_, cosines, rows)) => {
                cosines.push(*cosine);
                rows.push(k);
            }
            None => groups.push((*r, vec![*cosine], vec![k])),
        }
    }
    groups
}

/// Compares an integral with columns; the tolerance is `relative` |expected| + `absolute`. Every `stride`th row.
fn compare<const N: usize>(
    [roughness, cosines]: &[Vec<f64>; 2],
    expected: &[Vec<f64>; N],
    integral: impl Fn(f64, &[f64]) -> Vec<[f64; N]>,
    relative: f64,
    absolute: f64,
    stride: usize,
) {
    for (r, cosines, rows) in rows_of(roughness, cosines).iter().step_by(stride) {
        let found = integral(*r, cosines);
        assert_eq!(found.len(), rows.len());
        for ((found, &row), cosine) in found.iter().zip(rows).zip(cosines) {
            for (found, expected) in found.iter().zip(expected.iter().map(|column| column[row])) {
                let error = (found - expected).abs();
                assert!(
                    error <= relative * expected.abs() + absolute,
                    "roughness {r}, cosine {cosine}: {found} not {expected}"
                );
            }
        }
    }
}

/// Step between the rows of a table that are integrated again: all of them, or a few in a debug build.
const STRIDE: usize = if cfg!(debug_assertions) { 9 } else { 1 };

#[test]
fn unity_integrates_the_same() {
    let table = read("unity/fgd_lut.csv");
    let rounded = |v: Vec<f64>| v.into_iter().map(|v| f64::from(v as f32)).collect::<Vec<_>>();
    let at = columns(&table, ["in_perceptualRoughness", "in_NdotV"]).map(rounded);
    // The original's constants are single-precision numbers.
    let exact = columns(&table, ["f64_x", "f64_y", "f64_z"]);
    compare(&at, &exact, integrate::unity_fgd, 6e-8, 3e-8, STRIDE);
}

#[test]
fn filament_integrates_the_same() {
    let table = read("web/filament_dfg.csv");
    let at = columns(&table, ["perceptualRoughness", "NoV"]);
    let exact = columns(&table, ["dfg_x", "dfg_y", "dfg_z"]);
    compare(&at, &exact, integrate::filament_dfg, 6e-9, 1e-12, STRIDE);
    for (r, iy) in at[0].iter().zip(&columns(&table, ["iy"])[0]) {
        assert_eq!(*r, integrate::filament_row(*iy as usize, 64));
    }
}

#[test]
fn khronos_integrates_the_same() {
    let table = read("web/khronos_lut.csv");
    let at = columns(&table, ["perceptualRoughness", "NdotV"]);
    let exact = columns(&table, ["ggx_scale_f64", "ggx_bias_f64", "charlie_f64"]);
    compare(&at, &exact, integrate::khronos, 6e-9, 1e-12, STRIDE);
}

#[test]
fn three_integrates_the_same() {
    let table = read("web/threejs_dfg_lut.csv");
    let at = columns(&table, ["roughness", "dotNV"]);
    let shipped = columns(&table, ["scale", "bias"]);
    // The table is shipped in half precision.
    compare(&at, &shipped, integrate::three_dfg, 1.0 / 2048.0, 3e-8, 1);
    // The stored one has the same bits, but for numbers below 2^-24 that its generator does not round up.
    let stored = tables::three_dfg();
    for k in 0..table.rows {
        let [scale, bias] = stored.texel(k % 16, k / 16).map(f64::from);
        let shipped = [shipped[0][k], shipped[1][k]];
        let same = |stored: f64, shipped: f64| {
            (stored - shipped).abs() <= if shipped < 6e-8 { 6e-8 } else { 6e-9 * shipped }
        };
        assert!(same(scale, shipped[0]) && same(bias, shipped[1]), "{k}");
    }
}

/// Babylon.js ships the integrals of [`tables::ggx_albedo`] at (N.V, perceptual roughness), with eight bits a channel: the
/// texels are as far from ours as that makes them, and farther only where neither is exact (grazing views of mirrors).
#[test]
fn babylon_ships_the_albedos_of_ggx() {
    let table = read("web/babylon_brdf_lut.csv");
    let [cosines, roughness] = columns(&table, ["NdotV", "perceptualRoughness"]);
    let shipped = columns(&table, ["brdf_x", "brdf_y"]);
    let l = Scalar;
    let mut squares = [0.0; 2];
    for row in 0..table.rows {
        let (cosine, p) = (cosines[row] as f32, roughness[row] as f32);
        let ours: [_; 2] = tables::ggx_albedo().fetch_first(l, l.splat(cosine.sqrt()), l.splat(p));
        for k in 0..2 {
            let error = (f64::from(ours[k].to_array()[0]) - shipped[k][row]).abs();
            let most = if cosine > 0.05 && p > 0.1 { 0.011 } else { 0.036 };
            assert!(error < most, "roughness {p}, cosine {cosine}, channel {k}: {error}");
            squares[k] += error * error;
        }
    }
    let spread = squares.map(|sum| (sum / table.rows as f64).sqrt());
    assert!(spread[0] < 0.002 && spread[1] < 0.004, "{spread:?}");
}

/// The stored bytes are those of the integrals: a few rows of each here, all of them by `examples/make-assets`.
#[test]
fn stored_tables_hold_the_integrals() {
    fn check<const N: usize>(definition: &Definition<N>, stored: &'static Texels<N>) {
        assert_eq!(stored.size(), definition.size);
        let [width, height] = definition.size;
        for y in [0, height / 3, height - 1] {
            let row = (definition.row)(definition.size, y);
            let one = Definition { size: [width, 1], file: "", row: definition.row, ..*definition };
            let expected = Texels::<N>::from_bytes(&one.bytes(&[row])).expect("just written");
            for x in 0..width {
                assert_eq!(stored.texel(x, y), expected.texel(x, 0), "{} {x} {y}", definition.file);
            }
        }
    }
    check(&tables::UNITY_FGD, tables::unity_fgd());
    check(&tables::FILAMENT_DFG, tables::filament_dfg());
    check(&tables::THREE_DFG, tables::three_dfg());
    check(&tables::KHRONOS, tables::khronos());
    check(&tables::SHEEN_ALBEDO, tables::sheen_albedo());
    check(&tables::GGX_ALBEDO, tables::ggx_albedo());
    check(&tables::LINEARLY_TRANSFORMED_GGX, tables::linearly_transformed_ggx());
}

/// A white furnace: GGX that only loses light between its facets reflects at most what falls in, smooth surfaces all.
#[test]
fn a_white_surface_reflects_at_most_everything() {
    let texels = |size: [usize; 2]| (0..size[0] * size[1]).map(move |k| (k % size[0], k / size[0]));
    let check = |name: &str, albedo: f32, slack: f32| {
        assert!(albedo > 0.2 && albedo <= 1.0 + slack, "{name}: {albedo}");
    };
    for (x, y) in texels(tables::unity_fgd().size()) {
        // At grazing angles of nearly smooth surfaces the samples miss: 1.0012 at most.
        check("unity", tables::unity_fgd().texel(x, y)[1], 0.002);
        if y == 0 {
            assert!((tables::unity_fgd().texel(x, y)[1] - 1.0).abs() < 1e-6);
        }
    }
    for (x, y) in texels(tables::filament_dfg().size()) {
        check("filament", tables::filament_dfg().texel(x, y)[1], 0.002);
    }
    for (x, y) in texels(tables::khronos().size()) {
        let [scale, bias, _] = tables::khronos().texel(x, y);
        check("khronos", scale + bias, 0.002);
    }
    for (x, y) in texels(tables::three_dfg().size()) {
        let [scale, bias] = tables::three_dfg().texel(x, y);
        check("three", scale + bias, 0.002);
    }
}

/// Two ways to sample one integral.
#[test]
fn albedos_of_ggx_agree() {
    for p in [0.3, 0.6, 1.0] {
        let cosines = [0.1, 0.3, 0.6, 1.0];
        for (ours, unitys) in integrate::ggx_albedo(p, &cosines).iter().zip(integrate::unity_fgd(p, &cosines))
        {
            assert!(
                (ours[0] - unitys[0]).abs() < 2e-3 && (ours[1] - unitys[1]).abs() < 7e-3,
                "{ours:?} {unitys:?}"
            );
            assert!(ours[2] > 0.0 && ours[2] < ours[0]);
        }
    }
    for k in 0..32 * 32 {
        assert!((0.2..=1.0).contains(&tables::ggx_albedo().texel(k % 32, k / 32)[1]));
    }
}

/// Sheen gets brighter towards the silhouette, and never gives light where the lobe is not.
#[test]
fn sheen_grows_towards_the_silhouette() {
    let table = tables::sheen_albedo();
    for y in 0..table.size()[1] {
        let row: Vec<f32> = (0..table.size()[0]).map(|x| table.texel(x, y)[0]).collect();
        assert!(row.iter().all(|e| (0.0..1.5).contains(e)), "{y} {row:?}");
        assert!(row.windows(2).all(|pair| pair[0] >= pair[1]), "{y} {row:?}");
    }
}

/// Lookups follow each table's own parametrisation.
#[test]
fn lookups_meet_the_texels() {
    let l = Scalar;
    let at = |v: f32| l.splat(v);
    let [_, y, _] = tables::unity_fgd().fetch(l, at((0.3_f32).sqrt()), at(0.5));
    let exact = integrate::unity_fgd(0.5, &[f64::from(0.3_f32)])[0][1] as f32;
    assert!((y.to_array()[0] - exact).abs() < 1e-3, "{} {exact}", y.to_array()[0]);
    // Filament reads its table as if rows were where they are not.
    let [_, y, _] = tables::filament_dfg().fetch(l, at(0.3), at(0.5));
    let exact = integrate::filament_dfg(0.5 + 1.0 / 128.0, &[f64::from(0.3_f32)])[0][1] as f32;
    assert!((y.to_array()[0] - exact).abs() < 1e-3, "{} {exact}", y.to_array()[0]);
}

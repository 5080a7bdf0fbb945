//! BRDFs from files: what was written is read back, fits find the numbers of which files were made, and broken files are
//! refused with a reason.

#[path = "common/measured_files.rs"]
mod files;

use files::{Field, Metal, Tables, coated, cosine, floats, merl, pairs, rgl, rgl_fields, tensor_file};
use overcoat_lab::lab::{Bench, Fit, Light, MeasuredBrdf, MeasuredError, OVERHEAD, Translator};
use overcoat_scene::{Material, ShadingModel, Workflow};
use std::f64::consts::{FRAC_1_PI, PI};

const GOLD: Metal = Metal { alpha: [0.16; 2], color: [0.9, 0.6, 0.2] };

fn tables(azimuths: Vec<f64>) -> Tables {
    Tables { facets: [33, 128], side: 32, elevations: 20, azimuths }
}

fn read(file: Vec<u8>) -> MeasuredBrdf {
    MeasuredBrdf::from_bytes(file).unwrap()
}

/// Sum of the differences of green over its sum, and the largest of the relative ones.
fn off(brdf: &MeasuredBrdf, metal: &Metal) -> (f64, f64) {
    let (mut sum, mut all, mut worst) = (0.0, 0.0, 0.0_f64);
    for [view, light] in pairs(4000) {
        let (found, right) = (brdf.evaluate(view, light).unwrap()[1], metal.brdf(view, light)[1]);
        (sum, all) = (sum + (found - right).abs(), all + right);
        worst = worst.max((found / right - 1.0).abs());
    }
    (sum / all, worst)
}

#[test]
fn merl_gives_back_what_was_written() {
    let brdf = read(merl([90, 90, 180], |v, l| GOLD.brdf(v, l)));
    assert_eq!((brdf.format(), brdf.is_anisotropic(), brdf.description()), ("merl", false, ""));
    let (mean, worst) = off(&brdf, &GOLD);
    assert!(mean < 0.002 && worst < 0.05, "{mean} {worst}");
    for [view, light] in pairs(500) {
        // By the format's own symmetry.
        let [there, back] = [(view, light), (light, view)].map(|(a, b)| brdf.evaluate(a, b).unwrap()[1]);
        assert!((there / back - 1.0).abs() < 1e-6, "{there} {back}");
    }
}

#[test]
fn rgl_gives_back_what_was_written() {
    let brdf = read(rgl(GOLD, &tables(vec![0.0])));
    assert_eq!((brdf.format(), brdf.is_anisotropic()), ("rgl", false));
    assert_eq!(brdf.description(), "A metal that nobody made");
    let (mean, worst) = off(&brdf, &GOLD);
    assert!(mean < 0.02 && worst < 0.6, "{mean} {worst}");
    let (mut difference, mut all) = (0.0, 0.0);
    for [view, light] in pairs(2000) {
        let [there, back] = [(view, light), (light, view)].map(|(a, b)| brdf.evaluate(a, b).unwrap()[1]);
        (difference, all) = (difference + (there - back).abs(), all + there);
    }
    assert!(difference / all < 0.03, "reciprocity {}", difference / all);
}

/// Tables of half the azimuths are those of all.
#[test]
fn brushed_metal_is_read_and_its_mean_is_even() {
    let brushed = Metal { alpha: [0.12, 0.3], ..GOLD };
    let over = |turns: f64, n: usize| -> Vec<f64> {
        (0..=n).map(|k| -PI + turns * 2.0 * PI * k as f64 / n as f64).collect()
    };
    for azimuths in [over(1.0, 16), over(0.5, 8), over(0.25, 4)] {
        let brdf = read(rgl(brushed, &Tables { elevations: 12, ..tables(azimuths.clone()) }));
        assert!(brdf.is_anisotropic());
        let (mean, _) = off(&brdf, &brushed);
        assert!(mean < 0.06, "{} azimuths: {mean}", azimuths.len());
        let lit = brdf.radiance(30.0, Light::Direct(25.0)).unwrap().unwrap();
        let wide = read(rgl(Metal { alpha: [0.3; 2], ..GOLD }, &tables(vec![0.0])));
        let wide = wide.radiance(30.0, Light::Direct(25.0)).unwrap().unwrap();
        assert!(lit[0] > wide[0], "{lit:?} {wide:?}");
    }
    let wrong = rgl(brushed, &Tables { elevations: 2, side: 2, ..tables(vec![-1.0, -0.5, 0.0]) });
    assert!(matches!(MeasuredBrdf::from_bytes(wrong), Err(MeasuredError::Number { what: "phi_i", .. })));
}

#[test]
fn a_matt_surface_has_its_albedo_under_every_light() {
    let brdf = read(merl([90, 30, 20], |_, _| [0.8, 0.4, 0.1].map(|c| c * FRAC_1_PI)));
    let close = |found: Option<[f64; 3]>, factor: f64, most: f64| {
        for (found, right) in found.unwrap().into_iter().zip([0.8, 0.4, 0.1]) {
            assert!((found / (right * factor) - 1.0).abs() < most, "{found} {right} {factor}");
        }
    };
    for view in [0.0, 30.0, 75.0] {
        close(brdf.radiance(view, Light::White).unwrap(), 1.0, 0.002);
        let sin = 1.0 - cosine(OVERHEAD) * cosine(OVERHEAD);
        close(brdf.radiance(view, Light::Overhead).unwrap(), sin, 0.01);
        close(brdf.radiance(view, Light::Direct(-50.0)).unwrap(), cosine(50.0) * FRAC_1_PI, 1e-9);
    }
}

#[test]
fn no_more_light_comes_back_than_fell() {
    for brdf in [
        read(merl([90, 90, 60], |v, l| Metal { color: [1.0; 3], ..GOLD }.brdf(v, l))),
        read(rgl(Metal { color: [1.0; 3], ..GOLD }, &tables(vec![0.0]))),
    ] {
        for view in [5.0, 40.0, 65.0, 80.0] {
            let albedo = brdf.radiance(view, Light::White).unwrap().unwrap()[1];
            // Single scattering between facets of that roughness loses a few percent, more at grazing views.
            assert!((0.85..1.01).contains(&albedo), "{} {view}: {albedo}", brdf.format());
        }
    }
}

/// The same sphere, lamp by lamp: where a lamp stood elsewhere, half of its light would differ.
#[test]
fn matt_spheres_are_alike() {
    let brdf = read(merl([90, 30, 20], |_, _| [0.8, 0.4, 0.1].map(|c| c * FRAC_1_PI)));
    let matt = Material::default().with(|m| {
        m.base_color = [0.8, 0.4, 0.1, 1.0];
        m.specular = 0.0;
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 1.0, texture: None };
    });
    let [measured, drawn] = brdf.spheres(&mut Bench::new(1), &matt, ShadingModel::Three, 64).unwrap();
    let mut covered = 0;
    for (a, b) in measured.pixels.iter().zip(&drawn.pixels).filter(|(_, b)| b[3] == 1.0) {
        assert!((0..3).all(|c| (a[c] / b[c] - 1.0).abs() < 0.03), "{a:?} {b:?}");
        covered += 1;
    }
    assert!(covered > 2500, "{covered}");
}

/// Cells that were not measured are no darkness.
#[test]
fn missing_numbers_are_left_out() {
    let hole = |view: [f64; 3], light: [f64; 3]| {
        let is_low = view[2] < 0.3 || light[2] < 0.3;
        if is_low { [-1.0; 3] } else { [0.5 * FRAC_1_PI; 3] }
    };
    let brdf = read(merl([60, 60, 60], hole));
    assert_eq!(brdf.radiance(85.0, Light::Direct(30.0)).unwrap(), None);
    assert_eq!(brdf.radiance(85.0, Light::White).unwrap(), None);
    let albedo = brdf.radiance(20.0, Light::White).unwrap().unwrap()[1];
    assert!((albedo - 0.5).abs() < 1e-4, "{albedo}");
    let found = Translator::new().fit(&brdf, ShadingModel::Three).unwrap();
    let color = found.material.base_color;
    assert!(found.white.relative < 0.03 && found.white.directions == 5, "{found:?}");
    assert!(color[..3].iter().all(|c| (0.3..0.6).contains(c)), "{color:?}");
    let nothing = read(merl([4, 4, 4], |_, _| [-1.0; 3]));
    assert!(Translator::new().fit(&nothing, ShadingModel::Three).is_err());
}

#[test]
fn a_fit_finds_the_metal_that_a_file_was_made_of() {
    let gold = Metal { alpha: [0.09; 2], ..GOLD };
    for brdf in [read(merl([90, 90, 60], |v, l| gold.brdf(v, l))), read(rgl(gold, &tables(vec![0.0])))] {
        let found = Translator::new().fit(&brdf, ShadingModel::Three).unwrap();
        let what = format!(
            "{}: {:?} {:?} {:?} {:?}",
            brdf.format(),
            found.distance,
            found.direct,
            found.white,
            found.material.workflow
        );
        let Workflow::MetallicRoughness { metallic, roughness, .. } = found.material.workflow else {
            panic!()
        };
        assert!((roughness - 0.3).abs() < 0.01 && metallic > 0.95 && found.material.coat == 0.0, "{what}");
        for (found, right) in found.material.base_color.iter().zip(gold.color) {
            assert!((f64::from(*found) - right).abs() < 0.03, "{what}");
        }
        assert!(found.distance.all < 0.02 && found.direct.relative < 0.03, "{what}");
        assert!(found.white.directions == 6 && found.direct.directions > 60, "{what}");
        // Both spheres look the same, also outside the planes of the fit.
        let spheres = brdf.spheres(&mut Bench::new(1), &found.material, ShadingModel::Three, 64).unwrap();
        let (mut difference, mut all) = (0.0, 0.0);
        for (a, b) in spheres[0].pixels.iter().zip(&spheres[1].pixels) {
            (difference, all) = (difference + (a[1] - b[1]).abs(), all + b[1]);
        }
        assert!(difference / all < 0.15 && difference > 0.0, "{what}: {}", difference / all);
    }
}

#[test]
fn a_fit_finds_the_coat_over_a_metal() {
    let blue = Metal { alpha: [0.25; 2], color: [0.1, 0.2, 0.6] };
    let brdf = read(merl([90, 90, 60], |v, l| coated(&blue, 0.01, v, l)));
    let Fit { material, distance, white, direct } =
        Translator::new().fit(&brdf, ShadingModel::Standard).unwrap();
    let Workflow::MetallicRoughness { metallic, roughness, .. } = material.workflow else { panic!() };
    let what = format!(
        "{roughness} {metallic} {} {} {:?} {distance:?} {white:?} {direct:?} {:?}",
        material.coat, material.coat_roughness, material.base_color, material.lobes.iridescence
    );
    assert!((roughness - 0.5).abs() < 0.02 && metallic > 0.9, "{what}");
    assert!(material.coat > 0.85 && (material.coat_roughness - 0.1).abs() < 0.01, "{what}");
    assert!(material.lobes.iridescence.mask.factor == 0.0 && white.relative < 0.05, "{what}");
}

fn error(file: Vec<u8>) -> String {
    MeasuredBrdf::from_bytes(file).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn errors_name_the_field_and_what_was_expected() {
    let small = || rgl_fields(GOLD, &Tables { facets: [3, 4], side: 2, elevations: 3, azimuths: vec![0.0] });
    let with = |field: Field| {
        let mut fields = small();
        fields.retain(|f| f.name != field.name);
        fields.push(field);
        error(tensor_file(&fields))
    };
    let without =
        |name: &str| error(tensor_file(&small().into_iter().filter(|f| f.name != name).collect::<Vec<_>>()));
    let whole = tensor_file(&small());
    let mut far = small();
    far[4].shape = vec![1 << 60, 1 << 60];
    let mut nan = merl([2, 2, 2], |_, _| [0.1; 3]);
    nan[12..20].copy_from_slice(&f64::NAN.to_le_bytes());
    let mut version = whole.clone();
    version[12] = 7;
    let mut many = whole.clone();
    many[14..18].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut spectral: Vec<Field> = small().into_iter().filter(|f| f.name != "rgb").collect();
    spectral.push(floats("spectra", &[1], &[0.0]));
    for (said, parts) in [
        (error(b"# a text\n".to_vec()), &["neither", "MERL", "tensor_file"][..]),
        (error(Vec::new()), &["neither"]),
        (error(merl([2, 2, 2], |_, _| [0.1; 3])[..100].to_vec()), &["2 x 2 x 2", "204 bytes", "has 100"]),
        (error(nan), &["red plane", "number 0", "NaN"]),
        (error(whole[..whole.len() - 1].to_vec()), &["'rgb' is cut short", "the file has"]),
        (error(whole[..40].to_vec()), &["header of field 0 is cut short"]),
        (error(version), &["version 7.0", "1.0"]),
        (error(many), &["fields: 4294967295", "at most 64"]),
        (error(tensor_file(&far)), &["'ndf' is cut short", "18446744073709551615"]),
        (error(tensor_file(&spectral)), &["spectra", "_rgb.bsdf"]),
        (without("sigma"), &["'sigma' is missing"]),
        (with(Field { kind: 11, ..floats("sigma", &[2, 1], &[1.0; 2]) }), &["'sigma'", "cut short"]),
        (with(Field { kind: 6, ..floats("sigma", &[2, 2], &[1.0; 4]) }), &["'sigma' has type 6", "float32"]),
        (with(floats("sigma", &[4], &[1.0; 4])), &["'sigma' has shape 4,", "rows x columns"]),
        (with(floats("vndf", &[1, 2, 2, 2], &[1.0; 8])), &["1 x 2 x 2 x 2", "1 x 3 x rows"]),
        (with(floats("vndf", &[1, 3, 2, 2], &[0.0; 12])), &["vndf", "above 0"]),
        (with(floats("vndf", &[1, 3, 2, 2], &[-1.0; 12])), &["vndf", "-1", "0 or more"]),
        (with(floats("theta_i", &[3], &[0.0, 1.0, 0.5])), &["theta_i, number 2: 0.5"]),
        (with(floats("ndf", &[2, 2], &[0.0, f64::INFINITY, 1.0, 1.0])), &["ndf, number 1: inf"]),
        (with(Field { kind: 1, ..floats("jacobian", &[3], &[0.0; 3]) }), &["'jacobian' has shape 3"]),
    ] {
        assert!(parts.iter().all(|part| said.contains(part)) && !said.contains('\n'), "{parts:?}: {said}");
    }
    let mut twice = small();
    twice.push(floats("ndf", &[2, 2], &[1.0; 4]));
    assert!(error(tensor_file(&twice)).contains("'ndf' is there twice"));
}

/// Bytes that are changed, cut and made large at places that depend on their number alone.
#[test]
fn damaged_files_are_errors_or_numbers() {
    let tiny = Tables { facets: [3, 4], side: 2, elevations: 2, azimuths: vec![-3.0, 0.0, 3.2] };
    let originals = [rgl(GOLD, &tiny), merl([3, 4, 5], |v, l| GOLD.brdf(v, l))];
    let (mut refused, mut read) = (0, 0);
    for k in 0..6000_u32 {
        let original = &originals[k as usize % 2];
        let mut file = original.clone();
        let at = |salt: u32, below: usize| {
            let x = (k * 7 + salt).wrapping_mul(0x9e37_79b9);
            (x ^ (x >> 15)).wrapping_mul(0x85eb_ca6b) as usize % below
        };
        // Most of the damage is to the header.
        let place = if k % 3 == 0 { at(1, file.len()) } else { at(1, 420.min(file.len())) };
        match k % 5 {
            0 => file.truncate(place),
            1 => file[place] ^= 1 << at(2, 8),
            2 => file[place] = [0, 1, 0x7f, 0x80, 0xff][at(2, 5)],
            3 => {
                let end = (place + 8).min(file.len());
                file[place..end].fill([0, 0xff, 0x7f][at(2, 3)]);
            }
            _ => file.insert(place, at(2, 256) as u8),
        }
        match MeasuredBrdf::from_bytes(file) {
            Err(error) => {
                refused += 1;
                assert!(error.to_string().len() < 400 && !error.to_string().chars().any(char::is_control));
            }
            Ok(brdf) => {
                read += 1;
                for [view, light] in pairs(4) {
                    if let Some(f) = brdf.evaluate(view, light) {
                        assert!(f.iter().all(|c| *c >= 0.0), "{k}: {f:?}");
                    }
                }
            }
        }
    }
    assert!(refused > 2000 && read > 500, "{refused} {read}");
}

//! The figures of the book's report are the lab's, and its intervals those of its means.

use super::bases::{escapes, fresnel};
use overcoat::scene::ShadingModel;
use overcoat_lab::lab::{Base, Bench, CONFIDENCE_95, Light, ModelError, Referee, Specimen, Summary};
use overcoat_lab::truth::Samples;

const MODELS: [ShadingModel; 3] = [ShadingModel::StackLitD, ShadingModel::OpenPbr, ShadingModel::Gltf];

fn read(path: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn report() -> String {
    read("docs/src/truth-report.md")
}

/// Numbers of a cell like `5.4 ± 0.2 (+1.3 ± 0.2)`.
fn numbers(cell: &str) -> Vec<f64> {
    let parts = cell.split(|c: char| !c.is_ascii_digit() && !"+-.".contains(c));
    parts.filter_map(|part| part.parse().ok()).collect()
}

/// Rows of the table under a heading that begins with that, by cells.
fn table<'a>(text: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    let lines = text.lines().skip_while(|line| !line.starts_with(heading)).skip(2);
    let rows = lines.take_while(|line| line.starts_with('|'));
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// The row of a model.
fn row<'a>(table: &'a [Vec<&'a str>], model: ShadingModel) -> &'a [&'a str] {
    let name = format!("`{}`", model.name());
    table.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("no row of {name}"))
}

fn of(found: &Summary, model: ShadingModel) -> &ModelError {
    found.errors.iter().find(|error| error.model == model).unwrap()
}

/// Columns of the grid by each reading again, with an eighth of the samples: means agree within their noise, and intervals are wider by the
/// root of eight.
#[test]
fn columns_of_the_grid_are_those_of_the_lab() {
    let report = report();
    let first = table(&report, "| model | grid | with absorption");
    let readings = table(&report, "| model | `seen`: grid |");
    assert_eq!((first.len(), readings.len()), (10, 10));
    let mut bench = Bench::new(2);
    for (table, column, base) in
        [(&first, 1, Base::Interface), (&readings, 1, Base::Seen), (&readings, 2, Base::Convention)]
    {
        let mut specimens = Summary::specimens(false);
        specimens.iter_mut().for_each(|specimen| specimen.base = base);
        let found =
            Summary::measure(&mut bench, &MODELS, &specimens, &Samples::new(2048), |_, _| {}).unwrap();
        for model in MODELS {
            let (error, told) = (of(&found, model), numbers(row(table, model)[column]));
            let [white, white_interval, bias, bias_interval] = told[..] else { panic!("{told:?}") };
            let [mean, sign] = [error.white, error.bias].map(|share| 100.0 * share);
            let interval = 100.0 * CONFIDENCE_95 * error.by_walks.bias;
            // Rounded to 0.1, both of them.
            let off = (interval * interval + bias_interval * bias_interval).sqrt() + 0.1;
            assert!((sign - bias).abs() < off, "{base:?} {model:?}: {sign} +- {interval} is not {bias}");
            // Differences without sign are larger where they are as small as the noise, which is 1.9 percent of a case.
            assert!((mean - white).abs() < off + 0.8, "{base:?} {model:?}: {mean} is not {white}");
            for told in [white_interval, bias_interval] {
                let expected = interval / 8.0_f64.sqrt();
                assert!((told - expected).abs() < 0.1, "{base:?} {model:?}: {told}, expected {expected}");
            }
        }
    }
}

/// Specimens anywhere again, with few samples: the means, and the spread that makes their intervals.
#[test]
fn the_column_of_coats_anywhere_is_that_of_the_lab() {
    let report = report();
    let first = table(&report, "| model | grid | with absorption");
    let models = [ShadingModel::StackLit, ShadingModel::Gltf];
    let samples = Samples::new(256);
    let found =
        Summary::measure(&mut Bench::new(2), &models, &Summary::random(60), &samples, |_, _| {}).unwrap();
    for model in models {
        let (error, row) = (of(&found, model), row(&first, model));
        let (white, direct) = (numbers(row[3]), numbers(row[4]));
        let pairs = [
            (error.white, error.by_specimens.white, white[0], white[1]),
            (error.bias, error.by_specimens.bias, white[2], white[3]),
            (error.direct, error.by_specimens.direct, direct[0], direct[1]),
        ];
        for (mean, spread, told, told_interval) in pairs {
            let [mean, interval] = [mean, CONFIDENCE_95 * spread].map(|share| 100.0 * share);
            assert!((mean / told - 1.0).abs() < 0.06, "{model:?}: {mean} is not {told}");
            assert!(
                (interval / told_interval - 1.0).abs() < 0.1,
                "{model:?}: {interval} is not {told_interval}"
            );
        }
    }
}

/// Lacquer over a matt surface of 18 percent: its closed form, the referee within its interval, and the models.
#[test]
fn the_table_of_lacquer_is_its_closed_form() {
    let report = report();
    let rows = table(&report, "| view | closed form |");
    assert_eq!(rows.len(), 5);
    let specimen = Specimen { specular: 0.0, color: [0.18; 3], coat_roughness: 0.0, ..Specimen::default() };
    let referee = Referee::new(&specimen).unwrap();
    let mut bench = Bench::new(1);
    let e = escapes(1.5);
    for row in rows {
        let view: f64 = row[0].trim_end_matches('°').parse().unwrap();
        let f = fresnel(overcoat_core::math::double::cos(view.to_radians()), 1.5);
        let expected = f + (1.0 - f) * 0.18 * e / (1.0 - 0.18 * (1.0 - e));
        assert!((numbers(row[1])[0] - expected).abs() < 6e-5, "{row:?}: {expected}");
        let (told, interval) = (numbers(row[2])[0], numbers(row[2])[1]);
        // Two of five may miss an interval of 95 percent only once in forty such tables; all are within another half.
        assert!((told - expected).abs() < 1.5 * interval + 5e-5, "{row:?}: {expected}");
        let found = referee.radiance(view, Light::White, &Samples::new(4096)).unwrap();
        let wider = CONFIDENCE_95 * found.standard_error()[1];
        assert!((found.mean()[1] - told).abs() < 1.5 * wider, "{row:?}: {found:?}");
        assert!((wider / 4.0 / interval - 1.0).abs() < 0.2, "{row:?}: {wider}");
        let models = [ShadingModel::StackLitD, ShadingModel::OpenPbr, ShadingModel::Three];
        for (model, cell) in models.into_iter().zip(&row[3..]) {
            let shown = bench.radiance(&specimen, model, view, Light::White).unwrap()[1];
            let off = 100.0 * (shown / told - 1.0);
            assert!((off - numbers(cell)[0]).abs() < 0.15, "{row:?}, {model:?}: {off}");
        }
    }
}

/// The library's guide has the means of the first table, without intervals.
#[test]
fn the_guide_has_the_same_means() {
    let (report, guide) = (report(), read("src/guide/clear_coat.md"));
    let first = "| model | grid | with absorption";
    let (rows, others) = (table(&report, "| model | grid | with absorption"), table(&guide, first));
    assert_eq!((rows.len(), others.len()), (10, 10));
    for (row, other) in rows.iter().zip(&others) {
        assert_eq!(row[0], other[0]);
        for (cell, other) in row[1..].iter().zip(&other[1..]) {
            let means: Vec<f64> = numbers(cell).into_iter().step_by(2).collect();
            assert_eq!(means, numbers(other), "{}", row[0]);
        }
    }
}

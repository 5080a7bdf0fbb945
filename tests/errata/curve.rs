//! Filament's squared attenuation over the angle: how much light from beneath the coat is missing.

use super::filament::coat_reflectance;
use overcoat_core::math::double::cos;
use std::fmt::Write;

/// Specular share of the light from beneath, colour and name of each curve.
const CURVES: [(f64, &str, &str); 2] =
    [(1.0, "#0072b2", "a metal: all of it is specular"), (0.5, "#d55e00", "half of it is specular")];

/// Position of 0 degrees and 0 percent, and the distances from there to 90 degrees and to -100 percent.
const CORNER: [f64; 2] = [56.0, 16.0];
const EXTENT: [f64; 2] = [450.0, 220.0];

/// (Fd + Fr (1 - Fc)) (1 - Fc) over (Fd + Fr) (1 - Fc), less 1, in percent.
fn error(degrees: f64, specular: f64) -> f64 {
    let f = coat_reflectance(cos(degrees.to_radians()));
    100.0 * ((1.0 - specular) + specular * (1.0 - f) - 1.0)
}

fn place(degrees: f64, percent: f64) -> [f64; 2] {
    [CORNER[0] + EXTENT[0] * degrees / 90.0, CORNER[1] - EXTENT[1] * percent / 100.0]
}

pub fn svg() -> String {
    let mut text = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"540\" height=\"290\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"540\" height=\"290\" fill=\"#fff\"/>\n",
    );
    let mut line = |from: [f64; 2], to: [f64; 2]| {
        let ([x, y], [u, v]) = (from, to);
        let _ = writeln!(text, "<path d=\"M{x:.1} {y:.1}L{u:.1} {v:.1}\" stroke=\"#ddd\"/>");
    };
    for k in 0..=9 {
        line(place(10.0 * f64::from(k), 0.0), place(10.0 * f64::from(k), -100.0));
    }
    for k in 0..=5 {
        line(place(0.0, -20.0 * f64::from(k)), place(90.0, -20.0 * f64::from(k)));
    }
    let mut word = |[x, y]: [f64; 2], anchor: &str, color: &str, word: &str| {
        let _ = writeln!(
            text,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{color}\">{word}</text>"
        );
    };
    for k in 0..=9 {
        let [x, y] = place(10.0 * f64::from(k), -100.0);
        word([x, y + 18.0], "middle", "#333", &format!("{}", 10 * k));
    }
    for k in 0..=5 {
        let [x, y] = place(0.0, -20.0 * f64::from(k));
        word([x - 6.0, y + 4.0], "end", "#333", &format!("{} %", -20 * k));
    }
    word(
        [CORNER[0] + 0.5 * EXTENT[0], 280.0],
        "middle",
        "#333",
        "angle of l.h, or n.v under the environment, in degrees",
    );
    for (k, (_, color, name)) in CURVES.into_iter().enumerate() {
        word([CORNER[0] + 14.0, CORNER[1] + 150.0 + 20.0 * k as f64], "start", color, name);
    }
    for (specular, color, _) in CURVES {
        let points = (0..=60).map(|k| 1.5 * f64::from(k)).map(|degrees| {
            let [x, y] = place(degrees, error(degrees, specular));
            format!("{x:.1},{y:.1}")
        });
        let points: Vec<String> = points.collect();
        let _ = writeln!(
            text,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            points.join(" ")
        );
    }
    text + "</svg>\n"
}

#[test]
fn the_curve_ends_where_the_page_says() {
    let told = [0.0, 60.0, 80.0, 90.0].map(|degrees| error(degrees, 1.0).round());
    assert_eq!(told, [-4.0, -7.0, -41.0, -100.0]);
}

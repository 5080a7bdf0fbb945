//! Plots of the lab, as SVG: curves, lobes in polar coordinates, maps of errors.

use super::{described, names};
use overcoat_core::math::double::sin_cos;
use overcoat_lab::lab::{Base, Light, Quantity, Row, Slice, luminance};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::error::Error;

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

const SIZE: (u32, u32) = (960, 640);
const FONT: &str = "sans-serif";

/// Colours that stay apart for the colour-blind (Okabe and Ito), then darker ones of the same hues.
const COLORS: [RGBColor; 14] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(130, 120, 20),
    RGBColor(120, 60, 140),
    RGBColor(150, 80, 60),
    RGBColor(110, 110, 110),
    RGBColor(0, 60, 110),
    RGBColor(130, 50, 0),
    RGBColor(0, 90, 60),
    RGBColor(120, 40, 90),
];

/// Caption with the parameters that do not vary, in a line.
fn caption(slice: &Slice) -> String {
    let s = &slice.specimen;
    let said = |quantity, text: String| if slice.over == quantity { String::new() } else { text };
    let grey = s.color[0] == s.color[1] && s.color[1] == s.color[2];
    let color = if grey {
        format!("{}", s.color[0])
    } else {
        format!("{},{},{}", s.color[0], s.color[1], s.color[2])
    };
    let mut text = String::from("coat");
    text += &said(Quantity::Coat, if s.coat == 1.0 { String::new() } else { format!(" {}", s.coat) });
    text += &said(Quantity::CoatRoughness, format!(" roughness {}", s.coat_roughness));
    text += &said(Quantity::CoatIor, format!(" index {}", s.coat_ior));
    if s.extinction != [0.0; 3] {
        text += &said(Quantity::Thickness, format!(" thickness {}", s.thickness));
    }
    text += match (s.metal, s.specular > 0.0) {
        (true, _) => " over metal",
        (false, true) if s.base == Base::Lambert => " over matt",
        (false, true) => " over plastic",
        (false, false) => " over matt",
    };
    text += &said(Quantity::Color, format!(" {color}"));
    if !s.metal && s.specular > 0.0 && s.base != Base::Lambert {
        text += &format!(" ({})", described(s.base, s.base_ior));
    }
    if s.metal || (s.specular > 0.0 && s.base != Base::Lambert) {
        text += &said(Quantity::BaseRoughness, format!(" roughness {}", s.base_roughness));
    }
    text += &said(Quantity::View, format!("; view {} degrees", slice.view));
    match slice.light {
        Light::White => text += "; white light",
        Light::Overhead => text += "; soft box overhead",
        Light::Direct(degrees) => text += &said(Quantity::Light, format!("; light {degrees} degrees")),
    }
    text
}

/// A slice: curves, or lobes where the angle of the light varies.
pub(super) fn slice(slice: &Slice, rows: &[Row]) -> Result<String, Box<dyn Error>> {
    named_slice(&caption(slice), "referee", slice, rows)
}

/// The same with a caption, and a name of what the models are beside.
pub(super) fn named_slice(
    caption: &str,
    truth: &'static str,
    slice: &Slice,
    rows: &[Row],
) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let root = root.titled(caption, (FONT, 20))?;
        if slice.over == Quantity::Light {
            lobes(&root, truth, slice, rows)?
        } else {
            curves(&root, truth, slice, rows)?
        }
        root.present()?;
    }
    Ok(text)
}

/// Name, colour and points of every model, then the referee's.
fn series<'a>(
    truth: &'static str,
    slice: &'a Slice,
    rows: &'a [Row],
) -> impl Iterator<Item = (&'static str, RGBColor, u32, Vec<(f64, f64)>)> + 'a {
    let of = |k: usize| rows.iter().map(move |row| (row.value, luminance(row.models[k]))).collect();
    let models = names(&slice.models).enumerate();
    let models = models.map(move |(k, name)| (name, COLORS[k % COLORS.len()], 2, of(k)));
    let points = rows.iter().map(|row| (row.value, luminance(row.truth))).collect();
    models.chain([(truth, BLACK, 3, points)])
}

/// The largest value that a plot has room for: that of all, but no more than twice the referee's, so that a model that is far off
/// leaves something to see of the others. Its curve is cut off.
fn most(slice: &Slice, rows: &[Row]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(1e-6, |a, b| if b > a { b } else { a });
    let all = largest(&mut series("", slice, rows).flat_map(|(_, _, _, points)| points).map(|p| p.1));
    let truth = 2.0 * largest(&mut rows.iter().map(|row| luminance(row.truth)));
    if all < truth { all } else { truth }
}

fn curves(root: &Area<'_>, truth: &'static str, slice: &Slice, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let [first, last] = slice.range;
    let most = 1.08 * most(slice, rows);
    let mut chart = ChartBuilder::on(root)
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(64)
        .build_cartesian_2d(first..last, 0.0..most)?;
    let value = match slice.light {
        Light::White => "directional albedo (luminance)",
        Light::Overhead => "radiance (luminance)",
        Light::Direct(_) => "BRDF times cosine (luminance)",
    };
    chart
        .configure_mesh()
        .x_desc(slice.over.name())
        .y_desc(value)
        .label_style((FONT, 15))
        .axis_desc_style((FONT, 17))
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 225, 225))
        .draw()?;
    // Two standard errors of the referee to either side.
    let edge =
        |sign: f64| move |row: &Row| (row.value, luminance(row.truth) + sign * 2.0 * luminance(row.error));
    let band: Vec<(f64, f64)> = rows.iter().map(edge(1.0)).chain(rows.iter().rev().map(edge(-1.0))).collect();
    chart.draw_series([Polygon::new(band, BLACK.mix(0.15))])?;
    lines(&mut chart, truth, slice, rows, |(value, shown)| (value, if shown < most { shown } else { most }))
}

/// The lines of all models and the referee's, each point put where `place` says, and what they are called.
fn lines<'a>(
    chart: &mut Chart<'a, 'a>,
    truth: &'static str,
    slice: &Slice,
    rows: &[Row],
    place: impl Fn((f64, f64)) -> (f64, f64),
) -> Result<(), Box<dyn Error>> {
    for (name, color, width, points) in series(truth, slice, rows) {
        chart
            .draw_series(LineSeries::new(points.into_iter().map(&place), color.stroke_width(width)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(width)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .label_font((FONT, 15))
        .draw()?;
    Ok(())
}

/// Position of a value in polar coordinates: straight up is the normal, to the right light from the side that the view
/// is not on.
fn polar((degrees, radius): (f64, f64)) -> (f64, f64) {
    let (sin, cos) = sin_cos(degrees.to_radians());
    (radius * sin, radius * cos)
}

fn lobes(root: &Area<'_>, truth: &'static str, slice: &Slice, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let most = 1.05 * most(slice, rows);
    let cut = |(degrees, radius): (f64, f64)| polar((degrees, if radius < most { radius } else { most }));
    let mut chart =
        ChartBuilder::on(root).margin(24).build_cartesian_2d(-most..most, -0.08 * most..1.22 * most)?;
    let grey = RGBColor(215, 215, 215);
    for k in 1..=4 {
        let ring = (-90..=90).map(|degrees| polar((f64::from(degrees), most * f64::from(k) / 4.0)));
        chart.draw_series([PathElement::new(ring.collect::<Vec<_>>(), grey)])?;
        let label = format!("{:.3}", most * f64::from(k) / 4.0);
        chart.draw_series([Text::new(
            label,
            polar((90.0, most * (f64::from(k) - 0.35) / 4.0)),
            (FONT, 13),
        )])?;
    }
    for degrees in (-90..=90).step_by(15) {
        chart.draw_series([PathElement::new([(0.0, 0.0), polar((degrees.into(), most))], grey)])?;
        chart.draw_series([Text::new(
            format!("{degrees}"),
            polar((degrees.into(), 1.04 * most)),
            (FONT, 13),
        )])?;
    }
    let view = polar((-slice.view, most));
    chart
        .draw_series(DashedLineSeries::new([(0.0, 0.0), view], 6, 4, BLACK.stroke_width(1)))?
        .label("view")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 7, y)], BLACK));
    lines(&mut chart, truth, slice, rows, cut)
}

/// Signed relative errors of each model over two quantities, a map beside the other.
pub(super) fn errors(
    slice: &Slice,
    by: Quantity,
    maps: &[(f64, Vec<Row>)],
) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    let columns = slice.models.len().clamp(1, 3);
    let lines = slice.models.len().div_ceil(columns).max(1);
    {
        let size = (340 * columns as u32 + 60, 320 * lines as u32 + 50);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE)?;
        let root = root.titled(&caption(slice), (FONT, 17))?;
        let (root, scale) = root.split_horizontally(340 * columns as i32);
        for ((k, model), area) in slice.models.iter().enumerate().zip(root.split_evenly((lines, columns))) {
            map(&area, slice, by, maps, (k, model.name()))?;
        }
        legend(&scale)?;
    }
    Ok(text)
}

fn map(
    area: &Area<'_>,
    slice: &Slice,
    by: Quantity,
    maps: &[(f64, Vec<Row>)],
    (k, name): (usize, &str),
) -> Result<(), Box<dyn Error>> {
    let [first, last] = slice.range;
    let [low, high] = by.range();
    let half =
        [0.5 * (last - first) / (slice.steps - 1) as f64, 0.5 * (high - low) / (maps.len() - 1) as f64];
    let mut chart = ChartBuilder::on(area)
        .caption(name, (FONT, 16))
        .margin(8)
        .x_label_area_size(36)
        .y_label_area_size(44)
        .build_cartesian_2d(first - half[0]..last + half[0], low - half[1]..high + half[1])?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(slice.over.name())
        .y_desc(by.name())
        .label_style((FONT, 12))
        .draw()?;
    for (value, rows) in maps {
        chart.draw_series(rows.iter().map(|row| {
            let off = luminance(row.models[k]) / luminance(row.truth).max(1e-9) - 1.0;
            let corner = |sign: f64| (row.value + sign * half[0], value + sign * half[1]);
            Rectangle::new([corner(-1.0), corner(1.0)], tint(off).filled())
        }))?;
    }
    Ok(())
}

/// White where there is no error, red where a model is too bright, blue where it is too dark; full at 50 percent.
fn tint(off: f64) -> RGBColor {
    let t = (off.abs() / 0.5).clamp(0.0, 1.0);
    let fade = |to: f64| (255.0 + (to - 255.0) * t) as u8;
    if off >= 0.0 {
        RGBColor(fade(190.0), fade(20.0), fade(30.0))
    } else {
        RGBColor(fade(10.0), fade(70.0), fade(170.0))
    }
}

fn legend(area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    for k in 0..=20 {
        let off = 0.5 - f64::from(k) * 0.05;
        let top = 40 + 11 * k;
        area.draw(&Rectangle::new([(4, top), (18, top + 11)], tint(off).filled()))?;
        if k % 5 == 0 {
            area.draw(&Text::new(format!("{:+.0} %", 100.0 * off), (20, top), (FONT, 11)))?;
        }
    }
    Ok(())
}

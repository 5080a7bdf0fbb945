//! All quantities in one plot.

use crate::axis::Axis;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

const SIZE: (u32, u32) = (960, 680);
const FONT: &str = "sans-serif";
/// Colours that stay apart for the colour-blind (Okabe and Ito).
const COLORS: [RGBColor; 5] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 84, 84),
];

/// Draws cost against quantity, both relative to the first point, on logarithmic scales, and a dashed line where twice
/// as much costs twice as much.
pub fn draw(path: &Path, axes: &[Axis]) -> Result<(), Box<dyn Error>> {
    let lines: Vec<Vec<(f64, f64)>> = axes.iter().map(Axis::relative).collect();
    let most = lines.iter().flatten().map(|p| p.0.max(p.1)).fold(1.0, f64::max) * 1.5;
    let least = lines.iter().flatten().map(|p| p.1).fold(1.0, f64::min) * 0.7;
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption("What a frame costs as one quantity grows", (FONT, 24))
        .margin(16)
        .x_label_area_size(52)
        .y_label_area_size(72)
        .build_cartesian_2d((1.0..most).log_scale(), (least..most).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("times the quantity of the first point")
        .y_desc("times the processor time of the first point")
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .label_style((FONT, 17))
        .axis_desc_style((FONT, 19))
        .light_line_style(RGBColor(238, 238, 238))
        .bold_line_style(RGBColor(210, 210, 210))
        .draw()?;
    chart
        .draw_series(DashedLineSeries::new([(1.0, 1.0), (most, most)], 6, 5, BLACK.stroke_width(1)))?
        .label("linear: twice as much costs twice as much")
        .legend(|(x, y)| {
            EmptyElement::at((x, y))
                + PathElement::new([(0, 0), (7, 0)], BLACK)
                + PathElement::new([(11, 0), (18, 0)], BLACK)
        });
    for ((axis, line), color) in axes.iter().zip(&lines).zip(COLORS.into_iter().cycle()) {
        chart
            .draw_series(LineSeries::new(line.iter().copied(), color.stroke_width(2)))?
            .label(format!("{}: {}", axis.name, range(axis)))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(3)));
        chart.draw_series(line.iter().map(|&place| Circle::new(place, 3, color.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.9))
        .border_style(RGBColor(160, 160, 160))
        .label_font((FONT, 17))
        .draw()?;
    root.present()?;
    Ok(())
}

/// The first value and the last.
fn range(axis: &Axis) -> String {
    let ends = [axis.points.first(), axis.points.last()];
    ends.into_iter().flatten().map(|p| p.label.as_str()).collect::<Vec<_>>().join(" to ")
}

/// 1000 as 1000, 0.5 as 0.5.
fn label(value: &f64) -> String {
    format!("{value}")
}

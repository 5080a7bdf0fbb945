//! Effect on a picture of mistakes in notes that circulate: `src/guide/errata.md` has a figure of each and a line of
//! numbers, and both are what comes out here. Wrong formulas are in these files alone.
//!
//! The right ball of a figure is a picture of the renderer. From its normals the same surface is computed anew, with the right
//! formula, which has to give the same picture, and with the wrong one.
//!
//! `UPDATE_PICTURES=1` makes figures and numbers anew, and fails: look at them.

mod ball;
mod curve;
mod figure;
mod filament;
mod hdrp_lit;
mod lacquer;
mod page;
mod stacklit;
mod urp;

use ball::{Ball, Setting};
use figure::Figure;

/// All of them, in the order of the page.
fn figures() -> Vec<Figure> {
    let (sun, soft) = (Setting::SUN, Setting::SOFT);
    let metal = Ball::drawn(&stacklit::material(), stacklit::MODEL, &soft);
    let layered = |by: stacklit::Notes| metal.shaded(|normal| stacklit::shade(normal, &soft, by));
    let paint = Ball::drawn(&hdrp_lit::material(), hdrp_lit::MODEL, &sun);
    let lit = |by: hdrp_lit::Notes| paint.shaded(|normal| hdrp_lit::shade(normal, &sun, by));
    let brushed = Ball::drawn(&urp::material(), urp::MODEL, &soft);
    let rough = |by: urp::Notes| brushed.shaded(|normal| urp::shade(normal, &soft, by));
    let gold = Ball::drawn(&filament::material(true), filament::MODEL, &soft);
    let squared = Ball::drawn(&filament::material(false), filament::MODEL, &soft);
    let matt = Ball::drawn(&lacquer::material(), lacquer::CARRIER, &soft);
    let lacquered = |total: lacquer::Beyond| matt.shaded(|normal| lacquer::shade(normal, &soft, total));

    // The right ball of each figure is what the crate draws.
    for (name, drawn, formula) in [
        ("stacklit", &metal, layered(stacklit::Notes::Right)),
        ("hdrp-lit", &paint, lit(hdrp_lit::Notes::Right)),
        ("urp", &brushed, rough(urp::Notes::Right)),
        ("filament", &gold, gold.shaded(|normal| filament::shade(normal, &soft, false))),
        ("filament, squared", &squared, gold.shaded(|normal| filament::shade(normal, &soft, true))),
    ] {
        drawn.must_be(name, &formula);
    }
    lacquer::must_be_what_the_referee_finds();

    let figure = |name, ball: &Ball, wrong| Figure::new(name, ball, ball.shown.clone(), wrong);
    vec![
        figure("stacklit-sums", &metal, layered(stacklit::Notes::Sums)),
        figure("stacklit-accumulated", &metal, layered(stacklit::Notes::Accumulated)),
        figure("stacklit-times-fgd", &metal, layered(stacklit::Notes::TimesFgd)),
        figure("hdrp-plus-mask", &paint, lit(hdrp_lit::Notes::PlusMask)),
        figure("hdrp-plus-through", &paint, lit(hdrp_lit::Notes::PlusThrough)),
        figure("hdrp-alpha-squared", &paint, lit(hdrp_lit::Notes::AlphaSquared)),
        figure("hdrp-perceptual-as-alpha", &paint, lit(hdrp_lit::Notes::PerceptualAsAlpha)),
        figure("urp-brackets", &brushed, rough(urp::Notes::Brackets)),
        figure("filament-squared", &gold, squared.shown),
        Figure::new(
            "total-reflection",
            &matt,
            lacquered(lacquer::Beyond::Reflected),
            lacquered(lacquer::Beyond::Lost),
        ),
    ]
}

#[test]
fn the_page_shows_what_the_mistakes_do() {
    let figures = figures();
    let mut others = Vec::new();
    for figure in &figures {
        others.extend(page::renew(&format!("errata/{}.png", figure.name), &figure.png));
    }
    others.extend(page::renew("errata/filament-squared-curve.svg", curve::svg().as_bytes()));
    others.extend(page::renew("errata/figures.md", page::definitions(&figures).as_bytes()));
    others.extend(page::renew("errata.md", page::with_numbers(&figures).as_bytes()));
    let how = if page::updates() { "made anew" } else { "not what the formulas make" };
    assert!(others.is_empty(), "{how}: {}", others.join(", "));
}

/// Every figure is on the page, is the picture of something, and nothing else lies in its folder.
#[test]
fn every_figure_is_on_the_page_and_small() {
    let mut bytes = 0;
    for entry in std::fs::read_dir(page::folder().join("errata")).unwrap() {
        let entry = entry.unwrap();
        bytes += entry.metadata().unwrap().len();
        let name = entry.file_name().into_string().unwrap();
        assert!(name == "figures.md" || page::text().contains(&format!("]: errata/{name}")), "{name}");
    }
    assert!((10_000..150_000).contains(&bytes), "{bytes}");
}

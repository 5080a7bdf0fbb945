//! A data set of one model: pictures from all around, each with depth in millimetres, a mask of its objects and its camera.
//!
//! ```sh
//! cargo run --release --example depth-and-ids -- model.glb data 12
//! ```

use overcoat::frame::{Aov, DisplayImage, DisplayOptions, Frame};
use overcoat::output::encode_png;
use overcoat::scene::Framing;
use overcoat::{RenderOptions, Renderer, Scene};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

const SIDE: u32 = 256;

/// The directions of `count` views: a spiral over the sphere from its top to its bottom.
fn directions(count: u32) -> impl Iterator<Item = [f32; 3]> {
    let mut side = [1.0_f64, 0.0];
    (0..count).map(move |k| {
        let height = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(count);
        let radius = (1.0 - height * height).sqrt();
        let direction = [radius * side[0], height, radius * side[1]].map(|c| c as f32);
        // By the angle of a triangle of sides 3, 4 and 5, which never comes back to where it was; the same bits on every machine.
        side = [0.6 * side[0] - 0.8 * side[1], 0.8 * side[0] + 0.6 * side[1]];
        direction
    })
}

/// Distance along the view direction in whole millimetres, 0 where nothing is, as 16-bit numbers of big-endian bytes: what PGM files
/// hold.
fn depth(frame: &Frame) -> Vec<u8> {
    let plane = frame.plane(Aov::Depth).map_or(&[][..], |plane| &plane.data);
    let mut pgm = format!("P5\n{} {}\n65535\n", frame.width, frame.height).into_bytes();
    pgm.extend(plane.iter().flat_map(|metres| ((metres * 1000.0).round() as u16).to_be_bytes()));
    pgm
}

/// The number of the object at each pixel, 0 where nothing is, as bytes.
fn objects(frame: &Frame) -> Vec<u8> {
    let plane = frame.plane(Aov::ObjectId).map_or(&[][..], |plane| &plane.ids);
    let mut pgm = format!("P5\n{} {}\n255\n", frame.width, frame.height).into_bytes();
    pgm.extend(plane.iter().map(|number| *number as u8));
    pgm
}

/// Writes `count` views into a folder. Returns the lines of its `cameras.csv`.
fn write(scene: &Scene, folder: &Path, count: u32) -> Result<String, Box<dyn Error>> {
    let options = RenderOptions::draft(SIDE, SIDE).with_aovs(vec![Aov::Depth, Aov::ObjectId]);
    let mut renderer = Renderer::builder().build()?;
    // World to camera as OpenCV has it: row by row, +x right, +y down, +z forward. The first pixel's centre is at 0.5, 0.5.
    let elements = (0..16).map(|k| format!("pose[{}][{}]", k / 4, k % 4)).collect::<Vec<_>>().join(",");
    let mut cameras = format!("name,fx,fy,cx,cy,{elements}\n");
    for (k, direction) in directions(count).enumerate() {
        let camera = Framing::default().with_direction(direction).camera(scene);
        let rendered = renderer.render(scene, &camera, &options)?;
        let (frame, told) = (rendered.frame, rendered.camera);
        let name = format!("{k:04}");
        let picture = encode_png(&DisplayImage::new(&frame, &DisplayOptions::default()))?;
        std::fs::write(folder.join(format!("{name}.png")), picture)?;
        std::fs::write(folder.join(format!("{name}.depth.pgm")), depth(&frame))?;
        std::fs::write(folder.join(format!("{name}.objects.pgm")), objects(&frame))?;
        let [[fx, _, cx], [_, fy, cy], _] = told.k;
        let pose =
            told.world_to_camera.as_flattened().iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        writeln!(cameras, "{name},{fx},{fy},{cx},{cy},{pose}")?;
    }
    std::fs::write(folder.join("cameras.csv"), &cameras)?;
    Ok(cameras)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, folder, count] = &arguments[..] else {
        return Err("depth-and-ids MODEL FOLDER COUNT".into());
    };
    let loaded = overcoat::load::model(model)?;
    loaded.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    std::fs::create_dir_all(folder)?;
    print!("{}", write(&loaded.scene, Path::new(folder), count.parse()?)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_and_masks_belong_to_each_other() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models/material-ball.glb");
        let scene = overcoat::load::model(path).unwrap().scene;
        let folder = tempfile::tempdir().unwrap();
        let cameras = write(&scene, folder.path(), 3).unwrap();
        assert_eq!(cameras.lines().count(), 4);
        assert!(cameras.lines().all(|line| line.split(',').count() == 21), "{cameras}");
        for name in ["0000", "0001", "0002"] {
            let read = |kind: &str| std::fs::read(folder.path().join(format!("{name}.{kind}"))).unwrap();
            let (depth, objects) = (read("depth.pgm"), read("objects.pgm"));
            let pixels = (SIDE * SIDE) as usize;
            let (depth, objects) = (&depth[depth.len() - 2 * pixels..], &objects[objects.len() - pixels..]);
            let near = depth.chunks_exact(2).map(|bytes| u16::from_be_bytes([bytes[0], bytes[1]]));
            assert!(near.zip(objects).all(|(depth, object)| (depth == 0) == (*object == 0)), "{name}");
            assert!(objects.iter().filter(|object| **object > 0).count() > pixels / 10, "{name}");
        }
    }
}

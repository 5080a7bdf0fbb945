//! An application that draws with its own code for GPUs where there is a device, and by the processor where there is none, or from the
//! frame on in which it is lost.
//!
//! ```sh
//! cargo run --release --example gpu-or-processor -- assets/models/sports-car.glb car.png
//! ```

use overcoat::frame::{DisplayImage, PixelFormat, Target};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::load_file;
use overcoat::output::{OutputFormat, OutputOptions, encode_image, write_atomically};
use overcoat::render::Renderer;
use overcoat::scene::{Camera, Scene};
use overcoat::viewport::{Orbit, Viewport};
use std::error::Error;
use std::path::{Path, PathBuf};

type Reason = Box<dyn Error>;

/// Pixels of a window: RGBA with 8 bits each, row by row.
struct Surface {
    size: [u32; 2],
    pixels: Vec<u8>,
}

impl Surface {
    fn new(size: [u32; 2]) -> Self {
        Self { size, pixels: vec![0; size[0] as usize * size[1] as usize * 4] }
    }
}

/// Something that draws the application's scene.
trait Backend {
    /// Draws a frame; an error if it cannot any more.
    fn draw(&mut self, scene: &Scene, camera: &Camera, onto: &mut Surface) -> Result<(), Reason>;
}

/// Opens a backend, which may fail: no driver, no device, a feature that it lacks.
type Open = fn() -> Result<Box<dyn Backend>, Reason>;

/// Backends by name, the one that is preferred first.
const BACKENDS: &[(&str, Open)] = &[("gpu", open_gpu), ("processor", open_processor)];

/// Opens the application's own renderer: here wgpu, ash or an engine would ask for a device. This example brings none, so that it builds
/// everywhere, and says what it has looked for.
fn open_gpu() -> Result<Box<dyn Backend>, Reason> {
    let nodes = std::fs::read_dir("/dev/dri").into_iter().flatten().flatten().map(|entry| entry.path());
    let is_device =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("renderD"));
    match nodes.filter(is_device).min() {
        None => Err("no device in /dev/dri".into()),
        Some(node) => {
            Err(format!("{} may be one, and this example has no code for it", node.display()).into())
        }
    }
}

/// overcoat, which needs nothing but the processor.
struct Processor {
    viewport: Viewport,
}

fn open_processor() -> Result<Box<dyn Backend>, Reason> {
    Ok(Box::new(Processor { viewport: Viewport::new(Renderer::builder().build()?) }))
}

impl Backend for Processor {
    fn draw(&mut self, scene: &Scene, camera: &Camera, onto: &mut Surface) -> Result<(), Reason> {
        let [width, height] = onto.size;
        self.viewport.resize(width, height);
        let mut target = Target::new(&mut onto.pixels, width as usize * 4, PixelFormat::Rgba8);
        self.viewport.draw(scene, camera, &mut target)?;
        Ok(())
    }
}

/// Draws with the first backend that can. One that has failed is not asked again.
struct Drawing<'a> {
    left: std::slice::Iter<'a, (&'a str, Open)>,
    current: Option<(&'a str, Box<dyn Backend>)>,
}

impl<'a> Drawing<'a> {
    fn new(backends: &'a [(&'a str, Open)]) -> Self {
        Self { left: backends.iter(), current: None }
    }

    /// Draws a frame, whole, by whichever backend it takes. Returns its name.
    fn draw(&mut self, scene: &Scene, camera: &Camera, onto: &mut Surface) -> Result<&'a str, Reason> {
        let mut last: Reason = "no backend is left".into();
        loop {
            if let Some((name, backend)) = &mut self.current {
                match backend.draw(scene, camera, onto) {
                    Ok(()) => return Ok(name),
                    Err(reason) => {
                        eprintln!("{name}: {reason}");
                        (self.current, last) = (None, reason);
                    }
                }
            }
            let Some((name, open)) = self.left.next() else { return Err(last) };
            match open() {
                Ok(backend) => self.current = Some((name, backend)),
                Err(reason) => {
                    eprintln!("{name}: {reason}");
                    last = reason;
                }
            }
        }
    }
}

fn main() -> Result<(), Reason> {
    let mut words = std::env::args().skip(1);
    let model = words.next().unwrap_or_else(|| "assets/models/sports-car.glb".to_owned());
    let path = words.next().unwrap_or_else(|| "car.png".to_owned());
    let loaded = load_file(Path::new(&model), &Limits::default(), &Jobs::new(0))?;
    let mut surface = Surface::new([640, 360]);
    let mut drawing = Drawing::new(BACKENDS);
    let mut orbit = Orbit::around(&loaded.scene, 640.0 / 360.0);
    let mut by = "";
    for _ in 0..3 {
        orbit.turn(0.1, 0.0);
        by = drawing.draw(&loaded.scene, &orbit.camera(), &mut surface)?;
    }
    let [width, height] = surface.size;
    let image = DisplayImage { width, height, pixels: surface.pixels.as_chunks::<4>().0.to_vec() };
    write_atomically(Path::new(&path), &encode_image(&image, OutputFormat::Png, &OutputOptions::default())?)?;
    println!("{path}, drawn by the {by}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat::scene::{Material, Transform, primitives};

    /// A device that is lost in its third frame, halfway.
    struct Lost {
        frames: u32,
    }

    impl Backend for Lost {
        fn draw(&mut self, _: &Scene, _: &Camera, onto: &mut Surface) -> Result<(), Reason> {
            self.frames += 1;
            let all = onto.pixels.len();
            let drawn = if self.frames < 3 { all } else { all / 2 };
            onto.pixels[..drawn].fill(self.frames as u8);
            if self.frames < 3 { Ok(()) } else { Err("the device is lost".into()) }
        }
    }

    fn open_lost() -> Result<Box<dyn Backend>, Reason> {
        Ok(Box::new(Lost { frames: 0 }))
    }

    fn cube() -> Result<Scene, Reason> {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(primitives::cuboid([1.0; 3])?)?;
        let material = scene.add_material(Material::default())?;
        scene.add_instance(overcoat::scene::Instance::new(mesh, material, Transform::IDENTITY))?;
        Ok(scene)
    }

    #[test]
    fn frames_go_on_where_there_is_no_device_and_after_it_is_lost() {
        let scene = cube().unwrap();
        let camera = Orbit::around(&scene, 1.0).camera();
        let backends: &[(&str, Open)] =
            &[("none", || Err("no device".into())), ("lost", open_lost), ("processor", open_processor)];
        let (mut drawing, mut alone) = (Drawing::new(backends), Drawing::new(&backends[2..]));
        let (mut surface, mut expected) = (Surface::new([48, 48]), Surface::new([48, 48]));
        assert_eq!(alone.draw(&scene, &camera, &mut expected).unwrap(), "processor");
        let mut names = Vec::new();
        for _ in 0..4 {
            names.push(drawing.draw(&scene, &camera, &mut surface).unwrap());
            let is_expected = surface.pixels == expected.pixels;
            assert_eq!(is_expected, names.last() == Some(&"processor"));
        }
        assert_eq!(names, ["lost", "lost", "processor", "processor"]);
        let error = Drawing::new(&backends[..1]).draw(&scene, &camera, &mut surface).unwrap_err();
        assert_eq!(error.to_string(), "no device");
    }
}

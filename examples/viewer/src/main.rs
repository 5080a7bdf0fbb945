//! A window that shows a model: drag to turn it, drop another file, click to ask what is there.
//!
//! ```sh
//! cargo run --release -p overcoat-viewer -- assets/models/sports-car.glb
//! ```
//!
//! Moving models are drawn at once, straight into the window's memory, as well as a budget allows; models at rest are
//! drawn again, better, by a thread of its own, which every input stops.

mod arguments;
mod keys;
mod overlay;
mod refinement;
mod show;
mod window;

use arguments::Arguments;
use std::error::Error;
use std::process::ExitCode;
use winit::event_loop::EventLoop;

fn run() -> Result<(), Box<dyn Error>> {
    let Some(arguments) = Arguments::from_env()? else {
        print!("{}", arguments::help());
        return Ok(());
    };
    let event_loop = EventLoop::with_user_event().build()?;
    let mut viewer = window::Viewer::new(arguments, event_loop.create_proxy())?;
    event_loop.run_app(&mut viewer)?;
    viewer.finish()
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("overcoat-viewer: {error}");
            ExitCode::FAILURE
        }
    }
}

//! The window: input in, pictures out.

use crate::arguments::Arguments;
use crate::overlay::{Overlay, Pixels};
use crate::refinement::{Refined, Refinement};
use crate::show::{Show, Surroundings};
use softbuffer::{Context, Surface};
use std::error::Error;
use std::num::NonZeroU32;
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::window::{Window, WindowId};

/// Pixels that a pointer may move while a button is down and still click.
const CLICK: f64 = 3.0;

/// Line over the first pictures, and how long it stays.
const HINT: &str = "H: help";
const HINT_STAYS: Duration = Duration::from_secs(4);

/// An open window.
struct Open {
    window: Rc<Window>,
    surface: Surface<Rc<Window>, Rc<Window>>,
}

/// The application.
pub struct Viewer {
    arguments: Arguments,
    refinement: Refinement,
    open: Option<Open>,
    pointer: PhysicalPosition<f64>,
    /// The button that is down, and how far the pointer has moved since.
    pressed: Option<(MouseButton, f64)>,
    modifiers: ModifiersState,
    /// Time at which the animation began to play.
    playing: Option<Instant>,
    /// Pictures of `--frames` that are drawn, and when the first was.
    frames: u32,
    start: Option<Instant>,
    /// Title of the window, and the time that its picture took.
    title: String,
    time: Duration,
    /// The better picture that is shown, without text over it; none while one is drawn at once.
    shown: Option<Refined>,
    /// Text over the picture: all keys, or up to a time where they are.
    overlay: Overlay,
    helps: bool,
    hint_until: Option<Instant>,
    failure: Option<Box<dyn Error>>,
}

impl Viewer {
    pub fn new(arguments: Arguments, proxy: EventLoopProxy<Refined>) -> Result<Self, Box<dyn Error>> {
        let mut show = Show::new(&arguments)?;
        if let Some(path) = &arguments.model {
            open_file(&mut show, path)?;
        }
        Ok(Self {
            arguments,
            refinement: Refinement::new(show, proxy),
            open: None,
            pointer: PhysicalPosition::new(0.0, 0.0),
            pressed: None,
            modifiers: ModifiersState::empty(),
            playing: None,
            frames: 0,
            start: None,
            title: String::new(),
            time: Duration::ZERO,
            shown: None,
            overlay: Overlay::default(),
            helps: false,
            hint_until: None,
            failure: None,
        })
    }

    /// Outcome of the window's life, once it is closed.
    pub fn finish(self) -> Result<(), Box<dyn Error>> {
        self.failure.map_or(Ok(()), Err)
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: impl Into<Box<dyn Error>>) {
        self.failure.get_or_insert(error.into());
        event_loop.exit();
    }

    fn open_window(&self, event_loop: &ActiveEventLoop) -> Result<Open, Box<dyn Error>> {
        let [width, height] = self.arguments.size;
        let attributes = Window::default_attributes()
            .with_title("overcoat")
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Rc::new(event_loop.create_window(attributes)?);
        let context = Context::new(Rc::clone(&window))?;
        let surface = Surface::new(&context, Rc::clone(&window))?;
        Ok(Open { window, surface })
    }

    /// Something is another: it is to be drawn.
    fn redraw(&self) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    /// Draws at once what is shown now.
    fn draw(&mut self) -> Result<(), Box<dyn Error>> {
        let Some(Open { window, surface }) = &mut self.open else { return Ok(()) };
        let size = window.inner_size();
        let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) else {
            return Ok(());
        };
        surface.resize(width, height)?;
        let mut show = self.refinement.stop();
        show.viewport.resize(size.width, size.height);
        let start = Instant::now();
        if let Some(start) = self.playing {
            show.pose(start.elapsed().as_secs_f64())?;
        }
        let mut buffer = surface.buffer_mut()?;
        let drawn = show.draw(&mut buffer)?;
        self.time = start.elapsed();
        self.title = show.title(&drawn);
        drop(show);
        if let Some(old) = self.shown.take() {
            self.refinement.recycle(old);
        }
        let text =
            Text { helps: self.helps, hints: self.hint_until.is_some(), title: &self.title, time: self.time };
        text.write(&mut self.overlay, &mut buffer, window);
        buffer.present()?;
        window.set_title(&self.title);
        if self.playing.is_none() && self.arguments.frames.is_none() {
            self.refinement.begin();
        }
        Ok(())
    }

    /// Takes over a better picture, if it is still one of what is shown.
    fn take_over(&mut self, refined: Refined) -> Result<(), Box<dyn Error>> {
        let Some(Open { window, .. }) = &self.open else { return Ok(()) };
        let size = window.inner_size();
        if !self.refinement.is_current(&refined) || refined.size != [size.width, size.height] {
            self.refinement.recycle(refined);
            return Ok(());
        }
        let is_final = refined.is_final;
        if let Some(title) = &refined.title {
            window.set_title(title);
            self.title.clone_from(title);
            self.time = refined.time;
            if let Some(old) = self.shown.replace(refined) {
                self.refinement.recycle(old);
            }
            self.present()?;
        } else {
            self.refinement.recycle(refined);
        }
        println!("{}", self.title);
        if !is_final {
            self.refinement.begin();
        }
        Ok(())
    }

    /// Shows the better picture again, with the text that is over it now; without one, it is drawn anew.
    fn present(&mut self) -> Result<(), Box<dyn Error>> {
        let Some(Open { window, surface }) = &mut self.open else { return Ok(()) };
        let size = window.inner_size();
        let Some(shown) = self.shown.as_ref().filter(|shown| shown.size == [size.width, size.height]) else {
            window.request_redraw();
            return Ok(());
        };
        let mut buffer = surface.buffer_mut()?;
        buffer.copy_from_slice(&shown.pixels);
        let text =
            Text { helps: self.helps, hints: self.hint_until.is_some(), title: &self.title, time: self.time };
        text.write(&mut self.overlay, &mut buffer, window);
        Ok(buffer.present()?)
    }

    /// Ends the hint when its time is over. Returns until when it stays.
    fn end_hint(&mut self) -> Result<Option<Instant>, Box<dyn Error>> {
        if self.hint_until.is_some_and(|until| until <= Instant::now()) {
            self.hint_until = None;
            self.present()?;
        }
        Ok(self.hint_until)
    }

    /// A step of `--frames`. True when all are drawn.
    fn count_frame(&mut self) -> bool {
        let Some(frames) = self.arguments.frames else { return false };
        let start = *self.start.get_or_insert_with(Instant::now);
        if self.frames == frames {
            let seconds = start.elapsed().as_secs_f64();
            let speed = f64::from(frames) / seconds;
            println!("{frames} frames in {seconds:.3} s, {speed:.1} a second; the last: {}", self.title);
            return true;
        }
        self.frames += 1;
        self.refinement.stop().orbit.turn(std::f64::consts::TAU / f64::from(frames), 0.0);
        self.redraw();
        false
    }

    fn move_pointer(&mut self, to: PhysicalPosition<f64>) {
        let (dx, dy) = (to.x - self.pointer.x, to.y - self.pointer.y);
        self.pointer = to;
        let Some((button, moved)) = &mut self.pressed else { return };
        *moved += dx.abs() + dy.abs();
        let (pans, shift) = (*button == MouseButton::Right, self.modifiers.shift_key());
        if *moved <= CLICK {
            return;
        }
        let mut show = self.refinement.stop();
        let height = f64::from(show.viewport.options().height);
        if pans || shift {
            show.orbit.pan(-dx / height, dy / height);
        } else {
            show.orbit.turn(-dx / height * std::f64::consts::PI, dy / height * std::f64::consts::PI);
        }
        drop(show);
        self.redraw();
    }

    fn click(&mut self) {
        let pixel = [self.pointer.x.max(0.0) as u32, self.pointer.y.max(0.0) as u32];
        let found = self.refinement.stop().describe(pixel);
        println!("{}, {}: {found}", pixel[0], pixel[1]);
        self.redraw();
    }

    fn press(&mut self, key: &Key, event_loop: &ActiveEventLoop) -> Result<(), Box<dyn Error>> {
        let is_help = match key {
            Key::Named(NamedKey::F1) => true,
            Key::Character(text) => matches!(text.as_str(), "h" | "H" | "?"),
            _ => false,
        };
        if is_help {
            // The picture stays, and so does a better one that is being drawn.
            (self.helps, self.hint_until) = (!self.helps, None);
            return self.present();
        }
        let back = self.modifiers.shift_key();
        let mut show = self.refinement.stop();
        match key {
            Key::Named(NamedKey::Escape) => event_loop.exit(),
            Key::Named(NamedKey::Space) => {
                let length = show.length();
                self.playing =
                    if self.playing.is_none() && length.is_some() { Some(Instant::now()) } else { None };
            }
            Key::Character(text) => match text.to_lowercase().as_str() {
                "m" => show.next_shading(back),
                "q" => show.next_quality(),
                "s" => show.next_samples(),
                "g" => show.toggle_ground(),
                "e" => {
                    let next = match show.surroundings {
                        Surroundings::Studio => Surroundings::None,
                        Surroundings::None => Surroundings::Seen,
                        Surroundings::Seen => Surroundings::Studio,
                    };
                    show.surround(next)?;
                }
                "r" => show.reset(),
                _ => {}
            },
            _ => {}
        }
        drop(show);
        self.redraw();
        Ok(())
    }

    fn handle(&mut self, event: WindowEvent, event_loop: &ActiveEventLoop) -> Result<(), Box<dyn Error>> {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => {
                self.draw()?;
                if self.count_frame() {
                    event_loop.exit();
                } else if self.playing.is_some() {
                    self.redraw();
                }
            }
            WindowEvent::Resized(_) => self.redraw(),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::CursorMoved { position, .. } => self.move_pointer(position),
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. } => {
                self.pressed = Some((button, 0.0))
            }
            WindowEvent::MouseInput { state: ElementState::Released, .. } => {
                if let Some((MouseButton::Left, 0.0..=CLICK)) = self.pressed.take() {
                    self.click();
                }
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / 40.0,
                };
                let closer = 1.0 + 0.1 * lines.abs();
                self.refinement.stop().orbit.zoom(if lines < 0.0 { 1.0 / closer } else { closer });
                self.redraw();
            }
            WindowEvent::KeyboardInput {
                event: KeyEvent { state: ElementState::Pressed, logical_key, .. },
                ..
            } => self.press(&logical_key, event_loop)?,
            WindowEvent::DroppedFile(path) => {
                self.playing = None;
                let opened = open_file(&mut self.refinement.stop(), &path);
                if let Err(error) = opened {
                    eprintln!("overcoat-viewer: {error}");
                }
                self.redraw();
            }
            _ => {}
        }
        Ok(())
    }
}

/// Text over a picture.
struct Text<'a> {
    helps: bool,
    hints: bool,
    title: &'a str,
    time: Duration,
}

impl Text<'_> {
    fn write(&self, overlay: &mut Overlay, pixels: &mut [u32], window: &Window) {
        let (size, scale) = (window.inner_size(), window.scale_factor());
        let mut on = Pixels { pixels, size: [size.width, size.height] };
        if self.helps {
            let mut status: Vec<String> =
                self.title.split(" - ").filter(|part| *part != "overcoat").map(str::to_owned).collect();
            if let Some(last) = status.last_mut() {
                *last = format!("{last}: {:.1} ms", self.time.as_secs_f64() * 1e3);
            }
            overlay.help(&mut on, &status, scale);
        } else if self.hints {
            overlay.hint(&mut on, HINT, scale);
        }
    }
}

/// Shows a file, and says what is lost of it.
fn open_file(show: &mut Show, path: &Path) -> Result<(), Box<dyn Error>> {
    let warnings = show.open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    warnings.iter().for_each(|warning| eprintln!("overcoat-viewer: warning: {warning}"));
    Ok(())
}

impl ApplicationHandler<Refined> for Viewer {
    fn new_events(&mut self, event_loop: &ActiveEventLoop, _: StartCause) {
        match self.end_hint() {
            Ok(until) => event_loop.set_control_flow(until.map_or(ControlFlow::Wait, ControlFlow::WaitUntil)),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        match self.open_window(event_loop) {
            Ok(open) => {
                self.open = Some(open);
                // Measured frames have none.
                self.hint_until = self.arguments.frames.is_none().then(|| Instant::now() + HINT_STAYS);
            }
            Err(error) => self.fail(event_loop, error),
        }
        self.redraw();
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, refined: Refined) {
        if let Err(error) = self.take_over(refined) {
            self.fail(event_loop, error);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let Err(error) = self.handle(event, event_loop) {
            self.fail(event_loop, error);
        }
    }
}

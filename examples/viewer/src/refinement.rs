//! A thread that draws better pictures while nothing moves.

use crate::show::Show;
use overcoat::render::Cancellation;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use winit::event_loop::EventLoopProxy;

/// A picture that the thread has drawn, or that there is no better one.
#[derive(Debug)]
pub struct Refined {
    /// Number of the state that it shows; see `is_current`.
    pub state: u64,
    pub size: [u32; 2],
    /// Memory, of a picture if one was drawn.
    pub pixels: Vec<u32>,
    /// Title of the window for it; `None`: no better picture was drawn.
    pub title: Option<String>,
    /// Time that it took.
    pub time: Duration,
    pub is_final: bool,
}

/// Request to the thread.
struct Task {
    state: u64,
    cancellation: Cancellation,
    /// Memory of an earlier picture.
    pixels: Vec<u32>,
}

/// The thread, and what it shares with the window.
pub struct Refinement {
    show: Arc<Mutex<Show>>,
    tasks: Option<Sender<Task>>,
    thread: Option<JoinHandle<()>>,
    cancellation: Cancellation,
    state: u64,
    spare: Vec<u32>,
}

fn lock(show: &Mutex<Show>) -> MutexGuard<'_, Show> {
    show.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Refinement {
    pub fn new(show: Show, proxy: EventLoopProxy<Refined>) -> Self {
        let show = Arc::new(Mutex::new(show));
        let (tasks, received) = channel();
        let shared = Arc::clone(&show);
        let thread = std::thread::spawn(move || work(&shared, &received, &proxy));
        let cancellation = Cancellation::new();
        Self { show, tasks: Some(tasks), thread: Some(thread), cancellation, state: 0, spare: Vec::new() }
    }

    /// Access to the scene and its viewport, to change or draw them: whatever the thread draws is stopped.
    pub fn stop(&mut self) -> MutexGuard<'_, Show> {
        self.cancellation.cancel();
        self.state += 1;
        let mut show = lock(&self.show);
        show.viewport.renderer().cancel_by(None);
        show
    }

    /// Asks for the next better picture of what is shown now.
    pub fn begin(&mut self) {
        self.cancellation = Cancellation::new();
        let (state, cancellation) = (self.state, self.cancellation.clone());
        let task = Task { state, cancellation, pixels: std::mem::take(&mut self.spare) };
        if let Some(tasks) = &self.tasks {
            // It ends with the window alone.
            let _ = tasks.send(task);
        }
    }

    /// True if the picture shows the current state.
    pub fn is_current(&self, refined: &Refined) -> bool {
        refined.state == self.state
    }

    /// Takes the memory of a picture back.
    pub fn recycle(&mut self, refined: Refined) {
        self.spare = refined.pixels;
    }
}

impl Drop for Refinement {
    fn drop(&mut self) {
        self.cancellation.cancel();
        self.tasks = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn work(show: &Mutex<Show>, tasks: &Receiver<Task>, proxy: &EventLoopProxy<Refined>) {
    while let Ok(Task { state, cancellation, mut pixels }) = tasks.recv() {
        if cancellation.is_cancelled() {
            continue;
        }
        let mut show = lock(show);
        show.viewport.renderer().cancel_by(Some(cancellation));
        let size = [show.viewport.options().width, show.viewport.options().height];
        pixels.resize(size[0] as usize * size[1] as usize, 0);
        let start = Instant::now();
        let (title, is_final) = match show.refine(&mut pixels) {
            Ok(Some(drawn)) => (Some(show.title(&drawn)), drawn.is_final),
            Ok(None) => (None, true),
            // Cancelled: the window goes on.
            Err(_) => continue,
        };
        let time = start.elapsed();
        let _ = proxy.send_event(Refined { state, size, pixels, title, time, is_final });
    }
}

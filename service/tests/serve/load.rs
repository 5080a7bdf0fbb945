//! Four times as many requests as the service has places: as many are answered as there are places, each with its picture, and the
//! rest is told at once to come again.

use crate::service::{Answer, Service, ask, model, send_signal, start};
use std::sync::{Arc, Barrier};
use std::thread::JoinHandle;

const WORKERS: usize = 2;
const QUEUE: usize = 4;
/// Requests that the service has places for.
const CAPACITY: usize = WORKERS + QUEUE;
/// Good requests of a wave.
const WAVE: usize = 4 * CAPACITY;
const WAVES: usize = 3;
/// Bad requests of a wave.
const BAD: usize = 2 * CAPACITY;

/// Numbers from a seed (xorshift64*).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % end
    }

    fn of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.below(all.len())]
    }
}

#[derive(Clone)]
struct Asked {
    path: String,
    body: Vec<u8>,
    size: u32,
}

/// Good requests, none of which is another's equal.
fn good(random: &mut Random) -> Vec<Asked> {
    (0..WAVE * WAVES)
        .map(|k| {
            let size = 16 + k as u32;
            let (view, quality) =
                (random.of(&["front", "back", "left", "top"]), random.of(&["draft", "fast"]));
            let name = random.of(&["rounded-cube.glb", "rounded-cube.stl", "vase.ply"]);
            let format = random.of(&["background=white", "background=102030", "samples=4"]);
            let path =
                format!("/render?size={size}&view={view}&quality={quality}&{format}&format=png&name={name}");
            Asked { path, body: model(name), size }
        })
        .collect()
}

/// Requests that need no worker, with the status of their answer.
fn bad(random: &mut Random, broken: &[u8]) -> Vec<(Asked, u16)> {
    (0..BAD)
        .map(|_| {
            let (path, status) = match random.below(4) {
                0 => ("/render?size=999999", 400),
                1 => ("/nothing", 404),
                2 => ("/render?colour=red", 400),
                // The service knows that it cannot be drawn.
                _ => ("/render?size=16", 422),
            };
            (Asked { path: path.to_owned(), body: broken.to_vec(), size: 0 }, status)
        })
        .collect()
}

/// Asks all at the same time.
fn at_once(service: &Service, all: &[Asked]) -> Vec<JoinHandle<Answer>> {
    let barrier = Arc::new(Barrier::new(all.len()));
    let one = |asked: &Asked| {
        let (address, asked, barrier) = (service.address, asked.clone(), Arc::clone(&barrier));
        std::thread::spawn(move || {
            barrier.wait();
            // An answer that does not come is an error.
            ask(address, "POST", &asked.path, &[], &asked.body).unwrap()
        })
    };
    all.iter().map(one).collect()
}

fn retry_after(answer: &Answer) -> u64 {
    answer.headers["retry-after"].parse().unwrap()
}

/// Number of pictures, each of which is right; the others are refused and say when to come again.
fn pictures(asked: &[Asked], right: &[Vec<u8>], answers: Vec<JoinHandle<Answer>>) -> usize {
    let mut drawn = 0;
    for ((asked, right), answer) in asked.iter().zip(right).zip(answers) {
        let answer = answer.join().unwrap();
        if answer.status == 200 {
            assert!(answer.png(asked.size, asked.size) == right, "{}: another picture", asked.path);
            drawn += 1;
        } else {
            assert!(matches!(answer.status, 429 | 503), "{}: {}", asked.path, answer.status);
            assert!(matches!(answer.error(answer.status).0.as_str(), "queue_full" | "busy"));
            assert!((1..=60).contains(&retry_after(&answer)), "{:?}", answer.headers);
        }
    }
    drawn
}

#[test]
#[cfg(target_os = "linux")]
fn four_times_the_capacity_is_answered_or_refused() {
    let (workers, queue) = (WORKERS.to_string(), QUEUE.to_string());
    let service = start(&[
        "--workers",
        &workers,
        "--queue",
        &queue,
        "--queue-seconds",
        "100",
        "--failure-seconds",
        "3600",
    ]);
    let refused = || service.metric("overcoat_refusals_total{kind=\"queue_full\"}");
    let mut random = Random(0x6f76_6572_636f_6174);
    let broken = model("rounded-cube.glb")[..400].to_vec();
    service.post("/render?size=16", &broken).error(422);
    let all = good(&mut random);

    // At capacity everything is answered.
    let mut right = Vec::new();
    for wave in all.chunks(CAPACITY) {
        for (asked, answer) in wave.iter().zip(at_once(&service, wave)) {
            right.push(answer.join().unwrap().png(asked.size, asked.size).to_vec());
        }
    }
    assert_eq!(refused(), 0.0);

    // Workers that stand still: exactly as many wait as there are places, and all others are refused before anything is done.
    let ids = service.workers();
    assert_eq!(ids.len(), WORKERS);
    ids.iter().for_each(|id| send_signal("STOP", *id));
    let answers = at_once(&service, &all[..WAVE]);
    service.wait_for("overcoat_refusals_total{kind=\"queue_full\"}", (WAVE - CAPACITY) as f64);
    // Requests that need no worker are answered meanwhile, and take no place in the queue.
    let (bad, status): (Vec<Asked>, Vec<u16>) = bad(&mut random, &broken).into_iter().unzip();
    for (status, answer) in status.iter().zip(at_once(&service, &bad)) {
        let answer = answer.join().unwrap();
        assert_eq!(answer.status, *status);
        assert_eq!(answer.headers.contains_key("retry-after"), *status == 422);
    }
    assert!(answers.iter().filter(|answer| !answer.is_finished()).count() >= CAPACITY);
    assert_eq!(service.metric("overcoat_queue_length"), QUEUE as f64);
    ids.iter().for_each(|id| send_signal("CONT", *id));
    assert_eq!(pictures(&all[..WAVE], &right, answers), CAPACITY);
    assert_eq!(refused(), (WAVE - CAPACITY) as f64);

    // Workers that work, among bad requests: no fewer pictures than at capacity.
    let mut drawn = 0;
    for (wave, right) in all.chunks(WAVE).zip(right.chunks(WAVE)).skip(1) {
        let others = at_once(&service, &bad);
        let answers = at_once(&service, wave);
        let count = pictures(wave, right, answers);
        assert!(count >= CAPACITY, "{count}");
        drawn += count;
        for (status, answer) in status.iter().zip(others) {
            assert_eq!(answer.join().unwrap().status, *status);
        }
    }
    assert_eq!(refused(), (WAVES * WAVE - CAPACITY - drawn) as f64);

    // Nothing is left of it.
    let answers = at_once(&service, &all[..CAPACITY]);
    assert_eq!(pictures(&all[..CAPACITY], &right, answers), CAPACITY);
    for (name, value) in [
        ("overcoat_workers_busy", 0.0),
        ("overcoat_queue_length", 0.0),
        ("overcoat_workers_died_total", 0.0),
        ("overcoat_workers_timed_out_total", 0.0),
        ("overcoat_workers_started_total", WORKERS as f64),
    ] {
        assert_eq!(service.metric(name), value, "{name}");
    }
    assert_eq!(service.workers().len(), WORKERS);
}

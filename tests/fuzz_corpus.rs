//! Replays what fuzzing has found worth keeping: the corpus of every target, and every input that was once a finding.

#[allow(dead_code)]
#[path = "../fuzz/src/targets.rs"]
mod targets;

use std::path::Path;

#[test]
fn every_input_of_the_corpus_comes_back() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("fuzz/corpus");
    let (mut inputs, mut bytes) = (0, 0);
    for (name, target) in targets::TARGETS {
        let mut files: Vec<_> = std::fs::read_dir(root.join(name))
            .unwrap_or_else(|e| panic!("{name} has no corpus: {e}"))
            .map(|entry| entry.unwrap().path())
            .collect();
        files.sort();
        assert!(files.len() >= 2, "{name} has {} inputs", files.len());
        for file in files {
            let input = std::fs::read(&file).unwrap();
            inputs += 1;
            bytes += input.len();
            // A panic names the file that it is about.
            let run = std::panic::AssertUnwindSafe(|| target(&input));
            assert!(std::panic::catch_unwind(run).is_ok(), "{}", file.display());
        }
    }
    assert!(inputs > 100, "only {inputs} inputs");
    assert!(bytes < 300_000, "the corpus has {bytes} bytes: minimise it");
}

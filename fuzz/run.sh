#!/usr/bin/env bash
# fuzz/run.sh TARGET SECONDS: builds a target with coverage by the stable compiler and fuzzes it.
set -euo pipefail
cd "$(dirname "$0")"
target=$1 seconds=${2:-0}
coverage='-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4'
coverage+=' -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table'
coverage+=' -Cllvm-args=-sanitizer-coverage-trace-compares'
host=$(rustc -vV | sed -n 's/^host: //p')
# A target triple keeps the flags from build scripts.
RUSTFLAGS="--cfg fuzzing $coverage" cargo build --release --target "$host" --bin "$target"
mkdir -p "corpus/$target" "artifacts/$target"
dictionary=()
[ ! -f "dictionaries/$target.dict" ] || dictionary=("-dict=dictionaries/$target.dict")
exec "target/$host/release/$target" "corpus/$target" "${dictionary[@]}" -artifact_prefix="artifacts/$target/" \
    -max_total_time="$seconds" -max_len=16384 -timeout=10 -rss_limit_mb=1024

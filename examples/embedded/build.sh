#!/usr/bin/env bash
# Builds the program as small as it gets, for a target whose name ends in -linux-musl: it needs nothing of the system.
#
# Usage: examples/embedded/build.sh [TARGET [ARGUMENT OF CARGO...]]     aarch64-unknown-linux-musl by default
# The last line is its path.
set -euo pipefail
cd "$(dirname "$0")/../.."
target=${1-aarch64-unknown-linux-musl}
[ $# = 0 ] || shift
folder=target/embedded
# Functions of the same code are there once, and no table says how to unwind: a panic aborts.
RUSTFLAGS="-C linker=rust-lld -C link-arg=--icf=all -C link-arg=--no-eh-frame-hdr"
export RUSTFLAGS="$RUSTFLAGS -C link-arg=-T$PWD/examples/embedded/no-unwinding.ld"
cargo build --locked --profile embedded -p overcoat-embedded --target "$target" --target-dir "$folder" "$@" >&2
printf '%s\n' "$folder/$target/embedded/overcoat-embedded"

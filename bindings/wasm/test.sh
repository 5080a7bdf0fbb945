#!/usr/bin/env bash
# Builds the npm package for tests and runs them: in Node.js, in both test runners, and in Chromium. Takes what is missing from
# Debian (Chromium, Node.js) as root; Rust's libraries for WebAssembly from rustup, or where its servers cannot be reached
# from Debian, with a compiler of its own that builds the standard library along.
#
# Usage: bindings/wasm/test.sh [--all]   (with the command line for WASI and the small module, which take some minutes more to build)
# OVERCOAT: the native program to compare with. It is built if there is none in target/release.
set -euo pipefail
cd "$(dirname "$0")"
tree=$(realpath ../..)
parts=(simd plain)
[ "${1-}" != --all ] || parts+=(cli)

# shellcheck source=node_and_chromium.sh
. ./node_and_chromium.sh

npm ci --no-audit --no-fund

export OVERCOAT=${OVERCOAT-$tree/target/release/overcoat}
[ -x "$OVERCOAT" ] || cargo build --locked --release --bin overcoat --manifest-path "$tree/Cargo.toml"

# Bits are the same however the modules are built, and these are for one run.
export WASM_PROFILE=release CARGO_PROFILE_RELEASE_LTO=off CARGO_INCREMENTAL=0

for triple in wasm32-unknown-unknown wasm32-wasip1; do
    [ -d "$(rustc --print sysroot)/lib/rustlib/$triple" ] || rustup target add "$triple" 2>/dev/null || missing=yes
done
if [ "${missing-}" = yes ]; then
    # shellcheck source=../../tests/machines/compilers.sh
    . "$tree/tests/machines/compilers.sh"
    second_compiler || { printf 'no compiler for WebAssembly: %s\n' "$why" >&2; exit 1; }
    export RUSTC_BOOTSTRAP=1 BUILD_STD='-Z build-std=std,panic_abort'
    linker=$(env -u RUSTC rustc --print sysroot)/lib/rustlib/x86_64-unknown-linux-gnu/bin/rust-lld
    export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=$linker
    # The command line needs the C library of WASI as of today's standard library, which Debian has not.
    parts=(simd plain)
fi
start=$SECONDS
./build.sh "${parts[@]}"
[ "${1-}" != --all ] || WASM_FEATURES=--no-default-features WASM_DIST=dist/small ./build.sh plain
printf '%5d s  build\n' $((SECONDS - start))
unset RUSTC RUSTC_BOOTSTRAP CARGO_PROFILE_RELEASE_LTO

start=$SECONDS
# One file after the other: each uses all processors, and some all memory.
node --test --test-concurrency=1 test/*.test.js
printf '%5d s  tests\n' $((SECONDS - start))

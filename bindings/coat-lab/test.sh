#!/usr/bin/env bash
# Builds the WebAssembly of the page docs/src/coat-lab/ for tests and runs them in Node.js and in Chromium: its numbers are those of
# `overcoat lab`. Takes Chromium and Node.js from Debian as root where they are missing.
#
# Usage: bindings/coat-lab/test.sh
# OVERCOAT: the native program to compare with. It is built if there is none in target/release.
# SCREENSHOTS: a folder for pictures of the page.
set -euo pipefail
cd "$(dirname "$0")"
tree=$(realpath ../..)

# shellcheck source=../wasm/node_and_chromium.sh
. ../wasm/node_and_chromium.sh
[ -d ../wasm/node_modules/playwright-core ] || (cd ../wasm && npm ci --no-audit --no-fund)

export OVERCOAT=${OVERCOAT-$tree/target/release/overcoat}
[ -x "$OVERCOAT" ] || cargo build --locked --release --bin overcoat --manifest-path "$tree/Cargo.toml"

start=$SECONDS
# Bits are the same however the module is built, and this is for one run.
WASM_PROFILE=release CARGO_PROFILE_RELEASE_LTO=off CARGO_INCREMENTAL=0 ./build.sh
printf '%5d s  build\n' $((SECONDS - start))
start=$SECONDS
node --test test/*.test.mjs
printf '%5d s  tests\n' $((SECONDS - start))

#!/usr/bin/env bash
# Builds the WebAssembly of the page docs/src/coat-lab/ into docs/src/coat-lab/dist/.
#
# Usage: bindings/coat-lab/build.sh, then node bindings/wasm/scripts/serve.mjs 8080 docs/src, and open /coat-lab/
# WASM_PROFILE: profile of Cargo, "wasm" (small and slow to build) or "release".
# WASM_TARGET_DIR: folder of what is compiled, if not target/wasm.
# Needs rustup with the target wasm32-unknown-unknown, or what RUSTC and BUILD_STD say.
set -euo pipefail
cd "$(dirname "$0")"
profile=${WASM_PROFILE-wasm}
target=$(realpath ../../target 2>/dev/null || (mkdir -p ../../target && realpath ../../target))
target=${WASM_TARGET_DIR-$target/wasm}
dist=../../docs/src/coat-lab/dist
export CARGO_TERM_COLOR=never

# shellcheck disable=SC2086
cargo build --locked --manifest-path ../../Cargo.toml --profile "$profile" ${BUILD_STD-} -p overcoat-coat-lab \
    --target wasm32-unknown-unknown --target-dir "$target/coat-lab"
# By the first toolchain: it runs here.
(unset RUSTC RUSTC_BOOTSTRAP && cd ../wasm/bindgen && cargo build --locked --quiet --target-dir "$target/bindgen")
rm -rf "$dist"
mkdir -p "$dist"
"$target/bindgen/debug/overcoat-bindgen" "$target/coat-lab/wasm32-unknown-unknown/$profile/overcoat_coat_lab.wasm" "$dist"
printf '%s\n' "$dist: $(wc -c <"$dist/overcoat_bg.wasm") bytes of WebAssembly, $(gzip -9 <"$dist/overcoat_bg.wasm" | wc -c) packed"

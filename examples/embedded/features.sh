#!/usr/bin/env bash
# The library compiles without warnings without features, with each of them alone and with all that it draws with.
set -euo pipefail
cd "$(dirname "$0")/../.."
mapfile -t features < <(sed -n '/^\[features\]$/,/^\[lib\]$/s/^\([a-z0-9-]*\) = .*/\1/p' Cargo.toml)
[ "${#features[@]}" -gt 12 ]
for feature in '' "${features[@]}"; do
    cargo clippy --locked --quiet -p overcoat --lib --no-default-features --features "$feature" --target-dir target/features -- -D warnings
    printf 'compiles with %s\n' "${feature:-nothing}"
done

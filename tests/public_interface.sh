#!/usr/bin/env bash
# The public interface of the library is that of tests/public_interface.txt, which is changed by UPDATE_INTERFACE=1.
#
# rustdoc's JSON has no stable form yet: a toolchain whose form the reader does not know is named, and nothing is compared.
set -euo pipefail
cd "$(dirname "$0")/.."
accepted=tests/public_interface.txt
folder=target/public-interface
mkdir -p "$folder"
rm -f "$folder"/*.json
# rustdoc alone is asked for what is not stable: build scripts look at this variable, and would run again.
printf '#!/bin/sh\nRUSTC_BOOTSTRAP=1 exec rustdoc "$@" -Z unstable-options --output-format json --cap-lints allow\n' >"$folder/rustdoc"
chmod +x "$folder/rustdoc"
# In one go, so that each has the features that the library has with all of its own.
packages=(overcoat overcoat-{core,scene,image,load,golden,stages,tiles,render,lab,sandbox,description})
RUSTDOC=$PWD/$folder/rustdoc cargo doc --locked --quiet --no-deps --lib "${packages[@]/#/--package=}" \
    --features overcoat/full,overcoat/cache,overcoat/sandbox,overcoat/truth
for package in "${packages[@]}"; do cp "target/doc/${package//-/_}.json" "$folder/"; done
cargo build --locked --quiet --release --manifest-path tests/public_interface/Cargo.toml --target-dir target/tools
if ! target/tools/release/public-interface "$folder" >"$folder/found.txt" 2>"$folder/said.txt"; then
    grep -q 'format.version' "$folder/said.txt" || { cat "$folder/said.txt" >&2; exit 1; }
    printf 'left out: %s has another form of JSON\n' "$(rustc --version)"
    exit 0
fi
printf '%s items\n' "$(wc -l <"$folder/found.txt")"
[ "${UPDATE_INTERFACE-}" != 1 ] || cp "$folder/found.txt" "$accepted"
if ! diff -u "$accepted" "$folder/found.txt"; then
    printf 'The public interface has changed. If that was meant: UPDATE_INTERFACE=1 tests/public_interface.sh, and a line in CHANGELOG.md\n' >&2
    exit 1
fi

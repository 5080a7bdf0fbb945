#!/usr/bin/env bash
# The program as one file that needs nothing of the system: Linux on x86-64 or 64-bit ARM, linked with musl.
#
# Needs rustup, which fetches the libraries of the target; the linker is the compiler's own.
# Usage: packaging/static.sh [x86_64|aarch64]...   (default: x86_64)
# Writes target/packages/overcoat-VERSION-linux-ARCH.
# RUSTFLAGS are added to. OVERCOAT_STATIC_BINARY, if set, is a file to take in place of building one.
. "$(dirname "$0")/common.sh"
[ $# -gt 0 ] || set -- x86_64

# Folders of this machine are no business of the program's, and would make its bytes differ.
flags="${RUSTFLAGS-} -C linker=rust-lld --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo --remap-path-prefix=$PWD=/overcoat"

for arch in "$@"; do
    case $arch in x86_64 | aarch64) ;; *) die "no architecture '$arch': x86_64, aarch64" ;; esac
    out=$packages/overcoat-$version-linux-$arch
    built=${OVERCOAT_STATIC_BINARY-}
    if [ -z "$built" ]; then
        target=$arch-unknown-linux-musl
        rustup target list --installed | grep -qx "$target" || rustup target add "$target" ||
            die "rustup cannot get the libraries of $target"
        RUSTFLAGS=$flags CARGO_INCREMENTAL=0 CARGO_TARGET_DIR=$PWD/target/static \
            cargo build --locked --release --bin overcoat --target "$target"
        built=$PWD/target/static/$target/release/overcoat
    fi
    install -m 755 "$built" "$out"
    touch -d "@$SOURCE_DATE_EPOCH" "$out"
    printf '%s, %d bytes\n' "$out" "$(stat -c %s "$out")"
done

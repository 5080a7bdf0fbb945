#!/usr/bin/env bash
# Programs as files that need nothing of the system: Linux on x86-64 or 64-bit ARM, linked with musl.
#
# Needs rustup, which fetches the libraries of the target; the linker is the compiler's own. overcoat-service has cryptography in C
# and assembly, too, and needs a C compiler: on the processor that it is for musl-gcc (apt-get install musl-tools), for the other
# one a compiler of one's own, named by CC_x86_64_unknown_linux_musl or CC_aarch64_unknown_linux_musl.
# Usage: packaging/static.sh [x86_64|aarch64|overcoat|overcoat-service]...   (default: x86_64 overcoat)
# Writes target/packages/PROGRAM-VERSION-linux-ARCH, each program for each architecture.
# RUSTFLAGS are added to. OVERCOAT_STATIC_BINARY and OVERCOAT_SERVICE_STATIC_BINARY, if set, are files to take in place of building.
. "$(dirname "$0")/common.sh"

architectures=() programs=()
for argument in "$@"; do
    case $argument in
        x86_64 | aarch64) architectures+=("$argument") ;;
        overcoat | overcoat-service) programs+=("$argument") ;;
        *) die "no architecture or program '$argument': x86_64, aarch64; overcoat, overcoat-service" ;;
    esac
done
[ ${#architectures[@]} -gt 0 ] || architectures=(x86_64)
[ ${#programs[@]} -gt 0 ] || programs=(overcoat)

# Folders of this machine are no business of the program's, and would make its bytes differ.
flags="${RUSTFLAGS-} -C linker=rust-lld --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo --remap-path-prefix=$PWD=/overcoat"
c_flags="${CFLAGS-} -ffile-prefix-map=${CARGO_HOME:-$HOME/.cargo}=/cargo -ffile-prefix-map=$PWD=/overcoat"

# compiler_of TARGET: sets the compiler of the C parts for cargo.
compiler_of() {
    local variable=CC_${1//-/_}
    if [ -z "${!variable-}" ]; then
        [ "${1%%-*}" = "$(uname -m)" ] ||
            die "overcoat-service for $1 needs a C compiler for it: $variable=COMPILER names one"
        need musl-gcc musl-tools
        export "$variable=musl-gcc"
    fi
    command -v "${!variable%% *}" >/dev/null || die "$variable: there is no ${!variable%% *}"
}

for arch in "${architectures[@]}"; do
    for program in "${programs[@]}"; do
        out=$packages/$program-$version-linux-$arch
        variable=$(binary_variable "$program" STATIC_)
        built=${!variable-}
        if [ -z "$built" ]; then
            target=$arch-unknown-linux-musl
            rustup target list --installed | grep -qx "$target" || rustup target add "$target" ||
                die "rustup cannot get the libraries of $target"
            [ "$program" = overcoat ] || compiler_of "$target"
            RUSTFLAGS=$flags CFLAGS=$c_flags CARGO_INCREMENTAL=0 CARGO_TARGET_DIR=$PWD/target/static \
                cargo build --locked --release -p "$(package_of "$program")" --bin "$program" --target "$target"
            built=$PWD/target/static/$target/release/$program
        fi
        install -m 755 "$built" "$out"
        touch -d "@$SOURCE_DATE_EPOCH" "$out"
        printf '%s, %d bytes\n' "$out" "$(stat -c %s "$out")"
    done
done

#!/usr/bin/env bash
# Builds what of the npm package is WebAssembly into dist/: the renderer for browsers and Node.js, with and without vectors,
# and the command line for WASI. Parts that are named are built, or all.
#
# Usage: bindings/wasm/build.sh [plain] [simd] [cli]
# WASM_PROFILE: profile of Cargo, "wasm" (small and slow to build) or "release".
# WASM_FEATURES: arguments of Cargo; --no-default-features leaves glTF with PNG and JPEG, and the models standard and stacklit-d.
# WASM_DIST: where it goes, if not to dist/.
# Needs rustup with the targets wasm32-unknown-unknown and wasm32-wasip1, or what RUSTC and BUILD_STD say.
set -euo pipefail
cd "$(dirname "$0")"
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(plain simd cli)
profile=${WASM_PROFILE-wasm}
target=$(realpath ../../target 2>/dev/null || (mkdir -p ../../target && realpath ../../target))
target=${WASM_TARGET_DIR-$target/wasm}
dist=${WASM_DIST-dist}
export CARGO_TERM_COLOR=never

# compile PACKAGE-ARGUMENTS...: with the standard library of rustup, or one that is compiled along.
compile() {
    # shellcheck disable=SC2086
    cargo build --locked --manifest-path ../../Cargo.toml --profile "$profile" ${BUILD_STD-} "$@"
}

bindgen() {
    # By the first toolchain: it runs here.
    (unset RUSTC RUSTC_BOOTSTRAP && cd bindgen && cargo build --locked --quiet --target-dir "$target/bindgen")
    "$target/bindgen/debug/overcoat-bindgen" "$@"
}

for part in "${parts[@]}"; do
    printf '== %s\n' "$part"
    case $part in
        plain | simd)
            features='' level=s
            # Vectors at 3 only: at s or 1 the compiler takes 7 GB of memory and longer.
            [ "$part" = plain ] || features='-C target-feature=+simd128' level=3
            export "CARGO_PROFILE_${profile^^}_OPT_LEVEL=$level"
            RUSTFLAGS=$features compile -p overcoat-wasm ${WASM_FEATURES-} --target wasm32-unknown-unknown --target-dir "$target/$part"
            rm -rf "$dist/$part"
            mkdir -p "$dist/$part"
            bindgen "$target/$part/wasm32-unknown-unknown/$profile/overcoat_wasm.wasm" "$dist/$part" ;;
        cli)
            export "CARGO_PROFILE_${profile^^}_OPT_LEVEL=3"
            RUSTFLAGS='-C target-feature=+simd128' compile -p overcoat-cli --bin overcoat --target wasm32-wasip1 --target-dir "$target/cli"
            mkdir -p "$dist/cli"
            cp "$target/cli/wasm32-wasip1/$profile/overcoat.wasm" "$dist/cli/overcoat.wasm" ;;
        *)
            printf 'unknown part %s\n' "$part" >&2
            exit 2 ;;
    esac
done

# Models of the demo page are those of the tree.
mkdir -p demo/models
cp ../../assets/models/{sports-car,material-ball,torus-knot,vase,draped-cloth,rounded-cube}.glb demo/models/

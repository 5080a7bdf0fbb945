#!/usr/bin/env bash
# What each feature of the library adds to the small program: a table for README.md. Without optimisation over all of the
# program at once, which would take three times as long for sizes that are some percent less; EMBEDDED_LTO=fat has it.
#
# Usage: examples/embedded/sizes.sh [FEATURE...]     all by default; TARGET: aarch64-unknown-linux-musl by default
set -euo pipefail
cd "$(dirname "$0")/../.."
target=${TARGET-aarch64-unknown-linux-musl}
CARGO_PROFILE_EMBEDDED_LTO=${EMBEDDED_LTO-off}
[ "$CARGO_PROFILE_EMBEDDED_LTO" = fat ] || export CARGO_PROFILE_EMBEDDED_CODEGEN_UNITS=16
export CARGO_PROFILE_EMBEDDED_LTO
features=("$@")
if [ $# = 0 ]; then
    features=(
        obj 3mf more-models compression textures more-textures exr engines light effects description builtin-materials fast-loading threads
        default full
    )
fi

# size FEATURE: of the program with it.
size() { stat -c %s "$(examples/embedded/build.sh "$target" ${1:+--features "overcoat/$1"} 2>/dev/null)"; }

base=$(size '')
printf '| feature | bytes |\n|---|---:|\n| none, with STL | %s |\n' "$base"
for feature in "${features[@]}"; do
    printf '| `%s` | %s |\n' "$feature" "$(($(size "$feature") - base))"
done

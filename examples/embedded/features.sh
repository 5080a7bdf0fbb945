#!/usr/bin/env bash
# The library compiles without warnings with each part of it alone. Features that are asked as `cfg!` have their code checked in
# each of these: they are taken together.
set -euo pipefail
cd "$(dirname "$0")/../.."
export CARGO_INCREMENTAL=0
for features in '' threads wide-lanes area-lights car-paint environments shadows splats \
    all-formats,all-models,builtin-materials,quick-studio,streamed-json; do
    RUSTFLAGS="${RUSTFLAGS-} -D warnings" cargo check --locked --quiet -p overcoat --lib --no-default-features --features "$features" \
        --target-dir target/features
    printf 'compiles with %s\n' "${features:-nothing}"
done

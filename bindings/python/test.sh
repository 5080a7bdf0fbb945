#!/usr/bin/env bash
# Builds the wheel and runs all tests of the Python package against it, in an environment of its own (target/python). Needs Rust,
# Python 3.9 or later and PyPI; on Debian it installs what else is missing.
#
# With PACKAGES_TESTED, as .ci/run sets it, the module is built together with those packages (see cargo-shared). Where
# target/release/overcoat is there, its pictures are compared with those of the module.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
environment=$root/target/python

# install PACKAGE...: of Debian, as root.
install() {
    command -v apt-get >/dev/null || return 0
    apt-get update -qq >/dev/null && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "$@" >/dev/null
}

command -v python3 >/dev/null || install python3
if ! [ -x "$environment/bin/pip" ]; then
    python3 -m venv "$environment" 2>/dev/null || { install python3-venv && python3 -m venv --clear "$environment"; }
fi
# Version numbers are those that the tests were written with; a newer trimesh may have another example.
"$environment/bin/pip" install --quiet --disable-pip-version-check \
    'maturin>=1.16,<2' 'numpy>=1.22' pytest mypy 'pyright[nodejs]' 'trimesh<6' 'pyrender==0.1.45' pillow rtree networkx \
    nbclient nbformat ipykernel typing_extensions
python=$environment/bin/python
"$python" -c 'import pyrender' 2>/dev/null || install libgl1 libegl1 libgl1-mesa-dri libglu1-mesa

wheels=$target/python-wheels
rm -rf "$wheels"
export SHARED_CARGO=${CARGO:-cargo}
CARGO=$PWD/cargo-shared "$environment/bin/maturin" build --release --locked --compression-level 9 --interpreter "$python" --out "$wheels"
wheel=$(echo "$wheels"/overcoat-*.whl)
bytes=$(stat -c %s "$wheel")
echo "$(basename "$wheel"): $bytes bytes"
# Built without link-time optimisation by .ci/run.
[ "$bytes" -lt 12000000 ] || { echo 'the wheel is larger than 12 MB' >&2; exit 1; }
"$environment/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheel"

if [ -z "${OVERCOAT_COMMAND-}" ] && [ -x "$target/release/overcoat" ]; then
    export OVERCOAT_COMMAND=$target/release/overcoat
fi
export PATH=$environment/bin:$PATH
"$python" -m pytest -q -p no:cacheprovider --durations=5 "$@"

#!/bin/sh
# Tests overcoat-step, and where the program overcoat is on the path (or named by OVERCOAT) draws a picture through it. Says so
# and does nothing where there is no OpenCASCADE. Continuous integration has none: it is run by hand, `make check`.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
if [ ! -e "${OCCT_INCLUDE:-/usr/include/opencascade}/STEPCAFControl_Reader.hxx" ] && [ ! -x "$here/overcoat-step" ]; then
    echo "SKIPPED, NOTHING WAS TESTED: there is no OpenCASCADE here (libocct-data-exchange-dev)" >&2
    exit 0
fi
make -C "$here" overcoat-step
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 "$here/check.py" "$folder"
overcoat=${OVERCOAT:-overcoat}
if ! command -v "$overcoat" >/dev/null; then
    echo "SKIPPED: no program overcoat, so no picture was drawn" >&2
    exit 0
fi
sed "s|\"overcoat-step\"|\"$here/overcoat-step\"|" "$here/step.toml" > "$folder/converters.toml"
"$overcoat" thumbnail "$folder/pair.step" "$folder/pair.png" --converters "$folder/converters.toml"
"$overcoat" info --json "$folder/pair.step" --converters "$folder/converters.toml" | grep -q '"instances": 4'
head -c 2000 "$folder/pair.step" > "$folder/cut.step"
if "$overcoat" thumbnail "$folder/cut.step" "$folder/cut.png" --converters "$folder/converters.toml" 2> "$folder/told"; then
    echo "a file that is cut was drawn" >&2
    exit 1
fi
grep -q 'converter step: ' "$folder/told"
echo "overcoat with overcoat-step: passed"

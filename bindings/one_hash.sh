#!/usr/bin/env bash
# One picture by the command, Rust, C, Python, Node.js and a browser: one hash. Takes what the test.sh of each has built; what is not
# there is named and left out. `--all`: then that is a failure.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-$PWD/target}
model=$PWD/assets/models/rounded-cube.glb
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
missing=0 count=0

expected=$("$target/release/overcoat" render "$model" --size 96x64 -o "$work/x.png" --json -q |
    sed -n 's/.*"frame_hash": "\([0-9a-f]*\)".*/\1/p')
test ${#expected} = 32
printf '%-10s %s\n' command "$expected"

# one NAME HASH: must be that of the command.
one() {
    printf '%-10s %s\n' "$1" "$2"
    [ "$2" = "$expected" ] || { echo "$1 draws another picture" >&2; exit 1; }
    count=$((count + 1))
}
left_out() {
    printf '%-10s not built\n' "$1"
    missing=$((missing + 1))
}

if [ -e "$target/release/libovercoat.so" ]; then
    cat >"$work/hash.c" <<'C'
#include "overcoat.h"
#include <stdio.h>
int main(int count, char **arguments) {
    overcoat *o = NULL;
    uint64_t world, model;
    static uint8_t pixels[96 * 64 * 4];
    overcoat_picture picture;
    overcoat_target target;
    overcoat_result result;
    OVERCOAT_INIT(picture), OVERCOAT_INIT(target), OVERCOAT_INIT(result);
    picture.width = 96, picture.height = 64, picture.wants_hash = true;
    target.pixels = pixels, target.length = sizeof pixels;
    if (count != 2 || overcoat_new(NULL, &o) || overcoat_world_new(o, &world) ||
        overcoat_load_file(o, world, arguments[1], NULL, NULL, NULL, &model) ||
        overcoat_render(o, world, NULL, &picture, &target, &result)) return 1;
    puts(result.hash);
    overcoat_free(&o);
    return 0;
}
C
    cc -Ibindings/c/include "$work/hash.c" -o "$work/hash" -L"$target/release" -lovercoat
    ln -sf "$target/release/libovercoat.so" "$work/$(objdump -p "$target/release/libovercoat.so" | awk '$1 == "SONAME" { print $2 }')"
    one C "$(LD_LIBRARY_PATH=$work "$work/hash" "$model")"
else
    left_out C
fi

if [ -x target/python/bin/python ] && target/python/bin/python -c 'import overcoat' 2>/dev/null; then
    one Python "$(target/python/bin/python -c 'import overcoat, sys; print(overcoat.render(sys.argv[1], size=(96, 64)).hash)' "$model")"
else
    left_out Python
fi

if [ -d bindings/wasm/dist/simd ] && command -v node >/dev/null; then
    cat >"$work/hash.mjs" <<JS
import { readFile } from "node:fs/promises";
const { render } = await import("$PWD/bindings/wasm/js/index.js");
const image = await render(await readFile(process.argv[2]), { size: [96, 64] });
console.log(image.hash);
JS
    one Node.js "$(node --no-warnings "$work/hash.mjs" "$model")"
else
    left_out Node.js
fi
echo "$count languages, one picture (a browser's is held against Node's by bindings/wasm/test/)"
[ "${1-}" != --all ] || [ $missing = 0 ]

#!/usr/bin/env bash
# The interface for C and C++: the header is that of the sources, and programs are compiled against it as strangers would, with the
# shared and with the static library, and run: alone, under valgrind, with the address sanitizer, and in a window without a screen.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
here=$root/bindings/c
target=${CARGO_TARGET_DIR:-$root/target}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

needed=()
command -v gcc >/dev/null && command -v g++ >/dev/null || needed+=(gcc g++)
command -v valgrind >/dev/null || needed+=(valgrind)
command -v pkg-config >/dev/null || needed+=(pkg-config)
[ -n "${SKIP_QT-}" ] || pkg-config --exists Qt5Widgets 2>/dev/null || needed+=(qtbase5-dev)
[ -n "${SKIP_QT-}" ] || command -v Xvfb >/dev/null || needed+=(xvfb)
[ -n "${SKIP_QT-}" ] || command -v xauth >/dev/null || needed+=(xauth)
command -v objdump >/dev/null || needed+=(binutils)
command -v python3 >/dev/null || needed+=(python3)
if [ ${#needed[@]} -gt 0 ]; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${needed[@]}" >/dev/null
fi

# Together with whatever CI has built already: packages that are built apart have other features of what they share.
read -ra what <<<"${PACKAGES_TESTED+$PACKAGES_TESTED --lib --bins --tests}"
[ -n "${what-}" ] || what=(-p overcoat-cli -p overcoat-capi --lib --bins)
cargo build --locked --release "${what[@]}"
[ -n "${PACKAGES_TESTED-}" ] || cargo test --locked --release -p overcoat-capi --test header

# As an installation has it.
bindings/c/install.sh --prefix "$work/usr" --from "$target/release"
export PKG_CONFIG_PATH=$work/usr/lib/pkgconfig LD_LIBRARY_PATH=$work/usr/lib
soname=$(objdump -p "$work/usr/lib/libovercoat.so" | awk '$1 == "SONAME" { print $2 }')
test "$soname" = libovercoat.so.0.1
# Nothing else is exported.
exported=$(nm -D --defined-only "$work/usr/lib/libovercoat.so" | awk '{ print $3 }' | sed 's/@.*//' | grep -v '^overcoat_' | grep -v '^_\(init\|fini\)$' || true)
test -z "$exported" || { printf 'exported beside the interface:\n%s\n' "$exported" >&2; exit 1; }

# The default picture, the same at every door.
read -r model _ hash <"$root/tests/default-picture.txt"
model=$root/$model
test ${#hash} = 32

strict=(-Wall -Wextra -Wpedantic -Werror -O1 -g)
read -ra shared < <(pkg-config --cflags --libs overcoat)
read -ra static < <(pkg-config --cflags --libs --static overcoat | sed "s|-lovercoat|$work/usr/lib/libovercoat.a|")

echo '== C, shared'
gcc -std=gnu11 "${strict[@]}" "$here/tests/interface.c" -o "$work/shared" "${shared[@]}" -lpthread -lm
"$work/shared" "$model" "$hash"
gcc -std=gnu11 "${strict[@]}" "$here/tests/parameters.c" -o "$work/parameters" "${shared[@]}" -lm
"$work/parameters"
echo '== C, static, address sanitizer'
gcc -std=gnu11 "${strict[@]}" -fsanitize=address,undefined "$here/tests/interface.c" -o "$work/sanitized" "${static[@]}" -lm
env -u LD_LIBRARY_PATH "$work/sanitized" "$model" "$hash"
gcc -std=gnu11 "${strict[@]}" -fsanitize=address,undefined "$here/tests/parameters.c" -o "$work/sanitized-parameters" "${static[@]}" -lm
env -u LD_LIBRARY_PATH "$work/sanitized-parameters"
# Fair: the thread that stops a picture has its turns beside those that draw it.
echo '== C, valgrind'
valgrind -q --fair-sched=try --error-exitcode=9 --suppressions="$here/tests/valgrind.supp" --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite \
    "$work/shared" "$model" "$hash"

echo '== a program of an older header'
# Materials ended with emission then, lights with their range, meshes with colours of faces, cameras with their near plane.
mkdir -p "$work/older"
awk '
    /^typedef struct \{/ { text = ""; inside = 1 }
    { if (inside) text = text $0 "\n"; else print }
    /^\} overcoat_/ {
        if (/overcoat_material;/) sub(/float emissive\[3\];.*\n\}/, "float emissive[3];\n}", text)
        if (/overcoat_light;/) sub(/float range;.*\n\}/, "float range;\n}", text)
        if (/overcoat_mesh;/) sub(/const uint8_t \*face_colors;.*\n\}/, "const uint8_t *face_colors;\n}", text)
        if (/overcoat_camera;/) sub(/float near;.*\n\}/, "float near;\n}", text)
        printf "%s", text; inside = 0
    }' "$work/usr/include/overcoat.h" >"$work/older/overcoat.h"
gcc -std=gnu11 "${strict[@]}" "$here/tests/older.c" -o "$work/newer-program" "${shared[@]}"
gcc -std=gnu11 "${strict[@]}" -I"$work/older" "$here/tests/older.c" -o "$work/older-program" "${shared[@]}"
read -r new_material new_light new_mesh new_camera new_hash < <("$work/newer-program")
read -r old_material old_light old_mesh old_camera old_hash < <("$work/older-program")
test "$old_material" -lt "$new_material" && test "$old_light" -lt "$new_light"
test "$old_mesh" -lt "$new_mesh" && test "$old_camera" -lt "$new_camera"
test "$old_hash" = "$new_hash"

echo '== examples'
gcc -std=c11 "${strict[@]}" "$here/examples/thumbnail.c" -o "$work/thumbnail" "${shared[@]}"
"$work/thumbnail" "$model" "$work/thumbnail.png" 128
"$target/release/overcoat" render "$model" --size 128 -o "$work/expected.png" -q
cmp "$work/thumbnail.png" "$work/expected.png"
if "$work/thumbnail" /nowhere.glb "$work/none.png" 2>"$work/error"; then exit 1; fi
grep -q '/nowhere.glb: /nowhere.glb: cannot be read' "$work/error"
test ! -e "$work/none.png"
gcc -std=c11 "${strict[@]}" "$here/examples/depth.c" -o "$work/depth" "${shared[@]}"
"$work/depth" "$model" "$work/depth.exr" | grep -q ' m away, at .*, of the model$'
# The linear picture of the command, in every bit.
"$target/release/overcoat" render "$model" --size 160x120 --ground none -o "$work/expected.exr" -q
"$target/release/overcoat" golden check "$work/depth.exr" "$work/expected.exr"
# There is no GPU here, or one: either draws, and the processor draws the picture of the command.
gcc -std=c11 "${strict[@]}" "$here/examples/fallback.c" -o "$work/fallback" "${shared[@]}" -ldl
"$work/fallback" "$model" "$work/fallback.png" 2>"$work/error" | grep -q '^drawn by the \(gpu\|processor\)$'
"$work/fallback" "$model" "$work/fallback.png" processor | grep -q '^drawn by the processor$'
"$target/release/overcoat" render "$model" --size 640x360 -o "$work/expected.png" -q
cmp "$work/fallback.png" "$work/expected.png"
if "$work/fallback" /nowhere.glb "$work/none.png" processor 2>"$work/error"; then exit 1; fi
grep -q '^processor: /nowhere.glb: cannot be read' "$work/error"
# The listing of README.md.
awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on' "$here/README.md" >"$work/listing.c"
gcc -std=c11 "${strict[@]}" "$work/listing.c" -o "$work/listing" "${shared[@]}"
"$work/listing" "$model" | grep -q '^the pixel in the middle: [0-9]* [0-9]* [0-9]* 255$'
g++ -std=c++17 "${strict[@]}" "$here/examples/slicer_thumbnail.cpp" -o "$work/slicer" "${shared[@]}"
"$work/slicer" "$work/plate.gcode" "$work/plate.3mf"
test "$(grep -c '^; thumbnail begin' "$work/plate.gcode")" = 2
# The blocks are PNG pictures of their size; the 3MF is read again, with all of its triangles.
python3 - "$work/plate.gcode" "$work/plate.3mf" <<'PY'
import base64, re, struct, sys, zipfile
text = open(sys.argv[1]).read()
for width, height, count, body in re.findall(r"; thumbnail begin (\d+)x(\d+) (\d+)\n(.*?); thumbnail end", text, re.S):
    digits = "".join(line[2:] for line in body.splitlines())
    assert len(digits) == int(count)
    png = base64.b64decode(digits, validate=True)
    assert png[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", png[16:24]) == (int(width), int(height))
with zipfile.ZipFile(sys.argv[2]) as package:
    assert package.testzip() is None and package.read("Metadata/thumbnail.png")[:4] == b"\x89PNG"
PY
"$target/release/overcoat" info "$work/plate.3mf" | grep -q '14,400 triangles\|14400'

if [ -z "${SKIP_QT-}" ]; then
    echo '== Qt'
    read -ra qt < <(pkg-config --cflags --libs Qt5Widgets)
    g++ -std=c++17 -fPIC -Wall -Wextra -Werror -O1 "$here/examples/qt/viewer.cpp" -o "$work/viewer" "${shared[@]}" "${qt[@]}"
    xvfb-run -a "$work/viewer" "$model" --grab "$work/grab.png"
    "$target/release/overcoat" render "$model" --size 640x480 --quality good --background '#383a3e' -o "$work/window.png" -q
    # What the widget shows is the picture of the command, in every pixel.
    "$target/release/overcoat" golden check "$work/grab.png" "$work/window.png"
fi
echo 'C: all is well'

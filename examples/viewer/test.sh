#!/usr/bin/env bash
# The viewer in a real window, without a screen: what it shows is the picture of the command, and keys, mouse and files do what they
# say. Needs Xvfb, xdotool, xwd and Python; installs them on Debian.
#
#     examples/viewer/test.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
if ! { command -v Xvfb && command -v xdotool && command -v xwd && ldconfig -p | grep libxkbcommon-x11; } >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        xvfb xdotool x11-apps libxcursor1 libxi6 libxrandr2 libxkbcommon-x11-0 libx11-xcb1 >/dev/null
fi
# Together with whatever CI has built already: packages that are built apart have other features of what they share.
read -ra what <<<"${PACKAGES_TESTED+$PACKAGES_TESTED --lib --bins --tests}"
[ -n "${what-}" ] || what=(-p overcoat-cli -p overcoat-viewer --bins)
cargo build --locked --release "${what[@]}"
viewer=${CARGO_TARGET_DIR:-target}/release/overcoat-viewer
overcoat=${CARGO_TARGET_DIR:-target}/release/overcoat
work=$(mktemp -d)
display=:$((90 + RANDOM % 900))
Xvfb "$display" -screen 0 800x600x24 >/dev/null 2>&1 &
server=$!
trap 'kill $server 2>/dev/null; rm -rf "$work"' EXIT
export DISPLAY=$display
for _ in $(seq 100); do xdotool getmouselocation >/dev/null 2>&1 && break; sleep 0.1; done

model=assets/models/sports-car.glb
"$viewer" "$model" --size 320x200 --quality fast >"$work/said" 2>"$work/errors" &
process=$!

# waits until its last line says so
said() {
    for _ in $(seq 300); do
        tail -n 1 "$work/said" | grep -q -- "$1" && return
        kill -0 $process || break
        sleep 0.1
    done
    echo "the viewer did not say: $1" >&2
    cat "$work/said" "$work/errors" >&2
    exit 1
}
# the pixels of the window as PNG
shot() {
    xwd -silent -id "$window" -out "$work/window.xwd"
    python3 - "$work/window.xwd" "$1" <<'PY'
import struct, sys, zlib
data = open(sys.argv[1], "rb").read()
head = struct.unpack(">25I", data[:100])
size, width, height, order, bits, stride, colors = head[0], head[4], head[5], head[7], head[11], head[12], head[19]
assert bits == 32
pixels = data[size + 12 * colors:]
rows = b""
for y in range(height):
    row = pixels[y * stride : y * stride + 4 * width]
    b, g, r = (row[0::4], row[1::4], row[2::4]) if order == 0 else (row[3::4], row[2::4], row[1::4])
    rows += b"\0" + bytes(v for rgb in zip(r, g, b) for v in rgb)
def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
open(sys.argv[2], "wb").write(png + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
PY
}
same() { "$overcoat" golden check "$1" "$2" --quiet; }

said 'fast, 8 samples'
window=$(xdotool search --name overcoat | head -n 1)
xdotool windowfocus "$window"
# Help comes over the picture, and nothing of it stays; the hint goes by itself.
xdotool key h; sleep 1
shot "$work/help.png"
xdotool key F1; sleep 5
shot "$work/first.png"
if same "$work/first.png" "$work/help.png" 2>/dev/null; then echo 'there is no help' >&2; exit 1; fi
"$overcoat" render "$model" --size 320x200 --quality fast --background '#383a3e' -o "$work/expected.png" -q
same "$work/expected.png" "$work/first.png"

# Turned, it is another picture; R brings the first back.
xdotool mousemove --window "$window" 160 100 mousedown 1 mousemove --window "$window" 220 110 mousemove --window "$window" 240 110 mouseup 1
sleep 1; said 'fast, 8 samples'
shot "$work/turned.png"
if same "$work/expected.png" "$work/turned.png" 2>/dev/null; then echo 'a drag changes nothing' >&2; exit 1; fi
xdotool key r
sleep 1; said 'fast, 8 samples'
shot "$work/back.png"
same "$work/expected.png" "$work/back.png"

# Keys: the next model twice and back, tiers, samples, floor, environment.
xdotool key m; sleep 0.5; said 'urp-desktop - fast'
xdotool key shift+m; sleep 0.5; said "its materials' models - fast"
xdotool key q; sleep 1; said 'good, 8 samples'
xdotool key q key q key q; sleep 1; said 'fast, 8 samples'
xdotool key s; sleep 1; said 'fast, 16 samples'
xdotool key s key s key s; sleep 1; said 'fast, 8 samples'
xdotool key g; sleep 1; said 'fast, 8 samples'
shot "$work/bare.png"
if same "$work/expected.png" "$work/bare.png" 2>/dev/null; then echo 'the floor stays' >&2; exit 1; fi
xdotool key g key e key e; sleep 1; said 'fast, 8 samples'
xdotool key e; sleep 1; said 'fast, 8 samples'
shot "$work/floor.png"
same "$work/expected.png" "$work/floor.png"

# A click says what is there.
xdotool mousemove --window "$window" 160 100 click 1
sleep 1
grep -q '^160, 100: object 0, material ' "$work/said"
xdotool mousemove --window "$window" 2 2 click 1
sleep 1
grep -q '^2, 2: nothing' "$work/said"

# Another size.
xdotool windowsize "$window" 240 160
sleep 1; said 'fast, 8 samples'
shot "$work/small.png"
test "$(python3 -c 'import struct,sys; print(*struct.unpack(">II", open(sys.argv[1],"rb").read()[16:24]))' "$work/small.png")" = '240 160'

xdotool key Escape
wait $process
test ! -s "$work/errors"

# What cannot be shown is one line and an exit code.
if "$viewer" /nowhere.glb 2>"$work/errors"; then exit 1; fi
grep -q '^overcoat-viewer: /nowhere.glb: ' "$work/errors" && test "$(wc -l <"$work/errors")" = 1
"$viewer" "$model" --size 640x360 --quality draft --frames 100
echo 'viewer: all is well'

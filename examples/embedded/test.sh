#!/usr/bin/env bash
# Builds the small program for this machine and compares it with the large one: the same pixels, one thread, little memory.
#
# OVERCOAT: the program to compare with, target/release/overcoat by default. EMBEDDED_PROFILE: release is quicker to build.
set -euo pipefail
cd "$(dirname "$0")/../.."
overcoat=${OVERCOAT-target/release/overcoat}
profile=${EMBEDDED_PROFILE-embedded}
cargo build --locked --profile "$profile" -p overcoat-embedded --target-dir target/embedded
small=target/embedded/$profile/overcoat-embedded
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
printf '%s bytes\n' "$(stat -c %s "$small")"

for model in sports-car.glb rounded-cube.stl torus-knot.glb vase.glb; do
    "$small" "assets/models/$model" "$work/small.png" 128
    "$overcoat" render "assets/models/$model" -o "$work/large.png" --size 128 --quality draft --quiet
    cmp "$work/small.png" "$work/large.png" || { printf '%s: other pixels\n' "$model" >&2; exit 1; }
done

# What it lacks it refuses by name, in one line, and leaves no file.
if "$small" assets/models/vase.ply "$work/none.png" 2>"$work/said"; then exit 1; fi
grep -q 'this program was built without it' "$work/said" && [ "$(wc -l <"$work/said")" = 1 ] && [ ! -e "$work/none.png" ]
"$small" nothing 2>"$work/said" && exit 1
grep -q '^usage: ' "$work/said"

# The parts of the renderer too.
cargo test --locked --profile "$profile" -p overcoat-embedded --test refusals --target-dir target/embedded

# Threads, and the peak of memory in kilobytes, while it draws a large picture.
"$small" assets/models/torus-knot.glb "$work/small.png" 2048 &
most=0 threads=0
while status=$(cat "/proc/$!/status" 2>/dev/null) && [[ $status == *VmHWM* ]]; do
    found=$(sed -n 's/^Threads:[^0-9]*//p' <<<"$status")
    [ "$found" -le "$threads" ] || threads=$found
    most=$(sed -n 's/^VmHWM:[^0-9]*\([0-9]*\).*/\1/p' <<<"$status")
done
wait
printf '%s thread, %s kB at 2048 x 2048\n' "$threads" "$most"
[ "$threads" = 1 ]

#!/usr/bin/env bash
# The machine matrix: builds the program for other processors and other compiler settings, lets each draw the scenes of
# tests/machines (emulated where need be), and compares every hash with tests/machines/hashes.tsv. Tolerance 0.
#
# Needs the project's Rust toolchain; what else a leg needs is taken from Debian and unpacked below target/machines:
# nothing is installed and no root is needed. A leg that cannot run says why.
#
# Usage: tests/machines/matrix.sh [LEG...]
# Legs:  x86-64 x86-64-v3 aarch64 wasm32 i686 x86-64-v4 debug s390x armv7 riscv64   (default: all)
# MATRIX_SECONDS, if set: no leg is begun later than that; those left out say so.
set -euo pipefail
cd "$(dirname "$0")/../.."
export CARGO_INCREMENTAL=0 CARGO_TERM_COLOR=never
legs=("$@")
[ ${#legs[@]} -gt 0 ] || legs=(x86-64 x86-64-v3 aarch64 wasm32 i686 x86-64-v4 debug s390x armv7 riscv64)
# shellcheck source=tests/machines/compilers.sh
. tests/machines/compilers.sh
: >"$log"

declare -a machines=() skipped=() times=()
machine() { machines+=("$1 = $2"); }
skip() {
    skipped+=("$(printf '%-14s skipped: %s' "$1" "$2")")
    printf '%-14s skipped: %s\n' "$1" "$2"
}

# build LEG ARGUMENTS...: the program, without debug information (it would triple the time to link), without a second
# optimisation over all of it (a third of the time), and where there are several instruction sets with one of them (half).
build() {
    local leg=$1 start=$SECONDS
    shift
    if ! RUSTFLAGS="${RUSTFLAGS-} --cfg overcoat_one_level" CARGO_PROFILE_DEV_DEBUG=0 CARGO_PROFILE_RELEASE_DEBUG=0 CARGO_PROFILE_RELEASE_LTO=off cargo rustc --locked -p overcoat-cli --bin overcoat "$@" >>"$log" 2>&1; then
        tail -n 40 "$log" >&2
        printf '%s does not build\n' "$leg" >&2
        exit 1
    fi
    times+=("$(printf '%5d s  build %s' $((SECONDS - start)) "$leg")")
}

# The x86-64 level that this processor has: 1 to 4.
x86_level() {
    [ "$(uname -m)" = x86_64 ] || { echo 0; return; }
    local flags level=1
    flags=$(grep -m1 '^flags' /proc/cpuinfo)
    has() { for f in "$@"; do case " $flags " in *" $f "*) ;; *) return 1 ;; esac; done; }
    if has avx2 fma bmi1 bmi2 f16c movbe; then level=3; fi
    if [ $level = 3 ] && has avx512f avx512bw avx512cd avx512dq avx512vl; then level=4; fi
    echo $level
}

# cross LEG TARGET ARGUMENTS...: builds with the second compiler.
cross() {
    local leg=$1 target=$2
    shift 2
    build "$leg" --release --target "$target" --target-dir "$work/cross" "$@"
    program=$work/cross/$target/release/overcoat
}

# foreign EMULATOR TARGET SYSTEM: the leg of a processor that neither rustup nor Debian has a standard library for here: it is
# built too, and runs in an emulator.
foreign() {
    if second_compiler && fetch emulators && fetch "$leg"; then
        wrapper "$leg-cc" "$root/usr/bin/$3-gcc-12 -B$root/usr/$3/lib --sysroot=$root"
        local linker=CARGO_TARGET_${2//-/_}_LINKER
        export "${linker^^}=$work/$leg-cc"
        RUSTC_BOOTSTRAP=1 cross "$leg" "$2" -Z build-std=std,panic_unwind
        # The emulator takes half a minute to filter an environment there.
        machine "$leg/6" "$root/usr/bin/qemu-$1-static -L $root/usr/$3 $program"
    else
        skip "$leg" "$why"
    fi
}

level=$(x86_level)
for leg in "${legs[@]}"; do
    why=
    # The legs that find most may begin last.
    late=${MATRIX_SECONDS-}
    case $leg in x86-64-v3 | aarch64) ;; *) [ -z "$late" ] || late=$((late - 1500)) ;; esac
    if [ "$leg" != x86-64 ] && [ -n "$late" ] && [ "$SECONDS" -gt "$late" ]; then
        skip "$leg" "its time is up: tests/machines/matrix.sh $leg"
        continue
    fi
    case $leg in
        x86-64)
            # Run-time dispatch, forced level by level. Cargo builds this program with the test that runs it.
            for simd in sse2 avx2 avx512; do
                case $simd-$level in
                    sse2-[1-4] | avx2-[34] | avx512-4)
                        machine "x86-64 $simd" "$PWD/target/release/overcoat -- --simd $simd" ;;
                    *) skip "x86-64 $simd" 'this processor does not have it' ;;
                esac
            done ;;
        x86-64-v[34])
            if [ "$level" -lt "${leg#x86-64-v}" ]; then
                skip "$leg" 'this processor does not have it'
            else
                # The compiler is free to use FMA everywhere, and must not.
                RUSTFLAGS="-C target-cpu=$leg" build "$leg" --release --target-dir "$work/$leg"
                machine "$leg" "$work/$leg/release/overcoat"
            fi ;;
        debug)
            # Without optimisation of whole loops, and with the lanes that are the definition.
            build "$leg" --features scalar-lanes --target-dir "$work/debug"
            machine "debug scalar" "$work/debug/debug/overcoat -- --simd scalar" ;;
        aarch64)
            if second_compiler && fetch emulators && fetch aarch64; then
                wrapper aarch64-cc "$root/usr/bin/aarch64-linux-gnu-gcc-12 -B$root/usr/aarch64-linux-gnu/lib --sysroot=$root"
                CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=$work/aarch64-cc cross "$leg" aarch64-unknown-linux-gnu
                machine "$leg neon" "$root/usr/bin/qemu-aarch64-static -L $root/usr/aarch64-linux-gnu $program"
            else
                skip "$leg" "$why"
            fi ;;
        s390x)
            # Big-endian.
            if second_compiler && fetch emulators && fetch s390x; then
                wrapper s390x-cc "$root/usr/bin/s390x-linux-gnu-gcc-12 -B$root/usr/s390x-linux-gnu/lib --sysroot=$root"
                # At its highest optimisation level LLVM 22 makes two scenes differ (a spot light's direction among the
                # numbers that change; no other machine does), at this one none.
                CARGO_PROFILE_RELEASE_OPT_LEVEL=1 \
                    RUSTC_BOOTSTRAP=1 CARGO_TARGET_S390X_UNKNOWN_LINUX_GNU_LINKER=$work/s390x-cc \
                    cross "$leg" s390x-unknown-linux-gnu -Z build-std=std,panic_unwind
                # Its emulator computes floats one by one in software.
                machine "$leg/24" "$root/usr/bin/qemu-s390x-static -L $root/usr/s390x-linux-gnu $program"
            else
                skip "$leg" "$why"
            fi ;;
        armv7)
            # 32-bit, with the floats of its scalar unit: NEON of that generation takes denormal numbers for zero, and the
            # target has none. Two registers of 64 bits where others have four.
            foreign arm armv7-unknown-linux-gnueabihf arm-linux-gnueabihf ;;
        riscv64)
            # NaN of arithmetic has no sign and no payload here, whatever went in.
            foreign riscv64 riscv64gc-unknown-linux-gnu riscv64-linux-gnu ;;
        i686)
            # 32-bit, with SSE2: the x87 is not reproducible, and the library refuses to compile for it.
            if second_compiler && fetch emulators && fetch i686; then
                gcc32=$root/usr/lib/gcc/x86_64-linux-gnu/12/32
                wrapper i686-cc "cc -m32 --sysroot=$root -B$root/usr/lib32 -B$gcc32 -L$root/usr/lib32 -L$root/lib32 -L$gcc32"
                RUSTC_BOOTSTRAP=1 CARGO_TARGET_I686_UNKNOWN_LINUX_GNU_LINKER=$work/i686-cc \
                    cross "$leg" i686-unknown-linux-gnu -Z build-std=std,panic_unwind
                loader="$root/lib32/ld-linux.so.2 --library-path $root/lib32:$root/usr/lib32"
                # Most x86-64 systems run such programs themselves.
                $loader --version >/dev/null 2>&1 || loader="$root/usr/bin/qemu-i386-static $loader"
                machine "$leg" "$loader $program"
            else
                skip "$leg" "$why"
            fi ;;
        wasm32)
            node=$(command -v node || true)
            if [ -z "$node" ]; then
                skip "$leg" 'there is no node to run it'
            elif second_compiler && fetch wasm32; then
                linker=$(env -u RUSTC rustc --print sysroot)/lib/rustlib/x86_64-unknown-linux-gnu/bin/rust-lld
                RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_WASIP1_LINKER=$linker \
                    RUSTFLAGS="-C target-feature=+simd128 -L $root/usr/lib/wasm32-wasi" \
                    cross "$leg" wasm32-wasip1 -Z build-std=std,panic_abort \
                    -- -C link-arg=--allow-undefined -C link-arg=--export=malloc
                # Node.js 20 crashes at its exit while its other threads compile.
                machine "$leg" "$node --no-warnings --single-threaded $PWD/tests/machines/wasi.mjs $program.wasm"
            else
                skip "$leg" "$why"
            fi ;;
        *)
            printf 'unknown leg %s\n' "$leg" >&2
            exit 2 ;;
    esac
    unset RUSTC
done

start=$SECONDS
OVERCOAT_MACHINES=$(printf '%s\n' "${machines[@]}") \
    cargo test --locked --release ${PACKAGES_TESTED--p overcoat-cli} --test machines -- --nocapture other_machines
times+=("$(printf '%5d s  draw and compare' $((SECONDS - start)))")
printf '%s\n' "${skipped[@]-}" "${times[@]}"

#!/usr/bin/env bash
# Installs header, shared and static library and pkg-config file: what `cargo cinstall` of cargo-c does, without it.
#
#     cargo build --release -p overcoat-capi
#     bindings/c/install.sh --prefix /usr/local
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
prefix=/usr/local
from=${CARGO_TARGET_DIR:-$here/../../target}/release
while [ $# -gt 0 ]; do
    case $1 in
        --prefix) prefix=$2 ;;
        --from) from=$2 ;;
        *) echo "usage: install.sh [--prefix DIR] [--from DIR]" >&2; exit 2 ;;
    esac
    shift 2
done
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$here/Cargo.toml" | head -n 1)
major=${version%.*}
lib=${DESTDIR-}$prefix/lib
include=${DESTDIR-}$prefix/include
install -d "$lib/pkgconfig" "$include"
install -m 644 "$here/include/overcoat.h" "$include/overcoat.h"
install -m 755 "$from/libovercoat.so" "$lib/libovercoat.so.$version"
ln -sf "libovercoat.so.$version" "$lib/libovercoat.so.$major"
ln -sf "libovercoat.so.$major" "$lib/libovercoat.so"
install -m 644 "$from/libovercoat.a" "$lib/libovercoat.a"
cat >"$lib/pkgconfig/overcoat.pc" <<PC
prefix=$prefix
libdir=\${prefix}/lib
includedir=\${prefix}/include

Name: overcoat
Description: CPU-only renderer for thumbnails, golden images and windows without a GPU
Version: $version
Libs: -L\${libdir} -lovercoat
Libs.private: -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc
Cflags: -I\${includedir}
PC
echo "installed overcoat $version to $prefix"

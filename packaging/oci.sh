#!/usr/bin/env bash
# A container image of the static program and nothing else: an archive of an OCI image layout, which docker load,
# podman load and skopeo read.
#
# Needs python3, and what packaging/static.sh needs.
# Usage: packaging/oci.sh [x86_64|aarch64]   (default: x86_64)
# Writes target/packages/overcoat-VERSION-oci-ARCH.tar.
# OVERCOAT_STATIC_BINARY, if set, is a program to take in place of building one.
. "$(dirname "$0")/common.sh"
need python3 python3
arch=${1:-x86_64}

binary=${OVERCOAT_STATIC_BINARY-}
if [ -z "$binary" ]; then
    packaging/static.sh "$arch"
    binary=$packages/overcoat-$version-linux-$arch
fi
out=$packages/overcoat-$version-oci-$arch.tar
python3 packaging/oci.py "$binary" "$version" "$arch" "$SOURCE_DATE_EPOCH" "$out"
printf '%s, %d bytes\n' "$out" "$(stat -c %s "$out")"

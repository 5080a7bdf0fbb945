#!/usr/bin/env bash
# A container image of a static program and nothing else: an archive of an OCI image layout, which docker load,
# podman load and skopeo read.
#
# Needs python3, and what packaging/static.sh needs.
# Usage: packaging/oci.sh [x86_64|aarch64] [overcoat|overcoat-service]   (default: x86_64 overcoat)
# Writes target/packages/PROGRAM-VERSION-oci-ARCH.tar.
# OVERCOAT_STATIC_BINARY or OVERCOAT_SERVICE_STATIC_BINARY, if set, is a program to take in place of building one.
. "$(dirname "$0")/common.sh"
need python3 python3
arch=x86_64 program=overcoat
for argument in "$@"; do
    case $argument in
        x86_64 | aarch64) arch=$argument ;;
        overcoat | overcoat-service) program=$argument ;;
        *) die "no architecture or program '$argument': x86_64, aarch64; overcoat, overcoat-service" ;;
    esac
done

variable=$(binary_variable "$program" STATIC_)
binary=${!variable-}
if [ -z "$binary" ]; then
    packaging/static.sh "$arch" "$program"
    binary=$packages/$program-$version-linux-$arch
fi
out=$packages/$program-$version-oci-$arch.tar
python3 packaging/oci.py "$binary" "$program" "$version" "$arch" "$SOURCE_DATE_EPOCH" "$out"
printf '%s, %d bytes\n' "$out" "$(stat -c %s "$out")"

#!/usr/bin/env bash
# A Debian package: the program, manual pages, completions, thumbnails for file managers, licences.
#
# Needs a Rust toolchain, python3 and dpkg-dev (apt-get install dpkg-dev). Runs where the C library is at least as new as here.
# Usage: packaging/deb.sh
# Writes target/packages/overcoat_VERSION_ARCH.deb.
# OVERCOAT_BINARY, if set, is a program to take in place of building one; OVERCOAT_MAINTAINER, NAME <ADDRESS>, who answers for it.
. "$(dirname "$0")/common.sh"
need dpkg-deb dpkg
need dpkg-shlibdeps dpkg-dev
need python3 python3

if [ -z "${OVERCOAT_BINARY-}" ]; then
    cargo build --locked --release --bin overcoat
    OVERCOAT_BINARY=$PWD/target/release/overcoat
fi
case $(dpkg --print-architecture) in
    amd64) target=x86_64-unknown-linux-gnu ;;
    arm64) target=aarch64-unknown-linux-gnu ;;
    *) die "no package for $(dpkg --print-architecture)" ;;
esac

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/root
share=$root/usr/share
doc=$share/doc/overcoat
mkdir -p "$root/DEBIAN" "$doc" "$share/man/man1"

# put MODE FILE DESTINATION: a file in the package.
put() { install -D -m "$1" "$2" "$3"; }
# made DESTINATION: standard input as a file in the package.
made() {
    mkdir -p "$(dirname "$1")"
    cat >"$1"
}

put 755 "$OVERCOAT_BINARY" "$root/usr/bin/overcoat"
put 644 packaging/overcoat.thumbnailer "$share/thumbnailers/overcoat.thumbnailer"
put 644 packaging/overcoat.xml "$share/mime/packages/overcoat.xml"
"$OVERCOAT_BINARY" man --dir "$share/man/man1"
gzip -9n "$share"/man/man1/*.1
"$OVERCOAT_BINARY" completions bash | made "$share/bash-completion/completions/overcoat"
"$OVERCOAT_BINARY" completions zsh | made "$share/zsh/vendor-completions/_overcoat"
"$OVERCOAT_BINARY" completions fish | made "$share/fish/vendor_completions.d/overcoat.fish"

put 644 packaging/copyright "$doc/copyright"
gzip -9n <CHANGELOG.md | made "$doc/changelog.gz"
python3 packaging/notices.py "$target" | gzip -9n | made "$doc/third-party-licenses.gz"
maintainer=${OVERCOAT_MAINTAINER:-The overcoat developers <overcoat-render@users.noreply.github.com>}
gzip -9n <<END | made "$doc/changelog.Debian.gz"
overcoat ($version-1) unstable; urgency=medium

  * The program as released; see changelog.gz.

 -- $maintainer  $(date -u -R -d "@$SOURCE_DATE_EPOCH")
END
put 644 packaging/lintian-overrides "$share/lintian/overrides/overcoat"

# Which libraries the program asks for.
mkdir -p "$work/debian"
printf 'Source: overcoat\n\nPackage: overcoat\nArchitecture: any\n' >"$work/debian/control"
depends=$(cd "$work" && dpkg-shlibdeps -O root/usr/bin/overcoat 2>/dev/null | sed -n 's/^shlibs:Depends=//p')

cat >"$root/DEBIAN/control" <<END
Package: overcoat
Version: $version-1
Architecture: $(dpkg --print-architecture)
Maintainer: $maintainer
Installed-Size: $(find "$root/usr" -type f -printf '%s\n' | awk '{ kib += int(($1 + 1023) / 1024) } END { print kib }')
${depends:+Depends: $depends
}Section: graphics
Priority: optional
Homepage: https://github.com/overcoat-render/overcoat
Description: CPU-only renderer of 3D models to pictures
 overcoat renders glTF, OBJ, STL, PLY and 3MF models to pictures on machines
 that have only a processor: no GPU, no display, no network. The picture is the
 same, bit for bit, on every machine.
 .
 File managers that follow the thumbnailer specification (GNOME Files, Thunar
 and others) show thumbnails of models once it is installed.
END
(cd "$root" && find usr -type f -print0 | sort -z | xargs -0 md5sum >DEBIAN/md5sums)

find "$root" -print0 | xargs -0 touch -h -d "@$SOURCE_DATE_EPOCH"
out=$packages/overcoat_$version-1_$(dpkg --print-architecture).deb
dpkg-deb --root-owner-group -Zxz --build "$root" "$out" >/dev/null
printf '%s, %d bytes\n' "$out" "$(stat -c %s "$out")"

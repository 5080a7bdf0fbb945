#!/usr/bin/env bash
# Debian packages: the program, manual pages, completions, thumbnails for file managers, licences; and the service, with its unit
# for systemd, which is neither enabled nor started.
#
# Needs a Rust toolchain, python3 and dpkg-dev (apt-get install dpkg-dev). Runs where the C library is at least as new as here.
# overcoat-service has cryptography in C and assembly, too: a C compiler (apt-get install gcc).
# Usage: packaging/deb.sh [overcoat|overcoat-service]...   (default: overcoat)
# Writes target/packages/PROGRAM_VERSION_ARCH.deb.
# OVERCOAT_BINARY and OVERCOAT_SERVICE_BINARY, if set, are programs to take in place of building them; OVERCOAT_MAINTAINER,
# NAME <ADDRESS>, who answers for the packages.
. "$(dirname "$0")/common.sh"
need dpkg-deb dpkg
need dpkg-shlibdeps dpkg-dev
need python3 python3
[ $# -gt 0 ] || set -- overcoat

case $(dpkg --print-architecture) in
    amd64) target=x86_64-unknown-linux-gnu ;;
    arm64) target=aarch64-unknown-linux-gnu ;;
    *) die "no package for $(dpkg --print-architecture)" ;;
esac
maintainer=${OVERCOAT_MAINTAINER:-The overcoat developers <overcoat-render@users.noreply.github.com>}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# put MODE FILE DESTINATION: a file in the package.
put() { install -D -m "$1" "$2" "$3"; }
# made DESTINATION: standard input as a file in the package.
made() {
    mkdir -p "$(dirname "$1")"
    cat >"$1"
}

# What the packages have beside what every one has.
overcoat_files() {
    put 644 packaging/overcoat.thumbnailer "$share/thumbnailers/overcoat.thumbnailer"
    put 644 packaging/overcoat.xml "$share/mime/packages/overcoat.xml"
}

overcoat_control() {
    cat <<END
${depends:+Depends: $depends
}Suggests: overcoat-service
Section: graphics
Priority: optional
Description: CPU-only renderer of 3D models to pictures
 overcoat renders glTF, OBJ, STL, PLY and 3MF models to pictures on machines
 that have only a processor: no GPU, no display, no network. The picture is the
 same, bit for bit, on every machine.
 .
 File managers that follow the thumbnailer specification (GNOME Files, Thunar
 and others) show thumbnails of models once it is installed.
END
}

overcoat_service_files() {
    put 644 service/overcoat.service "$root/lib/systemd/system/overcoat.service"
    gzip -9n <docs/src/service.md | made "$doc/README.md.gz"
    put 644 service/example.toml "$doc/examples/example.toml"
    put 644 service/presets.toml "$doc/examples/presets.toml"
    put 644 service/nginx.conf "$doc/examples/nginx.conf"
    put 644 service/Caddyfile "$doc/examples/Caddyfile"
    put 644 service/overcoat-socket.conf "$doc/examples/overcoat-socket.conf"
    for name in postinst prerm postrm; do
        put 755 "packaging/overcoat-service.$name" "$root/DEBIAN/$name"
    done
}

overcoat_service_control() {
    cat <<END
Depends: overcoat (= $version-1)${depends:+, $depends}
Recommends: ca-certificates
Suggests: nginx
Section: graphics
Priority: optional
Description: pictures of many 3D models, in batches and over HTTP
 overcoat-service draws models as overcoat does, many of them: "overcoat batch"
 for folders, manifests and object stores, "overcoat serve" over HTTP. Models
 are read by worker processes alone, which have no rights and bounded memory
 and time.
 .
 The service is not started before it is asked for: systemctl enable --now
 overcoat.service. It listens on 127.0.0.1:8080 then.
END
}

# package PROGRAM
package() {
    local program=$1 variable binary root share doc out
    local kind=${program//-/_}
    variable=$(binary_variable "$program")
    binary=${!variable-}
    if [ -z "$binary" ]; then
        cargo build --locked --release -p "$(package_of "$program")" --bin "$program"
        binary=$PWD/target/release/$program
    fi
    root=$work/$program share=$work/$program/usr/share
    doc=$share/doc/$program
    mkdir -p "$root/DEBIAN" "$doc" "$share/man/man1"

    put 755 "$binary" "$root/usr/bin/$program"
    "$binary" man --dir "$share/man/man1"
    gzip -9n "$share"/man/man1/*.1
    "$binary" completions bash | made "$share/bash-completion/completions/$program"
    "$binary" completions zsh | made "$share/zsh/vendor-completions/_$program"
    "$binary" completions fish | made "$share/fish/vendor_completions.d/$program.fish"
    "${kind}_files"

    put 644 packaging/copyright "$doc/copyright"
    gzip -9n <CHANGELOG.md | made "$doc/changelog.gz"
    python3 packaging/notices.py "$target" "$program" | gzip -9n | made "$doc/third-party-licenses.gz"
    gzip -9n <<END | made "$doc/changelog.Debian.gz"
$program ($version-1) unstable; urgency=medium

  * The program as released; see changelog.gz.

 -- $maintainer  $(date -u -R -d "@$SOURCE_DATE_EPOCH")
END
    sed "s/^overcoat:/$program:/" packaging/lintian-overrides | made "$share/lintian/overrides/$program"

    # Which libraries the program asks for.
    mkdir -p "$work/debian"
    printf 'Source: %s\n\nPackage: %s\nArchitecture: any\n' "$program" "$program" >"$work/debian/control"
    local depends
    depends=$(cd "$work" && dpkg-shlibdeps -O "$program/usr/bin/$program" 2>/dev/null | sed -n 's/^shlibs:Depends=//p')
    cat >"$root/DEBIAN/control" <<END
Package: $program
Version: $version-1
Architecture: $(dpkg --print-architecture)
Maintainer: $maintainer
Installed-Size: $(find "$root" -path "$root/DEBIAN" -prune -o -type f -printf '%s\n' |
        awk '{ kib += int(($1 + 1023) / 1024) } END { print kib }')
$("${kind}_control")
END
    (cd "$root" && find . -path ./DEBIAN -prune -o -type f -printf '%P\0' | sort -z | xargs -0 md5sum >DEBIAN/md5sums)

    find "$root" -print0 | xargs -0 touch -h -d "@$SOURCE_DATE_EPOCH"
    out=$packages/${program}_$version-1_$(dpkg --print-architecture).deb
    dpkg-deb --root-owner-group -Zxz --build "$root" "$out" >/dev/null
    printf '%s, %d bytes\n' "$out" "$(stat -c %s "$out")"
}

for program in "$@"; do
    case $program in
        overcoat | overcoat-service) package "$program" ;;
        *) die "no program '$program': overcoat, overcoat-service" ;;
    esac
done

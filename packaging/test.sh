#!/usr/bin/env bash
# Builds every package and tries it: twice the same bytes, nothing that Debian's checks object to, the same frames from every
# program, an image that runs in an empty root, thumbnails as desktops ask for them.
#
# Needs a Rust toolchain with rustup, and root on Debian for apt-get and packaging/desktop_test.sh (or what it names,
# installed already, and DESKTOP=no).
# Usage: packaging/test.sh
# OVERCOAT_BINARY, OVERCOAT_STATIC_BINARY, if set: programs to take in place of building them.
# PACKAGING_REBUILD=yes builds the static program a second time, in another folder, and compares.
. "$(dirname "$0")/common.sh"
start=$SECONDS arch=$(uname -m)

wanted=(binutils dpkg-dev file bubblewrap bash-completion fish libxml2-utils lintian man-db python3 shared-mime-info skopeo
    umoci zsh)
install_missing "${wanted[@]}"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# step NAME COMMAND...
step() {
    printf '\n== %s\n' "$1"
    shift
    "$@"
}

build() {
    if [ -z "${OVERCOAT_BINARY-}" ]; then
        cargo build --locked --release --bin overcoat
        export OVERCOAT_BINARY=$PWD/target/release/overcoat
    fi
    if [ -z "${OVERCOAT_STATIC_BINARY-}" ]; then
        packaging/static.sh "$arch"
        export OVERCOAT_STATIC_BINARY=$packages/overcoat-$version-linux-$arch
    fi
    for folder in first second; do
        # The time zone, the mask of permissions and the locale of whoever builds do not matter.
        (umask 077 && OVERCOAT_PACKAGES=$work/$folder packaging/deb.sh && OVERCOAT_PACKAGES=$work/$folder packaging/oci.sh "$arch")
    done
    deb=$(echo "$work"/first/*.deb)
    image=$(echo "$work"/first/*.tar)
}

twice_the_same() {
    diff -r "$work/first" "$work/second"
    if [ "${PACKAGING_REBUILD-}" = yes ]; then
        mkdir "$work/elsewhere"
        git archive HEAD | tar -x -C "$work/elsewhere"
        (cd "$work/elsewhere" && env -u OVERCOAT_STATIC_BINARY OVERCOAT_PACKAGES="$work/third" packaging/static.sh "$arch")
        cmp "$OVERCOAT_STATIC_BINARY" "$work"/third/overcoat-*
    fi
}

debian_objects_to_nothing() {
    lintian --fail-on error,warning --display-info --allow-root "$deb"
    dpkg-deb -x "$deb" "$work/unpacked"
    test "$(dpkg-deb -f "$deb" Package)" = overcoat
}

mime_types_are_valid() {
    xmllint --noout packaging/overcoat.xml
    mkdir -p "$work/mime/packages"
    cp packaging/overcoat.xml "$work/mime/packages/"
    local said
    said=$(XDG_DATA_HOME=$work update-mime-database "$work/mime" 2>&1)
    test -z "$said" || die "update-mime-database: $said"
}

completions_and_pages_are_read() {
    local share=$work/unpacked/usr/share page
    bash -n "$share/bash-completion/completions/overcoat"
    bash -c "source '$share/bash-completion/completions/overcoat'
        COMP_WORDS=(overcoat thumb) COMP_CWORD=1
        _overcoat overcoat thumb overcoat
        [[ \" \${COMPREPLY[*]} \" == *' thumbnail '* ]]" || die 'bash does not complete thumb'
    zsh -n "$share/zsh/vendor-completions/_overcoat"
    fish --no-execute "$share/fish/vendor_completions.d/overcoat.fish"
    test "$(fish -c "source $share/fish/vendor_completions.d/overcoat.fish; complete -C 'overcoat thumb'" | cut -f1)" = thumbnail ||
        die 'fish does not complete thumb'
    for page in "$share"/man/man1/*.gz; do
        local said
        said=$(man --warnings -E UTF-8 -l -Tutf8 -Z "$page" 2>&1 >/dev/null)
        test -z "$said" || die "$(basename "$page"): $said"
    done
}

programs_make_the_same_frames() {
    local model program expected made
    for model in assets/models/sports-car.glb assets/models/*.stl assets/models/*.ply; do
        [ -e "$model" ] || continue
        expected=
        for program in "$OVERCOAT_BINARY" "$work/unpacked/usr/bin/overcoat" "$OVERCOAT_STATIC_BINARY"; do
            made=$("$program" --sandbox render "$model" -o "$work/frame.png" --size 200 --quality good --json |
                sed -n 's/.*"frame_hash": "\(.*\)".*/\1/p')
            test -n "$made" || die "$program makes no frame of $model"
            expected=${expected:-$made}
            test "$made" = "$expected" || die "$program: $model: frame $made, not $expected"
        done
        echo "$model: $expected from the usual, the packaged and the static program"
    done
}

static_is_static() {
    file "$OVERCOAT_STATIC_BINARY" | grep -E 'static(ally|-pie) linked' || die 'the program is not static'
    test -z "$(readelf -d "$OVERCOAT_STATIC_BINARY" | grep NEEDED)" || die 'it needs libraries'
}

the_image_runs_in_an_empty_root() {
    mkdir -p "$work/layout" "$work/out"
    tar -xf "$image" -C "$work/layout"
    # Both forms in which it can be read, and its own check sums.
    skopeo --insecure-policy copy -q "oci-archive:$image" "dir:$work/copied"
    skopeo --insecure-policy copy -q "docker-archive:$image" "dir:$work/docker"
    umoci unpack --rootless --image "$work/layout:$version" "$work/bundle" >/dev/null
    test "$(cd "$work/bundle/rootfs" && find . -type f)" = ./usr/bin/overcoat || die 'the image holds something else'
    # No /proc, no /dev, no library.
    bwrap --unshare-all --bind "$work/bundle/rootfs" / --bind "$work/out" /mnt --chdir /mnt \
        /usr/bin/overcoat render - -o - --size 100 <assets/models/sports-car.glb >"$work/out/car.png"
    "$OVERCOAT_BINARY" render assets/models/sports-car.glb -o "$work/usual.png" --size 100
    cmp "$work/out/car.png" "$work/usual.png"
    cp assets/models/sports-car.glb "$work/out/"
    bwrap --unshare-all --bind "$work/bundle/rootfs" / --bind "$work/out" /mnt --chdir /mnt \
        /usr/bin/overcoat thumbnail --size 100 sports-car.glb thumbnail.png
    cmp "$work/out/thumbnail.png" "$work/usual.png"
}

sizes() {
    printf '%10d  %s\n' "$(stat -c %s "$OVERCOAT_BINARY")" 'program' \
        "$(stat -c %s "$OVERCOAT_STATIC_BINARY")" 'static program' \
        "$(stat -c %s "$deb")" 'Debian package' "$(stat -c %s "$image")" 'container image'
}

step 'packages, twice' build
step 'the same bytes' twice_the_same
step 'lintian' debian_objects_to_nothing
step 'MIME types' mime_types_are_valid
step 'completions and manual pages' completions_and_pages_are_read
step 'frames' programs_make_the_same_frames
step 'static' static_is_static
step 'image' the_image_runs_in_an_empty_root
[ "${DESKTOP-}" = no ] || step 'desktops' packaging/desktop_test.sh "$deb"
step 'sizes in bytes' sizes
printf '\npackages: all is well, %d s\n' $((SECONDS - start))

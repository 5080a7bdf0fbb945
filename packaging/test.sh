#!/usr/bin/env bash
# Builds every package and tries it: twice the same bytes, nothing that Debian's checks object to, the same frames from every
# program, images that run in an empty root, thumbnails as desktops ask for them.
#
# Needs a Rust toolchain with rustup, and root on Debian for apt-get and packaging/desktop_test.sh (or what it names,
# installed already, and DESKTOP=no).
# Usage: packaging/test.sh
# OVERCOAT_BINARY, OVERCOAT_STATIC_BINARY, OVERCOAT_SERVICE_BINARY, OVERCOAT_SERVICE_STATIC_BINARY, if set: programs to take in
# place of building them.
# PACKAGING_REBUILD=yes builds the static programs a second time, in another folder, and compares.
. "$(dirname "$0")/common.sh"
start=$SECONDS arch=$(uname -m)

wanted=(binutils dpkg-dev file bubblewrap bash-completion curl fish gcc libxml2-utils lintian man-db musl-tools python3
    shared-mime-info skopeo systemd umoci zsh)
programs=(overcoat overcoat-service)
install_missing "${wanted[@]}"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# step NAME COMMAND...
step() {
    printf '\n== %s\n' "$1"
    shift
    "$@"
}

# Programs by their names: the usual ones, the static ones, packages and images.
declare -A usual static deb image

build() {
    local program variable folder
    for program in "${programs[@]}"; do
        variable=$(binary_variable "$program")
        if [ -z "${!variable-}" ]; then
            cargo build --locked --release -p "$(package_of "$program")" --bin "$program"
            export "$variable=$PWD/target/release/$program"
        fi
        usual[$program]=${!variable}
        variable=$(binary_variable "$program" STATIC_)
        if [ -z "${!variable-}" ]; then
            packaging/static.sh "$arch" "$program"
            export "$variable=$packages/$program-$version-linux-$arch"
        fi
        static[$program]=${!variable}
    done
    for folder in first second; do
        # The time zone, the mask of permissions and the locale of whoever builds do not matter.
        (
            umask 077
            export OVERCOAT_PACKAGES=$work/$folder
            packaging/deb.sh "${programs[@]}"
            for program in "${programs[@]}"; do packaging/oci.sh "$arch" "$program"; done
        )
    done
    for program in "${programs[@]}"; do
        deb[$program]=$(echo "$work/first/${program}_"*.deb)
        image[$program]=$work/first/$program-$version-oci-$arch.tar
    done
}

twice_the_same() {
    diff -r "$work/first" "$work/second"
    if [ "${PACKAGING_REBUILD-}" = yes ]; then
        mkdir "$work/elsewhere"
        git archive HEAD | tar -x -C "$work/elsewhere"
        (cd "$work/elsewhere" && env -u OVERCOAT_STATIC_BINARY -u OVERCOAT_SERVICE_STATIC_BINARY OVERCOAT_PACKAGES="$work/third" \
            packaging/static.sh "$arch" "${programs[@]}")
        local program
        for program in "${programs[@]}"; do cmp "${static[$program]}" "$work/third/$program-$version-linux-$arch"; done
    fi
}

debian_objects_to_nothing() {
    local program
    for program in "${programs[@]}"; do
        lintian --fail-on error,warning --display-info --allow-root "${deb[$program]}"
        dpkg-deb -x "${deb[$program]}" "$work/unpacked"
        test "$(dpkg-deb -f "${deb[$program]}" Package)" = "$program"
    done
    dpkg-deb -f "${deb[overcoat-service]}" Depends | grep -qF "overcoat (= $version-1)" || die 'the service does without the program'
}

# The unit is one, calls what the package has, and is not enabled by it.
the_unit_is_valid() {
    local unit=$work/unpacked/lib/systemd/system/overcoat.service said
    sed "s|^ExecStart=/usr|&/../$work/unpacked/usr|" "$unit" >"$work/overcoat.service"
    said=$(systemd-analyze verify --man=no "$work/overcoat.service" 2>&1) || die "overcoat.service: $said"
    test -z "$said" || die "overcoat.service: $said"
    if find "$work/unpacked" -name '*.wants' | grep .; then die 'the package enables its unit'; fi
    for script in postinst prerm postrm; do sh -n "packaging/overcoat-service.$script"; done
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
    local share=$work/unpacked/usr/share program page
    for program in "${programs[@]}"; do
        bash -n "$share/bash-completion/completions/$program"
        zsh -n "$share/zsh/vendor-completions/_$program"
        fish --no-execute "$share/fish/vendor_completions.d/$program.fish"
        test -e "$share/man/man1/$program.1.gz" || die "$program has no manual page"
    done
    bash -c "source '$share/bash-completion/completions/overcoat'
        COMP_WORDS=(overcoat thumb) COMP_CWORD=1
        _overcoat overcoat thumb overcoat
        [[ \" \${COMPREPLY[*]} \" == *' thumbnail '* ]]" || die 'bash does not complete thumb'
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
    local program
    for program in "${programs[@]}"; do
        file "${static[$program]}" | grep -E 'static(ally|-pie) linked' || die "$program is not static"
        test -z "$(readelf -d "${static[$program]}" | grep NEEDED)" || die "$program needs libraries"
        # Folders of whoever built it are not in it.
        if grep -aqF -e "$PWD" -e "${CARGO_HOME:-$HOME/.cargo}" "${static[$program]}"; then die "$program names folders of this machine"; fi
    done
}

# unpacked_image PROGRAM: sets bundle, its root.
unpacked_image() {
    local layout=$work/$1-layout
    bundle=$work/$1-bundle
    mkdir -p "$layout" "$work/out"
    tar -xf "${image[$1]}" -C "$layout"
    # Both forms in which it can be read, and its own check sums.
    skopeo --insecure-policy copy -q "oci-archive:${image[$1]}" "dir:$work/$1-copied"
    skopeo --insecure-policy copy -q "docker-archive:${image[$1]}" "dir:$work/$1-docker"
    umoci unpack --rootless --image "$layout:$version" "$bundle" >/dev/null
    test "$(cd "$bundle/rootfs" && find . -type f)" = "./usr/bin/$1" || die 'the image holds something else'
    python3 - "$bundle/config.json" "/usr/bin/$1" <<'END'
import json, sys
process = json.load(open(sys.argv[1]))["process"]
assert process["args"][0] == sys.argv[2] and process["user"]["uid"] == 65532, process
END
}

the_image_runs_in_an_empty_root() {
    unpacked_image overcoat
    # No /proc, no /dev, no library.
    bwrap --unshare-all --bind "$bundle/rootfs" / --bind "$work/out" /mnt --chdir /mnt \
        /usr/bin/overcoat render - -o - --size 100 <assets/models/sports-car.glb >"$work/out/car.png"
    "$OVERCOAT_BINARY" render assets/models/sports-car.glb -o "$work/usual.png" --size 100
    cmp "$work/out/car.png" "$work/usual.png"
    cp assets/models/sports-car.glb "$work/out/"
    bwrap --unshare-all --bind "$bundle/rootfs" / --bind "$work/out" /mnt --chdir /mnt \
        /usr/bin/overcoat thumbnail --size 100 sports-car.glb thumbnail.png
    cmp "$work/out/thumbnail.png" "$work/usual.png"
}

# in_the_service_image BWRAP_OPTION... -- ARGUMENT...: with the /proc and /dev that every container has, and nothing else; as nobody.
in_the_service_image() {
    local -a options=()
    while [ "$1" != -- ]; do
        options+=("$1")
        shift
    done
    shift
    bwrap --unshare-user --unshare-ipc --unshare-pid --unshare-uts --uid 65532 --gid 65532 --die-with-parent --clearenv \
        --bind "$bundle/rootfs" / --proc /proc --dev /dev --bind "$work/pictures" /mnt --chdir /mnt "${options[@]}" \
        /usr/bin/overcoat-service "$@"
}

the_service_draws_in_an_empty_root() {
    unpacked_image overcoat-service
    mkdir -p "$work/pictures" "$bundle/rootfs/models"
    local -a options=(--size 100 --quality draft -q)
    in_the_service_image --unshare-net --ro-bind assets/models /models -- \
        batch /models -o /mnt/boxed "${options[@]}"
    "${usual[overcoat-service]}" batch assets/models -o "$work/pictures/usual" "${options[@]}"
    # The same pictures, and the same reports but for times and their order.
    diff -r -x report.jsonl "$work/pictures/boxed" "$work/pictures/usual"
    cmp <(sed 's/,"stages_ms".*//' "$work/pictures/boxed/report.jsonl" | sort) \
        <(sed 's/,"stages_ms".*//' "$work/pictures/usual/report.jsonl" | sort)
    test "$(find "$work/pictures/boxed" -name '*.png' | wc -l)" -ge 5 || die 'hardly any picture was made'
    # A store that needs root certificates says that there are none.
    local said
    said=$(in_the_service_image --setenv AWS_REGION x --setenv AWS_ACCESS_KEY_ID x --setenv AWS_SECRET_ACCESS_KEY x -- \
        batch s3://models/ -o /mnt/none --report /mnt/none.jsonl 2>&1 || true)
    test "$said" = 'overcoat: s3://models/: this system has no root certificates: SSL_CERT_FILE names a file of them' || die "$said"
}

the_service_serves_in_an_empty_root() {
    local address pid words
    # Its network is the host's, to be asked from there; workers have none, by their own sandbox.
    mkfifo "$work/listening"
    in_the_service_image -- serve --listen 127.0.0.1:0 --workers 1 --log error --cache /mnt/cache >"$work/listening" 2>"$work/served" &
    pid=$!
    read -r words <"$work/listening" || { cat "$work/served" >&2; die 'the service does not listen'; }
    address=${words#listening on }
    test "$(curl -sS -o "$work/health" -w '%{http_code}' "$address/health")" = 200 || die 'the service is not healthy'
    curl -sS --fail --data-binary @assets/models/sports-car.glb "$address/render?size=100" -o "$work/served.png"
    "${usual[overcoat]}" render assets/models/sports-car.glb -o "$work/usual.png" --size 100
    cmp "$work/served.png" "$work/usual.png"
    kill "$pid"
    wait "$pid" || true
    test ! -s "$work/served" || { cat "$work/served" >&2; die 'the service complains'; }
}

# The example of its configuration is one.
the_example_is_accepted() {
    local said=0
    timeout 3 "${usual[overcoat-service]}" serve --config "$work/unpacked/usr/share/doc/overcoat-service/examples/example.toml" \
        --listen 127.0.0.1:0 --workers 1 >"$work/example" 2>&1 || said=$?
    # It listened until it was told to stop.
    grep -q 'listening on' "$work/example" || die "exit code $said: $(cat "$work/example")"
}

sizes() {
    local program
    for program in "${programs[@]}"; do
        printf '%s\n' "$program"
        printf '%10d  %s\n' "$(stat -c %s "${usual[$program]}")" 'program' \
            "$(stat -c %s "${static[$program]}")" 'static program' \
            "$(stat -c %s "${deb[$program]}")" 'Debian package' "$(stat -c %s "${image[$program]}")" 'container image'
    done
}

# as_stated FILE ROW COLUMN: a file is at most as large as the table of docs/src/start.md says, and not much smaller.
as_stated() {
    local most bytes
    most=$(awk -F'|' -v row=" $2 " -v column="$3" '$2 == row { print $column * 1000000; exit }' docs/src/start.md)
    bytes=$(stat -c %s "$1")
    if [ "$bytes" -gt "${most:?no row '$2' in docs/src/start.md}" ] || [ $((bytes * 10)) -lt $((most * 7)) ]; then
        die "$1 has $bytes bytes, and docs/src/start.md says $most"
    fi
}

sizes_are_as_stated() {
    local program column=3
    for program in "${programs[@]}"; do
        as_stated "${usual[$program]}" program $column
        as_stated "${deb[$program]}" 'Debian package' $column
        column=$((column + 1))
    done
}

step 'packages, twice' build
step 'the same bytes' twice_the_same
step 'lintian' debian_objects_to_nothing
step 'unit' the_unit_is_valid
step 'MIME types' mime_types_are_valid
step 'completions and manual pages' completions_and_pages_are_read
step 'frames' programs_make_the_same_frames
step 'static' static_is_static
step 'image' the_image_runs_in_an_empty_root
step 'image of the service: batch' the_service_draws_in_an_empty_root
step 'image of the service: serve' the_service_serves_in_an_empty_root
step 'configuration' the_example_is_accepted
[ "${DESKTOP-}" = no ] || step 'desktops' packaging/desktop_test.sh "${deb[overcoat]}"
step 'sizes in bytes' sizes
step 'sizes as documented' sizes_are_as_stated
printf '\npackages: all is well, %d s\n' $((SECONDS - start))

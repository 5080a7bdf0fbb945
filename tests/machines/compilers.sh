# Compilers and libraries for other machines, taken from Debian and unpacked below target/machines: nothing is installed and no
# root is needed. Sourced by scripts that build for them, at the top of the tree or with $tree as that; says $why it cannot.

work=${tree-$PWD}/target/machines
root=$work/root
log=$work/log
mkdir -p "$work"

# Debian's packages, with lists of our own, so that neither root nor the machine's settings are touched.
declare -A packages=(
    [compiler]='rustc-web libstd-rust-web-dev rust-web-src libz3-4 libedit2'
    [aarch64]='libstd-rust-web-dev:arm64 gcc-12-aarch64-linux-gnu cpp-12-aarch64-linux-gnu binutils-aarch64-linux-gnu
        libgcc-12-dev-arm64-cross libgcc-s1-arm64-cross libc6-dev-arm64-cross libc6-arm64-cross
        linux-libc-dev-arm64-cross'
    [s390x]='gcc-12-s390x-linux-gnu cpp-12-s390x-linux-gnu binutils-s390x-linux-gnu libgcc-12-dev-s390x-cross
        libgcc-s1-s390x-cross libc6-dev-s390x-cross libc6-s390x-cross linux-libc-dev-s390x-cross'
    [armv7]='gcc-12-arm-linux-gnueabihf cpp-12-arm-linux-gnueabihf binutils-arm-linux-gnueabihf libgcc-12-dev-armhf-cross
        libgcc-s1-armhf-cross libc6-dev-armhf-cross libc6-armhf-cross linux-libc-dev-armhf-cross'
    [riscv64]='gcc-12-riscv64-linux-gnu cpp-12-riscv64-linux-gnu binutils-riscv64-linux-gnu libgcc-12-dev-riscv64-cross
        libgcc-s1-riscv64-cross libc6-dev-riscv64-cross libc6-riscv64-cross linux-libc-dev-riscv64-cross'
    [i686]='lib32gcc-12-dev lib32gcc-s1 libc6-dev-i386 libc6-i386'
    [wasm32]='wasi-libc'
    [emulators]='qemu-user-static'
)
apt() { APT_CONFIG=$work/apt.conf command "$@"; }
prepare_apt() {
    [ -e "$work/apt.conf" ] && return
    mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$work/debs" "$root"
    cat >"$work/apt.conf.new" <<EOF
Dir::State::lists "$work/lists";
Dir::Cache "$work/cache";
APT::Architecture "amd64";
APT::Architectures { "amd64"; "arm64"; };
APT::Sandbox::User "";
Acquire::Languages "none";
Acquire::Retries "3";
EOF
    APT_CONFIG=$work/apt.conf.new apt-get -qq update >>"$log" 2>&1 && mv "$work/apt.conf.new" "$work/apt.conf"
}

# fetch GROUP: downloads and unpacks a group of packages; fails with a reason in $why.
fetch() {
    local group=$1 names name deb
    [ -e "$work/have-$group" ] && return
    if [ "$(dpkg --print-architecture 2>/dev/null)" != amd64 ]; then
        why='needs packages of Debian on amd64'
        return 1
    fi
    prepare_apt || { why='the lists of Debian packages cannot be read'; return 1; }
    names=${packages[$group]}
    # The compiler's library and the LLVM that it uses carry their version in their names.
    if [ "$group" = compiler ]; then
        local library
        library=$(apt apt-cache depends libstd-rust-web-dev | sed -n 's/.*Depends: \(libstd-rust-web-[0-9.]*\)$/\1/p' | head -1)
        names+=" $library $(apt apt-cache depends "$library" | sed -n 's/.*Depends: \(libllvm[0-9]*\)$/\1/p' | head -1)"
    elif [ "$group" = aarch64 ]; then
        names+=" $(apt apt-cache depends libstd-rust-web-dev:arm64 | sed -n 's/.*Depends: \(libstd-rust-web-[0-9.]*:arm64\)$/\1/p' | head -1)"
    fi
    mkdir -p "$work/debs/$group"
    # shellcheck disable=SC2086
    if ! (cd "$work/debs/$group" && apt apt-get -qq download $names >>"$log" 2>&1); then
        why="Debian has not all of: $(echo $names)"
        return 1
    fi
    for deb in "$work/debs/$group"/*.deb; do
        name=$(basename "$deb")
        case $name in
            # One emulator each is enough of 380 MB.
            qemu-user-static*) dpkg --fsys-tarfile "$deb" | tar -x -C "$root" --wildcards './usr/bin/qemu-*' \
                --exclude='*mips*' --exclude='*ppc*' --exclude='*sparc*' --exclude='*riscv32*' --exclude='*sh4*' ;;
            *) dpkg -x "$deb" "$root" ;;
        esac
    done
    # Debian's links are absolute.
    find "$root" -lname '/*' | while read -r link; do
        case $(readlink "$link") in "$root"*) ;; *) ln -sfn "$root$(readlink "$link")" "$link" ;; esac
    done
    touch "$work/have-$group"
}

# wrapper NAME COMMAND: a program that runs a command with the unpacked libraries.
wrapper() {
    printf '#!/bin/sh\nexport LD_LIBRARY_PATH=%s/usr/lib/x86_64-linux-gnu\nexec %s "$@"\n' "$root" "$2" >"$work/$1"
    chmod +x "$work/$1"
}

# The second compiler: rustup has no libraries for these targets on a machine without its servers, Debian has.
second_compiler() {
    fetch compiler || return 1
    wrapper rustc "$root/usr/bin/rustc"
    export RUSTC=$work/rustc
}

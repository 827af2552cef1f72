#!/bin/sh
# Renders the scenes of tests/scenes on an emulated aarch64 and compares every byte with this machine's.
#
#   tests/aarch64.sh FOLDER
#
# FOLDER gets Debian's compiler, its aarch64 standard library, a cross linker and QEMU (about 400 MB), unpacked and not installed.
# Needs apt-get, dpkg and a network the first time, and cargo.
set -eu
folder=$(mkdir -p "$1" && cd "$1" && pwd)
here=$(cd "$(dirname "$0")/.." && pwd)
root=$folder/root

if [ ! -d "$root" ]; then
    mkdir -p "$folder/state/lists/partial" "$folder/cache/archives/partial"
    touch "$folder/state/status"
    cat > "$folder/apt.conf" <<EOF
Dir::State "$folder/state";
Dir::State::status "$folder/state/status";
Dir::Cache "$folder/cache";
APT::Architecture "amd64";
APT::Architectures { "amd64"; "arm64"; };
Debug::NoLocking "1";
EOF
    export APT_CONFIG="$folder/apt.conf"
    apt-get update
    apt-get -y --no-install-recommends --download-only install rustc-web:amd64 libstd-rust-web-dev:amd64 \
        libstd-rust-web-dev:arm64 gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static
    mkdir "$root"
    for package in "$folder"/cache/archives/*.deb; do
        dpkg -x "$package" "$root"
    done
fi

printf '#!/bin/sh\nexec "%s/usr/bin/aarch64-linux-gnu-gcc-12" --sysroot="%s" "$@"\n' "$root" "$root" > "$folder/linker"
chmod +x "$folder/linker"
cd "$here"
# The compiler and the linker find their own libraries; the tests below must not.
LD_LIBRARY_PATH="$root/usr/lib/x86_64-linux-gnu" PATH="$root/usr/bin:$PATH" RUSTC="$root/usr/bin/rustc" \
    CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER="$folder/linker" CARGO_PROFILE_RELEASE_DEBUG=0 \
    CARGO_PROFILE_RELEASE_OPT_LEVEL=1 \
    "$(rustup which cargo 2>/dev/null || command -v cargo)" build --release --bin etalon --target aarch64-unknown-linux-gnu \
    --target-dir "$folder/target"
ETALON_OTHER="$root/usr/bin/qemu-aarch64-static -L $root/usr/aarch64-linux-gnu $folder/target/aarch64-unknown-linux-gnu/release/etalon" \
    cargo test --release --test builds -- --ignored another_machine

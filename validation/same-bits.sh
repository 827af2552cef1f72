#!/usr/bin/env bash
# The same file from builds that share nothing but the source: optimisation levels 0, 1 and 3, with AVX and without.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
build() { # name, level, processor
    RUSTFLAGS="-C target-cpu=$3" CARGO_PROFILE_RELEASE_OPT_LEVEL=$2 \
        cargo build --quiet --release --target-dir "target/same-bits/$1"
}
build plain 1 x86-64
build unoptimised 0 x86-64-v3
build usual 3 x86-64-v3
for scene in cornell conductor roughdielectric textures shapes-mesh envmap; do
    for name in plain unoptimised usual; do
        "target/same-bits/$name/release/etalon" render "validation/references/scenes/$scene.xml" \
            -o "$out/$name.exr" --spp 4 --quiet
    done
    cmp "$out/usual.exr" "$out/plain.exr"
    cmp "$out/usual.exr" "$out/unoptimised.exr"
    echo "$scene: equal"
done

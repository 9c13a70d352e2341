#!/usr/bin/env bash
# The core is built for the browser, and closes a finger and a gripper in Node as the program does on this machine, to the last digit.
# That it builds says that there is no C in it; that it runs with nothing at hand, that a closing asks for no file, thread or clock.
# Takes the target of the toolchain where it is installed (rustup target add wasm32-unknown-unknown), and otherwise Debian's
# compiler, which builds std from its source. Needs Node 18 too.
# $PHALANX names another binary to compare with.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

target=wasm32-unknown-unknown
debians_compiler() {
    /usr/bin/cargo --version && command -v wasm-ld-19 && [ -e "$(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library/std" ]
}
node_works() { node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)'; }

need "the checks of the core in the browser" "Node 18 or later" "nodejs" node_works
if [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
    build=(cargo build)
else
    need "the checks of the core in the browser" "a compiler for $target ('rustup target add $target' is enough)" \
        "rustc-web cargo-web rust-web-src lld-19" debians_compiler
    # RUSTC_BOOTSTRAP: building std is not stable yet.
    # shellcheck disable=SC2054  # a comma of rust's own flag
    build=(env RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER="$(command -v wasm-ld-19)"
        /usr/bin/cargo build -Zbuild-std=std,panic_abort)
fi

# A directory of its own: another compiler must not make the host's artefacts stale.
built=$(realpath -m "${CARGO_TARGET_DIR:-target}")
"${build[@]}" --locked --quiet --manifest-path tests/wasm/Cargo.toml --target $target --target-dir "$built/wasm"
export MODULE=$built/wasm/$target/debug/phalanx_wasm.wasm

if [ -z "${PHALANX:-}" ]; then
    # The profile and the features of the tests: nothing is built twice.
    cargo build --locked --all-features --profile test --quiet --bin phalanx
    PHALANX=$built/debug/phalanx
fi
export PHALANX
node --test tests/wasm/closing.test.mjs

# shellcheck shell=bash
# To be sourced after need.sh: a compiler for the browser.

# Sets $target, and the command $build that takes cargo's arguments behind `build`.
# Usage: browser_target "who needs it"
browser_target() {
    target=wasm32-unknown-unknown
    if ! is_there && command -v rustup >/dev/null; then
        rustup target add "$target" >/dev/null 2>&1 || true
    fi
    if is_there; then
        build=(cargo build)
        return
    fi
    need "$1" "a compiler for $target ('rustup target add $target' is enough)" "rustc-web cargo-web rust-web-src lld-19" debians_compiler
    # RUSTC_BOOTSTRAP: building std is not stable yet.
    # shellcheck disable=SC2034,SC2054  # for who sources this; a comma of rust's own flag
    build=(env RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER="$(command -v wasm-ld-19)"
        /usr/bin/cargo build -Zbuild-std=std,panic_abort)
}

is_there() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; }
debians_compiler() {
    /usr/bin/cargo --version && command -v wasm-ld-19 && [ -e "$(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library/std" ]
}

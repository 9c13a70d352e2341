# shellcheck shell=bash
# To be sourced after need.sh: selects a compiler for WebAssembly in the browser.

# Sets $target, and $build to the command that takes the arguments of `cargo build`.
# Usage: browser_target "dependent"
browser_target() {
    target=wasm32-unknown-unknown
    if ! has_target && command -v rustup >/dev/null; then
        rustup target add "$target" >/dev/null 2>&1 || true
    fi
    if has_target; then
        build=(cargo build)
        return
    fi
    need "$1" "a compiler for $target ('rustup target add $target' is enough)" "rustc-web cargo-web rust-web-src lld-19" has_debian_compiler
    # RUSTC_BOOTSTRAP: -Zbuild-std is an unstable option.
    # shellcheck disable=SC2034,SC2054  # used by the sourcing script; the comma belongs to rustc's flag
    build=(env RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER="$(command -v wasm-ld-19)"
        /usr/bin/cargo build -Zbuild-std=std,panic_abort)
}

has_target() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; }
has_debian_compiler() {
    /usr/bin/cargo --version && command -v wasm-ld-19 && [ -e "$(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library/std" ]
}

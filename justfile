# Everything the project is checked by. `just check` is what CI runs.

# All checks.
check: format lint test documentation library-alone

# Formatting.
format:
    cargo fmt --all -- --check

# Lints, warnings as errors.
lint:
    cargo clippy --workspace --all-targets -- -D warnings

# Tests, structural ones (layers, file sizes) among them.
test:
    cargo test

# Documentation, warnings as errors.
documentation:
    RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --document-private-items

# The library without the command line.
library-alone:
    cargo check --lib --no-default-features

# New snapshots, to be looked at before they are committed.
snapshots:
    INSTA_UPDATE=always TRYCMD=overwrite cargo test

# Speed against the model by hand, see docs/performance.md.
bench:
    cargo bench

# Instructions of the main tasks against benches/instructions/accepted.txt; `just instructions --accept` takes new ones.
instructions *arguments:
    cargo run --release -p instructions -- {{arguments}}

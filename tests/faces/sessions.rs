//! The program as a person meets it: bad input of every kind is told at its place with exit status
//! 2, answers keep their form. Regenerate with `TRYCMD=overwrite cargo test --test faces sessions`,
//! and look.

#[test]
fn sessions() {
    trycmd::TestCases::new().case("tests/cli/*.trycmd").case("docs/files-as-they-are.md");
}

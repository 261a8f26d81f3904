//! A campaign that is begun in a folder of its own names logs beside it and above it by relative paths, and
//! is read without a warning of columns that the model does not take.

use std::process::Command;

use crate::folder::Folder;

#[test]
fn logs_beside_and_above_a_campaign_have_relative_paths() {
    let rows = |every: f64, head: &str| {
        let row = |n: usize| {
            let t = every * n as f64;
            format!("{t:.3},{n},{:.5}\n", (0.7 * t).sin())
        };
        format!("{head}\n{}", (0..(20.0 / every) as usize).map(row).collect::<String>())
    };
    let (slow, fast) = (rows(0.1, "t [s],Frame,x [m]"), rows(0.02, "t [s],Shot,x [m]"));
    let folder = Folder::new("beside", &[("slow.csv", &slow), ("logs/fast.csv", &fast)]);
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
        let output = command.args(arguments).current_dir(&*folder).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
        String::from_utf8(said).unwrap()
    };
    let said = run(&["new", "cals/first", "--from", "slow.csv", "logs/fast.csv"]);
    assert!(said.contains("not used of `../../slow.csv`: `Frame`;"), "{said}");
    let text = std::fs::read_to_string(folder.join("cals/first/campaign.toml")).unwrap();
    for words in
        ["file = \"../../slow.csv\"", "file = \"../../logs/fast.csv\"", "unused = [\"Shot\"]"]
    {
        assert!(text.contains(words), "{words}\n{text}");
    }
    let said = run(&["check", "cals/first"]);
    assert!(!said.contains("not used") && said.contains(" readings, "), "{said}");
    // A column that nothing declares is still warned of, and not shown: the file lies outside.
    std::fs::write(
        folder.join("cals/first/campaign.toml"),
        text.replace("unused = [\"Shot\"],", ""),
    )
    .unwrap();
    let said = run(&["check", "cals/first"]);
    assert!(said.contains("a column is not used") && !said.contains("Shot"), "{said}");
    assert!(run(&["check", "cals/first", "--show-outside"]).contains("`Shot` is not used"));
}

//! Lists the files of `models/`, `models/effects/` and `models/conventions/` so that the library carries them: adding an
//! instrument or an effect is adding a file.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let mut text = String::new();
    for (name, folder) in
        [("MODELS", "models"), ("EFFECTS", "models/effects"), ("CONVENTIONS", "models/conventions")]
    {
        list(&mut text, name, &root, folder)?;
        writeln!(io::stdout(), "cargo::rerun-if-changed={folder}")?;
    }
    fs::write(PathBuf::from(env::var("OUT_DIR")?).join("embedded.rs"), text)?;
    Ok(())
}

/// Writes a constant of all TOML files of a folder: stem and text, sorted.
fn list(text: &mut String, name: &str, root: &Path, folder: &str) -> Result<(), Box<dyn Error>> {
    let mut files: Vec<PathBuf> = fs::read_dir(root.join(folder))?
        .map(|entry| Ok(entry?.path()))
        .collect::<io::Result<_>>()?;
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    writeln!(text, "/// Stem and text of every file of its folder, sorted.")?;
    writeln!(text, "pub const {name}: &[(&str, &str)] = &[")?;
    for file in files {
        let stem =
            file.file_stem().and_then(|stem| stem.to_str()).ok_or("a file name is not UTF-8")?;
        // Named from the manifest's folder, so that a moved checkout finds its files.
        let place = format!("/{folder}/{stem}.toml");
        writeln!(
            text,
            "    ({stem:?}, include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), {place:?}))),"
        )?;
    }
    writeln!(text, "];")?;
    Ok(())
}

//! Campaigns of a scale, which reads one length (or whatever a test makes of it): small enough that
//! every answer is known in closed form.

use std::fs;
use std::path::{Path, PathBuf};

/// A model with one reading `x` of one parameter `a` of the instrument.
pub(crate) const SCALE: &str = r#"name  = "scale"
title = "A scale"

[parameters]
a = { unit = "m", scope = "instrument" }

[measurands]
x = { value = 'a', unit = "m" }
"#;

/// Campaigns in a folder that is gone when the test is.
pub(crate) struct Scales(tempfile::TempDir);

impl Scales {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// A campaign of the scale `S` with these lines in `[parameters]` and these readings of `x` (m)
    /// with a standard uncertainty of 1 m.
    pub(crate) fn campaign(&self, name: &str, parameters: &str, readings: &[f64]) -> PathBuf {
        let head = "instrument = \"S\"\n";
        self.written(name, SCALE, head, parameters, "x = { sigma = \"1 m\" }", "m", readings)
    }

    /// The same with a model, lines at the top, `[measurands]` and the readings' unit of its own.
    #[expect(clippy::too_many_arguments, reason = "what a campaign has")]
    pub(crate) fn written(
        &self,
        name: &str,
        model: &str,
        head: &str,
        parameters: &str,
        measurands: &str,
        unit: &str,
        readings: &[f64],
    ) -> PathBuf {
        let folder = self.path().join(name);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("model.toml"), model).unwrap();
        let text = format!(
            "model = \"model.toml\"\n{head}\n[parameters]\n\"x.delay\" = {{ value = \"0 s\", fixed = true }}\n{parameters}\n[measurands]\n{measurands}\n[[runs]]\nname = \"one\"\ndata = \"one.csv\"\n"
        );
        fs::write(folder.join("campaign.toml"), text).unwrap();
        let rows = readings.iter().enumerate().map(|(row, value)| format!("{row},{value:e}\n"));
        let rows: String = rows.collect();
        fs::write(folder.join("one.csv"), format!("time [s],x [{unit}]\n{rows}")).unwrap();
        folder
    }
}

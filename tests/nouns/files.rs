//! The files of a campaign: what may be read, what messages show of it, and what is kept.

use std::fs;
use std::path::{Path, PathBuf};

use homepoint::campaign::load::Campaign;
use homepoint::campaign::write::{check_targets, write_campaign};
use homepoint::engine::open::{Opened, Request, open};
use tempfile::TempDir;

const MODEL: &str = "name = \"line\"\ntitle = \"line\"\n[inputs]\nq = { unit = \"m\", signal = true }\n\
    [parameters]\nc = { unit = \"m\", scope = \"rig\" }\n[measurands]\nx = { value = 'q + c', unit = \"m\" }\n";
const EFFECT: &str = "name = \"stretch\"\ntitle = \"stretch\"\nacts = \"instrument\"\n\
    [parameters]\nby = { unit = \"1\", typical = \"1e-3\" }\n[patch]\nx = 'x * (1 + by)'\n";
/// Every kind of file that a campaign names.
const CAMPAIGN: &str = r#"model = "line.toml"
[inputs]
q = { calibration = { sigma = "1 um", corrections = "certificate.csv" } }
[measurands]
x = { sigma = "1 mm" }
[timing]
method = "trigger"
[[runs]]
name = "captured"
data = "captured.csv"
timing = { captures = "latch.csv" }
[[runs]]
name = "logged"
data = "logged.csv"
signals = ["stream.csv"]
"#;

/// The files beside it; all but the first two are read.
fn files() -> Vec<(&'static str, String)> {
    let rows = |head: &str, row: &dyn Fn(f64) -> String| {
        let rows: Vec<String> = (0..200).map(|n| row(0.05 * f64::from(n))).collect();
        format!("{head}\n{}\n", rows.join("\n"))
    };
    vec![
        ("notes.txt", "not of the campaign".to_owned()),
        ("effects/notes.txt", "not an effect".to_owned()),
        ("campaign.toml", CAMPAIGN.to_owned()),
        ("line.toml", MODEL.to_owned()),
        ("effects/stretch.toml", EFFECT.to_owned()),
        ("certificate.csv", "q [m],correction [um]\n0,1\n20,2\n".to_owned()),
        ("captured.csv", rows("q [m],q_rate [m/s],x [m]", &|t| format!("{t},1,{}", t + 2.0))),
        ("latch.csv", rows("trigger [s]", &|t| format!("{:.2}", t + 100.0))),
        ("logged.csv", rows("time [s],x [m]", &|t| format!("{t:.2},{}", t + 2.0))),
        ("stream.csv", rows("time [s],q [m]", &|t| format!("{t:.2},{t}"))),
    ]
}

/// A folder with a campaign of all kinds of files in it, and a place beside it.
fn folder() -> (TempDir, PathBuf) {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("campaign");
    fs::create_dir_all(folder.join("effects")).unwrap();
    for (name, text) in files() {
        fs::write(folder.join(name), text).unwrap();
    }
    (root, folder)
}

fn opened(folder: &Path, confined: bool) -> Result<Opened, String> {
    let request = Request { confined, ..Request::new([folder]) };
    open(&request).map_err(|faults| {
        // As the terminal shows them: messages, excerpts, help.
        let whole = |fault: &homepoint::diagnostic::Diagnostic| {
            let excerpt = fault.place.as_ref().map_or("", |place| place.excerpt());
            format!("{fault}\n{excerpt}")
        };
        faults.0.iter().map(whole).collect::<Vec<_>>().join("\n")
    })
}

fn campaign(folder: &Path) -> (Opened, Campaign) {
    let opened = opened(folder, true).unwrap();
    let campaign = opened.campaigns[0].clone();
    (opened, campaign)
}

#[test]
fn a_campaign_knows_every_file_that_it_read() {
    let (_root, folder) = folder();
    let (_, campaign) = campaign(&folder);
    for (number, (name, _)) in files().iter().enumerate() {
        let is_read = number > 1;
        assert_eq!(campaign.files.replaced_by(&folder.join(name)).is_some(), is_read, "{name}");
        let around = folder.join("effects/..").join(name);
        assert_eq!(campaign.files.replaced_by(&around).is_some(), is_read, "{name}");
    }
    assert!(campaign.files.replaced_by(&folder.join("none.csv")).is_none());
}

#[cfg(unix)]
#[test]
fn a_file_is_the_same_through_links() {
    let (root, folder) = folder();
    let elsewhere = root.path().join("elsewhere");
    std::os::unix::fs::symlink(&folder, &elsewhere).unwrap();
    let (other, again) = (root.path().join("other.csv"), root.path().join("again.csv"));
    std::os::unix::fs::symlink(folder.join("logged.csv"), &other).unwrap();
    fs::hard_link(folder.join("stream.csv"), &again).unwrap();
    let (_, campaign) = campaign(&folder);
    for path in [elsewhere.join("captured.csv"), other, again] {
        assert!(campaign.files.refuse_replacing(&path).is_err(), "{}", path.display());
    }
}

#[test]
fn a_written_campaign_replaces_nothing_that_was_read() {
    // Where each file would be written over if the campaign were written to where it is.
    for (from, to) in [
        ("logged.csv", "out/logged.csv"),
        ("captured.csv", "out/campaign.toml"),
        ("latch.csv", "out/captured.csv"),
        ("stream.csv", "out/stream.csv"),
        ("certificate.csv", "out/logged.csv"),
        ("line.toml", "out/line.toml"),
    ] {
        let (_root, folder) = folder();
        fs::create_dir(folder.join("out")).unwrap();
        fs::rename(folder.join(from), folder.join(to)).unwrap();
        fs::write(folder.join("campaign.toml"), CAMPAIGN.replace(from, to)).unwrap();
        let before = fs::read(folder.join(to)).unwrap();
        let (opened, campaign) = campaign(&folder);
        let (out, runs) = (folder.join("out"), &opened.problem.parts[0].runs);
        let refused = check_targets(&out, &campaign, runs).unwrap_err().to_string();
        assert!(
            refused.contains("would be written over") && refused.contains("--out"),
            "{refused}"
        );
        let error = write_campaign(&out, &campaign, &opened.models[0], runs).unwrap_err();
        assert!(error.to_string().contains("would be written over"), "{error}");
        assert_eq!(fs::read(folder.join(to)).unwrap(), before, "{to}");
        assert_eq!(fs::read_dir(&out).unwrap().count(), 1, "nothing is written");
    }
}

#[test]
fn of_the_files_beside_effects_are_written_again() {
    let (root, folder) = folder();
    let (opened, campaign) = campaign(&folder);
    let out = root.path().join("out");
    write_campaign(&out, &campaign, &opened.models[0], &opened.problem.parts[0].runs).unwrap();
    let effects: Vec<_> = fs::read_dir(out.join("effects")).unwrap().collect();
    assert_eq!(effects.len(), 1, "{effects:?}");
    assert_eq!(fs::read_to_string(out.join("effects/stretch.toml")).unwrap(), EFFECT);
    assert_eq!(fs::read_to_string(out.join("line.toml")).unwrap(), MODEL);
    assert!(out.join("stream.csv").is_file() && !out.join("notes.txt").exists());
    assert!(opened.campaigns[0].files.replaced_by(&out.join("stream.csv")).is_none());
}

#[cfg(unix)]
#[test]
fn no_link_that_leads_out_is_copied() {
    for name in ["stream.csv", "line.toml", "effects/stretch.toml"] {
        let (root, folder) = folder();
        let outside = root.path().join("outside");
        fs::rename(folder.join(name), &outside).unwrap();
        std::os::unix::fs::symlink(&outside, folder.join(name)).unwrap();
        let opened = opened(&folder, false).unwrap();
        let out = root.path().join("out");
        let runs = &opened.problem.parts[0].runs;
        let refused = check_targets(&out, &opened.campaigns[0], runs).unwrap_err().to_string();
        assert!(refused.contains("is a link that leads out"), "{name}: {refused}");
        let written = write_campaign(&out, &opened.campaigns[0], &opened.models[0], runs);
        assert!(written.is_err() && !out.exists(), "{name}");
    }
}

/// The secret, and a table whose faults quote all kinds of cells.
const SECRET: &str = "swordfish";

/// Texts outside the campaign's folder, each wrong for another reader or in another place.
fn secrets() -> Vec<String> {
    vec![
        format!("{SECRET}=1\nTOKEN={SECRET}\n"),
        format!("{SECRET}"),
        format!("time [s],{SECRET},{SECRET}\n1,2,3\n"),
        format!("time [s],q [{SECRET}],x [m]\n0,1,2\n"),
        format!("time [s],q [m],x [m]\n{SECRET},{SECRET},{SECRET}\n"),
        format!("time [s],q [m],x [m]\n0,1,2,{SECRET}\n1,2\n"),
        format!("time [s],{SECRET},{SECRET}_2 [m]\n0,1,2\n1,2,3\n"),
        format!(
            "time [s],q [m],x [m],trigger [s],correction [m],{SECRET}\n9,1,2,3,4,5\n8,1,2,3,4,5\n"
        ),
        format!("\u{1}\u{2}{SECRET}\n"),
        format!("name = \"{SECRET}\"\n[quantities]\n{SECRET} = '{SECRET} +'\n"),
        format!(
            "name = \"m\"\n[measurands]\n{SECRET} = {{ value = '{SECRET}', unit = \"{SECRET}\" }}\n"
        ),
    ]
}

#[test]
fn messages_show_nothing_of_a_file_outside() {
    let named =
        ["line.toml", "captured.csv", "latch.csv", "logged.csv", "stream.csv", "certificate.csv"];
    for name in named {
        for (number, secret) in secrets().iter().enumerate() {
            let (root, folder) = folder();
            fs::write(root.path().join("secret"), secret).unwrap();
            let absolute = root.path().join("secret").display().to_string();
            for path in ["../secret", &absolute] {
                // A path is a model's, whatever it ends with.
                let said = format!("\"{name}\"");
                let text = CAMPAIGN.replace(&said, &format!("\"{path}\""));
                assert_ne!(text, CAMPAIGN);
                fs::write(folder.join("campaign.toml"), text).unwrap();
                let said = match opened(&folder, false) {
                    Err(faults) => faults,
                    Ok(opened) => opened.warnings.iter().map(|one| format!("{one:?}\n")).collect(),
                };
                assert!(!said.contains(SECRET), "{name} {number}: {said}");
                assert!(!said.is_empty() || number > 5, "{name} {number}");
                let refused = opened(&folder, true).unwrap_err();
                assert!(refused.contains("--confined"), "{name} {number}: {refused}");
                assert!(!refused.contains(SECRET), "{name} {number}: {refused}");
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn messages_show_nothing_of_what_a_link_leads_to() {
    let linked = ["campaign.toml", "line.toml", "effects/stretch.toml", "logged.csv", "stream.csv"];
    for name in linked {
        for (number, secret) in secrets().iter().enumerate() {
            let (root, folder) = folder();
            fs::write(root.path().join("secret"), secret).unwrap();
            fs::remove_file(folder.join(name)).unwrap();
            std::os::unix::fs::symlink(root.path().join("secret"), folder.join(name)).unwrap();
            let said = match opened(&folder, false) {
                Err(faults) => faults,
                Ok(opened) => opened.warnings.iter().map(|one| format!("{one:?}\n")).collect(),
            };
            assert!(!said.contains(SECRET), "{name} {number}: {said}");
            let refused = opened(&folder, true).unwrap_err();
            let is_withheld = refused.contains("--confined") || name == "campaign.toml";
            assert!(is_withheld && !refused.contains(SECRET), "{name} {number}: {refused}");
        }
    }
}

#[test]
fn faults_of_a_file_outside_keep_their_place() {
    let (root, folder) = folder();
    let row = "time [s],x [m]\n0,1\n1,many\n";
    fs::write(root.path().join("elsewhere.csv"), row).unwrap();
    let text = CAMPAIGN.replace("\"logged.csv\"", "\"../elsewhere.csv\"");
    fs::write(folder.join("campaign.toml"), text).unwrap();
    let fault = opened(&folder, false).unwrap_err();
    assert!(fault.contains("elsewhere.csv:3:3: error: expected a number in column `x`"), "{fault}");
    assert!(
        fault.contains("not shown, for the file lies outside the campaign's folder"),
        "{fault}"
    );
    let inside = CAMPAIGN.replace("\"logged.csv\"", "\"effects/../elsewhere.csv\"");
    fs::write(folder.join("campaign.toml"), inside).unwrap();
    fs::write(folder.join("elsewhere.csv"), row).unwrap();
    let fault = opened(&folder, true).unwrap_err();
    assert!(fault.contains("found `many`") && fault.ends_with("1,many"), "{fault}");
}

#[test]
fn files_outside_are_read_unless_they_are_refused() {
    let (root, folder) = folder();
    for name in ["line.toml", "logged.csv", "stream.csv", "latch.csv", "certificate.csv"] {
        fs::rename(folder.join(name), root.path().join(name)).unwrap();
        let text = fs::read_to_string(folder.join("campaign.toml")).unwrap();
        let text = text.replace(&format!("\"{name}\""), &format!("\"../{name}\""));
        fs::write(folder.join("campaign.toml"), text).unwrap();
        assert!(opened(&folder, false).is_ok(), "{name}");
        assert!(opened(&folder, true).unwrap_err().contains("--confined"), "{name}");
    }
}

#[test]
fn whether_a_file_outside_exists_is_not_seen_where_it_is_refused() {
    let (_root, folder) = folder();
    let text = CAMPAIGN.replace("\"logged.csv\"", "\"../none.csv\"");
    fs::write(folder.join("campaign.toml"), text).unwrap();
    assert!(opened(&folder, true).unwrap_err().contains("--confined"));
    assert!(opened(&folder, false).unwrap_err().contains("does not exist"));
}

/// Waits for nothing: a pipe that nobody writes to, a device without end, a folder.
#[cfg(unix)]
#[test]
fn what_is_not_a_regular_file_is_refused() {
    let (_root, folder) = folder();
    let pipe = folder.join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let socket = std::os::unix::net::UnixListener::bind(folder.join("socket")).unwrap();
    for irregular in ["pipe", "socket", "effects", "/dev/zero", "/dev/tty"] {
        for name in ["line.toml", "captured.csv", "latch.csv", "stream.csv", "certificate.csv"] {
            let text = CAMPAIGN.replace(&format!("\"{name}\""), &format!("\"{irregular}\""));
            let text = if irregular.starts_with('/') || name != "line.toml" {
                text
            } else {
                text.replace(&format!("\"{irregular}\""), &format!("\"./{irregular}\""))
            };
            fs::write(folder.join("campaign.toml"), text).unwrap();
            let fault = opened(&folder, false).unwrap_err();
            assert!(fault.contains("is not a file"), "{irregular} {name}: {fault}");
        }
    }
    let campaigns = [pipe, folder.join("socket"), PathBuf::from("/dev/zero")];
    for campaign in campaigns {
        let fault = opened(&campaign, false).unwrap_err();
        assert!(fault.contains("is not a file"), "{fault}");
    }
    drop(socket);
}

/// `new campaign` writes `campaign.toml`: who goes on with `campaign` is told.
#[test]
fn a_campaign_without_its_extension_is_offered() {
    let (_keep, folder) = folder();
    let faults = homepoint::campaign::file::CampaignFile::read(&folder.join("campaign"));
    let text = format!("{:?}", faults.err());
    assert!(text.contains("did you mean") && text.contains("campaign.toml"), "{text}");
}

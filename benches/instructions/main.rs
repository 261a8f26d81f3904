//! How many instructions does each task take? A gate: machines and their load change times, not
//! counts.
//!
//! Runs itself once a task under `valgrind --tool=callgrind`, counts what happens inside
//! [`counted`] and compares with `accepted.txt` beside this file: more than 3 % above the number there
//! fails.
//!
//! ```text
//! cargo run --release -p instructions                compare
//! cargo run --release -p instructions -- --accept    write the numbers found to the file
//! ```
//!
//! A package of its own: what it needs are the dependencies of the program in the profile of the
//! program, so both are built once.
//!
//! Valgrind shows programs a processor with AVX2 at most, so the AVX2 path is what is counted, on
//! AVX-512 machines too. Counts belong to a compiler and a C library (its sine and cosine); the
//! model by hand is counted as well: where it moves, they did.

#[path = "../by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

use by_hand::data::{EFFECTS, Plan, SIGMA, covariance};
use by_hand::jacobian::Model;
use by_hand::process::{on_threads, say};
use by_hand::{COLUMNS, Columns, Parameters, delay, normal};
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::{Part, Point};
use homepoint::estimate::batch::{Options, fit};
use homepoint::estimate::newton::{Given, delays_of_run};
use homepoint::library::Library;
use homepoint::system::System;
use nalgebra::DMatrix;

/// How far above its accepted number a count may be, in parts of it.
const TOLERANCE: f64 = 0.03;

const SAMPLES: usize = 1600;

const TASKS: [&str; 8] = [
    "by_hand_normal_equations",
    "by_hand_newton_delay",
    "jacobian",
    "normal_equations",
    "cost",
    "newton_delay",
    "joint_estimate",
    "model_load",
];

/// What callgrind counts.
#[inline(never)]
fn counted(work: &mut dyn FnMut()) {
    work();
    // Keeps the call above from being a jump.
    black_box(());
}

/// Does one task.
fn task(name: &str) -> Result<(), Box<dyn Error>> {
    if name == "model_load" {
        let mut part = None;
        counted(&mut || part = Some(load()));
        part.ok_or("not loaded")??;
        return Ok(());
    }
    let (mut problem, point) = Plan::of(SAMPLES).make()?;
    if name == "joint_estimate" {
        let start = Point::start(&problem.layout);
        let mut found = None;
        counted(&mut || found = Some(fit(&mut problem, start.clone(), &Options::default())));
        found.ok_or("not fitted")??;
        return Ok(());
    }
    let runs = Columns::of_all(&problem);
    let model = Model::new(Parameters::of(&problem, 0, &point));
    let sigma = covariance();
    let matrix = DMatrix::from_fn(COLUMNS, COLUMNS, |i, j| sigma[i][j]);
    let given = Given { problem: &problem, point: &point, covariance: &matrix, range: 0.5 };
    let mut work: Box<dyn FnMut()> = match name {
        "by_hand_normal_equations" => Box::new(|| {
            for data in &runs {
                black_box(&normal::gram(&model, data, SIGMA));
            }
        }),
        "by_hand_newton_delay" => Box::new(|| {
            for data in &runs {
                black_box(delay::delays(&model, data, &sigma, SIGMA, 0.5));
            }
        }),
        "jacobian" => Box::new(|| {
            for run in 0..runs.len() {
                problem.visit_run(0, run, &point, &mut |_, jacobian, residual| {
                    black_box((jacobian, residual));
                });
            }
        }),
        "normal_equations" => Box::new(|| drop(black_box(problem.normal(&point)))),
        "cost" => Box::new(|| {
            black_box(problem.cost(&point));
        }),
        "newton_delay" => Box::new(|| {
            for run in 0..runs.len() {
                for measurand in 0..3 {
                    black_box(delays_of_run(&given, 0, run, measurand));
                }
            }
        }),
        _ => return Err(format!("there is no task `{name}`").into()),
    };
    counted(&mut *work);
    Ok(())
}

/// From the texts of models and effects to a part without data.
fn load() -> Result<Part, homepoint::diagnostic::Diagnostics> {
    let library = Library::builtin()?;
    let model = library.model("polar_one_rotation", Path::new("."))?;
    let selected =
        EFFECTS.iter().map(|name| library.select(name)).collect::<Result<Vec<_>, _>>()?;
    let system = System::build(&model, &selected, &[], &[None])?;
    Ok(Part::new(system, Vec::new(), Vec::new(), SIGMA.to_vec()))
}

/// Instruction sets that this process sees.
fn instruction_sets() -> String {
    #[cfg(target_arch = "x86_64")]
    {
        let sets = [
            ("avx512f", std::is_x86_feature_detected!("avx512f")),
            ("avx2", std::is_x86_feature_detected!("avx2")),
            ("fma", std::is_x86_feature_detected!("fma")),
            ("bmi2", std::is_x86_feature_detected!("bmi2")),
            ("f16c", std::is_x86_feature_detected!("f16c")),
            ("lzcnt", std::is_x86_feature_detected!("lzcnt")),
            ("movbe", std::is_x86_feature_detected!("movbe")),
        ];
        let seen: Vec<&str> = sets.iter().filter(|set| set.1).map(|set| set.0).collect();
        seen.join(" ")
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        env::consts::ARCH.to_owned()
    }
}

/// Counts a task in a process of its own: instructions, and the instruction sets it saw.
fn count(name: &str) -> Result<(u64, String), Box<dyn Error>> {
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--collect-atstart=no"])
        .args(["--toggle-collect=instructions::counted", "--error-exitcode=9"])
        .arg(env::current_exe()?)
        .args(["--task", name])
        .output()
        .map_err(|error| format!("valgrind cannot be started: {error}; install it"))?;
    let told = String::from_utf8_lossy(&run.stderr).into_owned();
    if !run.status.success() {
        return Err(format!("task `{name}` failed under valgrind:\n{told}").into());
    }
    let collected = told.lines().find_map(|line| line.split("Collected :").nth(1));
    let number = collected.and_then(|text| text.trim().parse().ok()).filter(|number| *number > 0);
    let number = number.ok_or_else(|| format!("no count of `{name}` in:\n{told}"))?;
    Ok((number, String::from_utf8_lossy(&run.stdout).trim().to_owned()))
}

/// The compiler's version.
fn compiler() -> String {
    let asked = Command::new(env::var_os("RUSTC").unwrap_or("rustc".into())).arg("-V").output();
    asked.map_or_else(
        |_| "unknown".to_owned(),
        |out| String::from_utf8_lossy(&out.stdout).trim().into(),
    )
}

/// The accepted numbers and, under `compiler` and `processor`, what they belong to.
fn accepted(file: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(file).unwrap_or_default();
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_once(' '))
        .map(|(key, value)| (key.to_owned(), value.trim().to_owned()))
        .collect()
}

fn judge(accept: bool) -> Result<ExitCode, Box<dyn Error>> {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("accepted.txt");
    let known = accepted(&file);
    let mut text =
        "# Instructions of each task, counted by callgrind inside benches/instructions.\n\
                    # Written by `cargo run --release -p instructions -- --accept`.\n"
            .to_owned();
    let mut worse = Vec::new();
    let mut seen = String::new();
    let mut lines = String::new();
    for name in TASKS {
        let (number, sets) = count(name)?;
        seen = sets;
        let before = known.get(name).and_then(|number| number.parse::<f64>().ok());
        let change = before.map(|before| number as f64 / before - 1.0);
        let word = match change {
            None => "new".to_owned(),
            Some(change) => format!("{:+.2} %", 100.0 * change),
        };
        if change.is_none_or(|change| change > TOLERANCE) {
            worse.push(name);
        }
        say(&format!("  {name:<26} {number:>14}  {word}\n"))?;
        let _ = writeln!(lines, "{name} {number}");
    }
    let here = [("compiler", compiler()), ("processor", seen)];
    for (what, value) in &here {
        let _ = writeln!(text, "{what} {value}");
        if known.get(*what).is_some_and(|before| before != value) {
            let before = &known[*what];
            say(&format!(
                "  the numbers in the file are of {what} `{before}`, here it is `{value}`\n"
            ))?;
        }
    }
    if accept {
        fs::write(&file, text + &lines)?;
        say(&format!("  written to {}\n", file.display()))?;
        return Ok(ExitCode::SUCCESS);
    }
    if worse.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    say(&format!(
        "\n{} took more than {:.0} % more instructions than benches/instructions/accepted.txt says.\n\
         Make it as cheap as it was; or, if it must be dearer, or the compiler changed, accept:\n\
         \x20   cargo run --release -p instructions -- --accept\n\
         and commit the file with the reason.\n",
        worse.join(", "),
        100.0 * TOLERANCE
    ))?;
    Ok(ExitCode::FAILURE)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let [word, name] = arguments.as_slice()
        && word == "--task"
    {
        say(&instruction_sets())?;
        on_threads(1, || task(name).map_err(|error| error.to_string()))??;
        return Ok(ExitCode::SUCCESS);
    }
    judge(arguments.iter().any(|argument| argument == "--accept"))
}

//! How long do the signatures of the whole effect library take, in one pass over the readings?
//!
//! Against a nominal pass (Jacobian and sums of 13 unknowns), for each 13 columns; and the sums of
//! products against the least that they can cost, one multiply-add a product. See
//! docs/performance.md.

#[path = "by_hand/mod.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod by_hand;
#[path = "by_hand/timing.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod timing;

use std::error::Error;
use std::hint::black_box;
use std::path::Path;

use by_hand::data::{EFFECTS, Plan};
use by_hand::process::{on_threads, say};
use homepoint::engine::Problem;
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::lanes::products::Products;
use homepoint::engine::lanes::{LANES, Lanes};
use homepoint::engine::signatures::{Candidate, Signatures};
use homepoint::library::Library;
use homepoint::system::{Selected, System, candidates};
use timing::{Way, medians};

/// A million readings.
const SAMPLES: usize = 333_334;

/// The model with its effects and each other effect that it can have.
fn systems() -> Result<Vec<(String, System)>, Box<dyn Error>> {
    let library = Library::builtin().map_err(|faults| format!("{faults:?}"))?;
    let model = library
        .model("polar_one_rotation", Path::new("."))
        .map_err(|faults| format!("{faults:?}"))?;
    let nominal: Vec<Selected> = EFFECTS
        .iter()
        .map(|name| library.select(name))
        .collect::<Result<_, _>>()
        .map_err(|faults| format!("{faults:?}"))?;
    let mut systems = Vec::new();
    for effect in library.effects().filter(|effect| !EFFECTS.contains(&effect.name.as_str())) {
        for one in candidates(&model, effect, &[]).unwrap_or_default() {
            let mut selected = nominal.clone();
            selected.push(one);
            if let Ok(system) = System::build(&model, &selected, &[], &[None]) {
                systems.push((effect.name.clone(), system));
            }
        }
    }
    Ok(systems)
}

/// Multiply-adds a second at best: tiles of products whose columns stay in the nearest cache.
fn products_alone(problem: &Problem, count: usize, chunks: usize) {
    let columns: Vec<Lanes> = (0..count).map(|c| [c as f64; LANES]).collect();
    let columns: Vec<&Lanes> = columns.iter().collect();
    let mut products = Products::new(count, problem.instruction_set());
    for _ in 0..chunks {
        products.add(black_box(&columns));
    }
    black_box(products.sum(0, 0));
}

fn main() -> Result<(), Box<dyn Error>> {
    let (problem, point) = Plan::of(SAMPLES).make().map_err(|faults| format!("{faults:?}"))?;
    let systems = systems()?;
    let candidates: Vec<Candidate<'_>> = systems
        .iter()
        .enumerate()
        .map(|(number, (_, system))| Candidate { number, system })
        .collect();
    let signatures = Signatures::new(&problem, 0, &candidates);
    let columns = signatures.columns.len();
    let counts = signatures.columns_by_row();
    // Products of the sums, counted, and the same number in tiles of 12 columns.
    let pairs: usize = counts.iter().map(|n| (n + 1) * (n + 2) / 2).sum();
    let chunks = SAMPLES / LANES;
    let tile_pairs = 12 * 13 / 2;
    on_threads(1, || {
        let mut ways = [
            Way::new("library", || {
                black_box(problem.gram_with(&signatures, black_box(&point)));
            }),
            Way::new("rows alone", || {
                black_box(problem.rows_with(&signatures, black_box(&point)));
            }),
            Way::new("nominal", || {
                black_box(problem.normal(black_box(&point)));
            }),
            Way::new("floor", || products_alone(&problem, 12, chunks * pairs / tile_pairs)),
        ];
        let [library, rows, nominal, floor] = medians(&mut ways)[..] else { return Ok(()) };
        say(&format!(
            "\nsignatures of the effect library ({} effects, {columns} columns, {} of them in each row, \
             {} readings, medians)\n\
             \x20 library {:.2} s, of which rows {:.2} s; nominal pass {:.3} s\n\
             \x20 a nominal pass for each 13 columns: rows {:.2}, rows and sums {:.2}\n\
             \x20 sums against one multiply-add a product ({:.2} s): {:.2}\n",
            systems.len(),
            counts.iter().map(ToString::to_string).collect::<Vec<_>>().join("/"),
            3 * SAMPLES,
            library,
            rows,
            nominal,
            rows / nominal * 13.0 / (columns as f64 + 13.0),
            library / nominal * 13.0 / (columns as f64 + 13.0),
            floor,
            (library - rows) / floor,
        ))
    })??;
    Ok(())
}

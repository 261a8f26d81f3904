//! The graphs of the library's models with the library's effects: an effect whose parameters are
//! zero is exactly absent, alone and in company; with any other parameters it acts.

use std::path::Path;
use std::sync::Arc;

use homepoint::diagnostic::Source;
use homepoint::effect::Effect;
use homepoint::engine::pointwise::{Leaves, Program};
use homepoint::engine::switched_off::remains;
use homepoint::graph::{Clock, Kind, Leaf, NodeId};
use homepoint::library::Library;
use homepoint::system::{Selected, System, candidates};

/// A smooth number in (0.2, 1.2) that depends on nothing but a name.
fn number_of(name: &str, component: u8) -> f64 {
    let hash = name.bytes().fold(u32::from(component) + 7, |hash, byte| {
        hash.wrapping_mul(31).wrapping_add(u32::from(byte)).rotate_left(5)
    });
    0.2 + f64::from(hash % 9973) / 9973.0
}

/// One sample of a system at a time, every parameter of its effects at one value.
struct Sample<'s> {
    system: &'s System,
    time: f64,
    effects: f64,
}

impl Leaves<f64> for Sample<'_> {
    fn leaf(&self, leaf: Leaf) -> f64 {
        let names = &self.system.assembly.names;
        match leaf {
            Leaf::Parameter { parameter, component } => {
                let p = parameter as usize;
                let setting = &self.system.settings[p];
                if self.system.declared[p].effect.is_some() {
                    let value = setting.fixed.then_some(setting.value.as_ref()).flatten();
                    return value.map_or(self.effects, |value| value[usize::from(component)]);
                }
                let name = &names.parameters[p].name;
                if names.parameters[p].kind == Kind::Rotation {
                    let q = [0, 1, 2, 3].map(|i| number_of(name, i));
                    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
                    return q[usize::from(component)] / norm;
                }
                number_of(name, component)
            }
            Leaf::Given(_) => f64::NAN,
            Leaf::Random(random) => {
                let effect = &self.system.randoms[random as usize].effect;
                effect.as_ref().map_or(0.0, |_| self.effects)
            }
            Leaf::Input(input) => number_of(&names.inputs[input as usize].name, 0),
            Leaf::Clock(Clock::Index) => 5.0,
            Leaf::Clock(Clock::Time) => self.time,
            Leaf::Clock(Clock::UniformTime) => self.time - 0.24,
            Leaf::Clock(Clock::JumpTime) => 0.35,
            Leaf::Clock(Clock::FirstJumpTime) => -0.15,
            Leaf::Clock(Clock::LastJumpTime) => 0.25,
            Leaf::Clock(_) => self.time - 0.25,
            Leaf::Reading { measurand, component } => {
                number_of(&names.measurands[measurand as usize].name, component)
            }
        }
    }

    fn signal(&self, input: u32, order: u8, offset: f64) -> f64 {
        let phase = number_of(&self.system.assembly.names.inputs[input as usize].name, 0);
        let turned = self.time + offset + phase + f64::from(order) * std::f64::consts::FRAC_PI_2;
        0.8 * turned.sin()
    }
}

/// What a system predicts at some times, and the factors on its noise levels.
fn predictions(system: &System, effects: f64) -> (Vec<f64>, Vec<f64>) {
    let graphs = &system.assembly.measurands;
    let values: Vec<NodeId> =
        graphs.iter().flat_map(|m| m.value.nodes().iter().copied().chain([m.offset])).collect();
    let factors: Vec<NodeId> = graphs.iter().filter_map(|m| m.sigma_factor).collect();
    let run = |outputs: &[NodeId]| {
        let program = Program::new(&system.assembly.graph, outputs);
        let mut workspace = Vec::new();
        [0.0, 0.3, 1.7, 40.2]
            .into_iter()
            .flat_map(|time| {
                program.evaluate(&Sample { system, time, effects }, &mut workspace).to_vec()
            })
            .collect()
    };
    (run(&values), run(&factors))
}

#[test]
fn effects_of_the_library_are_exactly_absent_when_their_parameters_are_zero() {
    let library = Library::builtin().unwrap();
    let mut tried = 0;
    for (name, _) in library.models() {
        let model = library.model(name, Path::new(".")).unwrap();
        let (nominal, _) = predictions(&System::build(&model, &[], &[], &[]).unwrap(), 0.0);
        assert!(nominal.iter().all(|value| value.is_finite()), "{name}");
        let fitting: Vec<Selected> = library
            .effects()
            .filter_map(|effect| candidates(&model, effect, &[]).ok())
            .flatten()
            .collect();
        let alone = fitting.iter().map(std::slice::from_ref);
        for effects in alone.chain(fitting.chunks(6)) {
            let system = System::build(&model, effects, &[], &[]).unwrap();
            let words: Vec<&str> = effects.iter().map(|one| one.effect.name.as_str()).collect();
            let (found, factors) = predictions(&system, 0.0);
            assert_eq!(found, nominal, "{name} with {words:?}");
            assert!(factors.iter().all(|factor| *factor == 1.0), "{name} with {words:?}");
            let (on, factors) = predictions(&system, 1e-3);
            let acts = on != nominal || factors.iter().any(|factor| *factor != 1.0);
            assert!(acts, "{name} with {words:?} does nothing");
            let nodes = system.assembly.graph.nodes().len();
            assert!(nodes < 30_000, "{name} with {words:?}: {nodes} nodes");
            if let [alone] = effects {
                let remains = remains((&model, &[]), alone, &[], &[]).unwrap();
                assert!(remains.is_none(), "{name} with {words:?}: {remains:?}");
            }
            tried += 1;
        }
    }
    assert!(tried > 100, "{tried}");
}

/// What an effect on the distance of a polar instrument is told where its parameter is zero;
/// `None`: nothing.
fn told(parameter: &str, patch: &str) -> Option<String> {
    let text = format!(
        "name = \"own\"\ntitle = \"Own\"\nacts = \"distance\"\n[patch]\n{patch}\n[parameters]\n{parameter}\n"
    );
    let effect = Arc::new(Effect::parse(Source::new("own.toml", text)).unwrap());
    let model = Library::builtin().unwrap().model("polar_one_rotation", Path::new(".")).unwrap();
    let way = candidates(&model, &effect, &[]).unwrap().remove(0);
    let inputs = vec![None; model.inputs.len()];
    remains((&model, &[]), &way, &[], &inputs).unwrap().map(|one| one.message)
}

#[test]
fn an_effect_that_is_not_absent_at_zero_is_told_from_one_that_only_looks_so() {
    let scale = "k = { unit = \"1\", typical = \"10 ppm\", scope = \"instrument\" }";
    let constant = "k = { unit = \"1\", typical = \"10 ppm\", scope = \"instrument\" }\nc = { unit = \"1\", scope = \"instrument\", fixed = true, value = \"2\" }";
    let random = "k = { unit = \"m\", typical = \"1 um\", scope = \"sample\" }";
    let distance = "it changes `distance` where its parameters are zero";
    let noise = "it changes the noise of `distance` where its parameters are zero";
    for (parameters, patch, expected) in [
        (scale, "distance = 'self * (1 + k)'", None),
        (scale, "distance = 'self * exp(k) * (sin(vertical)^2 + cos(vertical)^2)'", None),
        (scale, "distance = 'sqrt(self^2 * (1 + k))'", None),
        (constant, "distance = 'self * (1 + c * k)'", None),
        (random, "distance = 'self + k'", None),
        (
            random,
            "position = 'rotate(orientation, rotate(inverse(orientation), self) + [0, 0, k])'",
            None,
        ),
        (scale, "distance = 'self * sqrt((1 + k)^2)'", None),
        (scale, "distance = 'self * (1 + k / k * 0.01)'", Some(distance)),
        (scale, "distance = 'self * (1.000001 + k)'", Some(distance)),
        (random, "distance = 'self + 0.9 nm + k'", Some(distance)),
        (scale, "distance = 'max(self, 2 m) * (1 + k)'", Some(distance)),
        (
            scale,
            "arm_angle = 'sqrt(self^2) * (1 + k)'",
            Some("it changes `horizontal` where its parameters are zero"),
        ),
        (
            "k = { unit = \"1\", typical = \"10 ppm\", scope = \"instrument\" }\n[shape]\norder = [0, 4]",
            "distance = 'self * (1 + k * cos(order * vertical) + order * 1e-6)'",
            Some(distance),
        ),
        (constant, "distance = 'self * (c + k)'", Some(distance)),
        (random, "distance = 'self + k + 1 um'", Some(distance)),
        (scale, "\"distance.sigma\" = 'self * (1 + k)'", None),
        (scale, "\"distance.sigma\" = 'self * (2 + k)'", Some(noise)),
    ] {
        assert_eq!(told(parameters, patch).as_deref(), expected, "{patch}");
    }
}

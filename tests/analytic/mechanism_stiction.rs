//! Stiction in scenes of mechanisms: blocks on inclines and held discs, in both models.

use phalanx::scene::{self, Preset, Scene};
use phalanx::trace::{BodyState, Model, Sample};

use crate::support::laws::{BOTH_MODELS, CollectSink};
use crate::support::runs::{assert_below, run_model};

const G: f64 = 9.81;
const MU: f64 = 0.5;

fn scene(text: &str, friction: &str) -> Scene {
    let law = format!(
        "[laws.grip]\ntype = \"step\"\nstiffness = 1e6\nexponent = 1\ndamping = \"1e3 N*s/m\"\n\
         transition = \"1 um\"\nfriction = {{ mu_static = {MU}, mu_dynamic = {MU}, {friction} }}\n"
    );
    let mut scene = scene::parse_any(&(text.to_owned() + &law), "stiction.toml").unwrap_or_else(|e| panic!("{e}"));
    scene.apply_preset(Preset::Reference);
    scene
}

const BRISTLE: &str = "law = \"bristle\", bristle_damping = \"1e3 N*s/m\"";

fn run(model: Model, scene: &Scene) -> CollectSink {
    run_model(model, scene).1
}

/// The last sample before a time, and the last sample.
fn samples_from(run: &CollectSink, time_s: f64) -> [&Sample; 2] {
    let before = run.samples.iter().rfind(|sample| sample.time_s <= time_s + 1e-12).expect("a sample");
    [before, run.samples.last().expect("a sample")]
}

/// A block of 100 g on a plane, with gravity inclined so that its tangential part is `slope` times the normal one.
fn block_on_incline(slope: f64, friction: &str) -> Scene {
    let (sin, cos) = slope.atan().sin_cos();
    let text = format!(
        "kind = \"mechanism\"\nduration = \"60 ms\"\ngravity = [\"{} m/s^2\", \"{} m/s^2\"]\n\
         [bodies.block]\nmass = \"100 g\"\ninertia = \"1e-5 kg*m^2\"\nstart = {{ at = [\"0 mm\", \"5 mm\"] }}\n\
         [bodies.block.outlines.sole]\ntype = \"capsule\"\nfrom = [\"-20 mm\", \"0 mm\"]\nto = [\"20 mm\", \"0 mm\"]\n\
         radius = \"5 mm\"\n[ground.outlines.floor]\ntype = \"half_plane\"\nnormal = [0, 1]\n\
         [[contacts]]\npoints = \"block.sole\"\nface = \"ground.floor\"\nlaw = \"grip\"\n",
        G * sin,
        -G * cos
    );
    scene(&text, friction)
}

#[test]
fn a_block_on_an_incline_sticks_without_creep_and_slides_beyond_the_friction_angle() {
    for model in BOTH_MODELS {
        let shift = |slope: f64, friction: &str| {
            let run = run(model, &block_on_incline(slope, friction));
            let [from, to] = samples_from(&run, 0.05).map(|sample| sample.body(0));
            let of = |value: fn(&BodyState) -> f64| value(&to) - value(&from);
            [of(|body| body.centre_m[0]), of(|body| body.velocity_m_s[0])]
        };
        for slope in [0.9 * MU, 0.99 * MU] {
            assert_below(shift(slope, BRISTLE)[0].abs(), 1e-9, format!("{model:?}: creep at {slope}"));
        }
        assert!(shift(0.9 * MU, "")[0] > 1e-6, "{model:?}: the regularised law creeps");
        let slope = 1.2 * MU;
        let acceleration = shift(slope, BRISTLE)[1] / 0.01;
        let expected = G * (slope - MU) / (1.0 + slope * slope).sqrt();
        assert_below((acceleration - expected).abs(), 1e-4 * expected, format!("{model:?}: {acceleration}"));
    }
}

#[test]
fn two_jaws_hold_a_disc_without_creep() {
    let jaw = |name: &str, side: f64| {
        format!(
            "[bodies.{name}]\nmass = \"50 g\"\ninertia = \"1e-5 kg*m^2\"\nguess = {{ at = [\"{} mm\", \"0 mm\"] }}\n\
             [bodies.{name}.outlines.pad]\ntype = \"half_plane\"\nnormal = [{side}, 0]\n\
             [joints.{name}]\ntype = \"prismatic\"\nbodies = [\"ground\", \"{name}\"]\n\
             points = [[\"{} mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 mm\"\n\
             [actuators.{name}]\njoint = \"{name}\"\nforce = \"{} N\"\n\
             [[contacts]]\npoints = \"ball.rim\"\nface = \"{name}.pad\"\nlaw = \"grip\"\n",
            -20.0 * side,
            -20.0 * side,
            5.0 * side
        )
    };
    let text = "kind = \"mechanism\"\nduration = \"60 ms\"\ngravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n\
                [bodies.ball]\nmass = \"400 g\"\ninertia = \"8e-5 kg*m^2\"\n\
                [bodies.ball.outlines.rim]\ntype = \"disc\"\nradius = \"20 mm\"\n"
        .to_owned()
        + &jaw("left", 1.0)
        + &jaw("right", -1.0);
    for model in BOTH_MODELS {
        let creep = |friction: &str| {
            let run = run(model, &scene(&text, friction));
            let [from, to] = samples_from(&run, 0.05);
            (to.body(0).centre_m[1] - from.body(0).centre_m[1]).abs()
        };
        assert_below(creep(BRISTLE), 1e-9, format!("{model:?}"));
        assert!(creep("") > 1e-5, "{model:?}: the regularised law creeps");
    }
}

use phalanx_core::{scene, trace};
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let scene = scene::parse_any(&std::fs::read_to_string(&path).unwrap(), &path).unwrap();
    let start = std::time::Instant::now();
    let outcome = trace::run(trace::Model::Analytic, &scene, &mut ());
    let wall = start.elapsed().as_secs_f64();
    match outcome {
        Ok(outcome) => {
            let sum: f64 = outcome.last.values().iter().map(|x| x.abs().min(1e6)).sum();
            println!("{} steps {} rhs {} sum {:.17e} wall {:.4}", path, outcome.work.steps, outcome.work.rhs_evaluations, sum, wall);
        }
        Err(error) => println!("{path} {error}"),
    }
}

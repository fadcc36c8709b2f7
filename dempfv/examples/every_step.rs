use dempfv::coupling::{Coupled, Simulation};
use dempfv::scene::Plan;
use std::time::Instant;

fn scene(packing: &str, interval: u64, update: &str, steps: u64) -> String {
    format!(
        "title = \"x\"\n[particles]\npacking = {packing:?}\ndensity = 2600.0\nyoung = 1.0e6\n\
         stiffness_ratio = 0.5\nfriction_angle = 30.0\n\
         [dem]\ndt = 1.0e-6\ndamping = 0.2\n\
         [fluid]\nviscosity = 1.0e-3\npressure = {{ y_max = 0.0 }}\n\
         remesh_interval = {interval}\nupdate = {update:?}\n\
         [[stage]]\nkind = \"run\"\nsteps = {steps}\nwalls = {{ y_max = {{ stress = 1e4 }} }}\n"
    )
}
fn at_spheres(coupled: &Coupled) -> Vec<f64> {
    let particles = coupled.dem.particles();
    let mut sums = vec![(0.0, 0.0); particles.len()];
    if let Some(flow) = coupled.flow() {
        let (cells, volume) = (&flow.network.tessellation.cells, &flow.network.volume);
        for ((cell, v), p) in cells.iter().zip(volume).zip(flow.pressure()) {
            for &vertex in cell {
                if let Some(sum) = sums.get_mut(vertex as usize) {
                    *sum = (sum.0 + v * p, sum.1 + v);
                }
            }
        }
    }
    let mut pressure = vec![0.0; particles.len()];
    for (&id, (w, v)) in particles.id.iter().zip(sums) {
        pressure[id as usize] = if v > 0.0 { w / v } else { 0.0 };
    }
    pressure
}
fn run(packing: &str, interval: u64, update: &str, steps: u64, every: u64) -> (Vec<Vec<f64>>, f64) {
    let plan = Plan::from_toml(&scene(packing, interval, update, steps), None).unwrap();
    let mut s = Simulation::new(plan).unwrap();
    let mut out = vec![];
    let mut wall = 0.0;
    loop {
        let t = Instant::now();
        let more = s.advance().unwrap();
        wall += t.elapsed().as_secs_f64();
        if s.step() % every == 0 {
            out.push(at_spheres(s.coupled()));
        }
        if !more { break; }
    }
    let ph: Vec<String> = s.coupled().phases().in_ms().filter(|(_, v)| *v > 0.0).map(|(n, v)| format!("{n} {:.3}", v / steps as f64)).collect();
    eprintln!("   {}", ph.join(", "));
    eprintln!("   {:?}", s.coupled().remesh_counts());
    (out, wall)
}
fn err(a: &[f64], b: &[f64]) -> f64 {
    let off: f64 = a.iter().zip(b).map(|(p, q)| (p - q).powi(2)).sum();
    let size: f64 = b.iter().map(|q| q.powi(2)).sum();
    (off / size).sqrt()
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let (packing, steps, every) = (&a[1], a[2].parse::<u64>().unwrap(), a[3].parse::<u64>().unwrap());
    let cache = format!("/tmp/exact-ref-{}-{steps}-{every}.bin", packing.rsplit('/').next().unwrap());
    let reference: Vec<Vec<f64>> = match std::fs::read(&cache) {
        Ok(b) => postcard_like(&b),
        Err(_) => {
            let (r, w) = run(packing, 1, "remesh", steps, every);
            eprintln!("reference {w:.1} s");
            let flat: Vec<u8> = std::iter::once(r.len() as f64).chain(r.iter().flatten().copied()).flat_map(|x| x.to_le_bytes()).collect();
            std::fs::write(&cache, flat).unwrap();
            r
        }
    };
    for update in a[4].split(',') {
        for interval in a[5].split(',').map(|x| x.parse::<u64>().unwrap()) {
            let (r, w) = run(packing, interval, update, steps, every);
            let e: Vec<f64> = r.iter().zip(&reference).map(|(a, b)| err(a, b)).collect();
            let rms = (e.iter().map(|x| x * x).sum::<f64>() / e.len() as f64).sqrt();
            let max = e.iter().fold(0.0f64, |a, b| a.max(*b));
            println!("{update:11} λ={interval:5} {:.3} ms/step rms {rms:.2e} max {max:.2e} last {:.2e}", 1e3 * w / steps as f64, e[e.len() - 1]);
        }
    }
}
fn postcard_like(b: &[u8]) -> Vec<Vec<f64>> {
    let v: Vec<f64> = b.chunks(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect();
    let n = v[0] as usize;
    v[1..].chunks((v.len() - 1) / n).map(|c| c.to_vec()).collect()
}

use std::time::Instant;
use dempfv::io::matrix_market;
use dempfv::solver::*;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let threads: usize = std::env::args().nth(2).map_or(2, |s| s.parse().unwrap());
    let reps: usize = std::env::args().nth(3).map_or(20, |s| s.parse().unwrap());
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().unwrap();
    let a = matrix_market::read_matrix(std::path::Path::new(&path)).unwrap();
    let n = a.n;
    let t = Instant::now();
    let s = SolverKind::Frontal.backend().analyze(&a, None).unwrap();
    println!("analyze {:.1} ms", t.elapsed().as_secs_f64()*1e3);
    let mut f = s.factor(&a).unwrap();
    let mut best = f64::INFINITY;
    for _ in 0..reps.min(10) { let t = Instant::now(); f = f.refactor(&a).unwrap(); best = best.min(t.elapsed().as_secs_f64()); }
    println!("refactor best {:.1} ms, memory {:.1} MB", best*1e3, f.memory_bytes() as f64/1e6);
    // x random known
    let mut seed = 1u64;
    let mut rnd = || { seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); (seed >> 11) as f64 / (1u64<<53) as f64 - 0.5 };
    let known: Vec<f64> = (0..n).map(|_| rnd()).collect();
    let mut b = vec![0.0; n]; a.multiply(&known, &mut b);
    let mut x = vec![0.0; n]; let mut c = vec![0.0; n]; let mut r = b.clone();
    let mut reference = vec![0.0; n]; f.solve(&b, &mut reference).unwrap();
    for k in 0..5 {
        f.correct(&r, &mut c).unwrap();
        for i in 0..n { x[i] += c[i]; }
        a.multiply(&x, &mut r); for i in 0..n { r[i] = b[i]-r[i]; }
        let e = x.iter().zip(&reference).map(|(x,y)| (x-y).abs()).fold(0.0, f64::max);
        println!("after {} applications: error {:.1e} residual {:.1e}", k+1, e, a.residual(&b,&x));
    }
    // smooth rhs
    let ones: Vec<f64> = (0..n).map(|_| 1.0).collect();
    a.multiply(&ones, &mut b); f.correct(&b, &mut c).unwrap();
    println!("ones: error {:.1e}", c.iter().map(|c| (c-1.0).abs()).fold(0.0, f64::max));
    let b: Vec<f64> = (0..n).map(|_| rnd()*1e-3 + 0.2e-3).collect();
    f.solve(&b, &mut x).unwrap(); f.correct(&b, &mut c).unwrap();
    let m = x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    println!("random rhs: rel error {:.1e}", c.iter().zip(&x).map(|(c,x)| (c-x).abs()).fold(0.0, f64::max)/m);
    let mut best = f64::INFINITY;
    for _ in 0..reps { let t = Instant::now(); f.correct(&b, &mut c).unwrap(); best = best.min(t.elapsed().as_secs_f64()); }
    let nnz = f.analysis().nnz_l as f64;
    println!("correct best {:.2} ms: {:.1} GB/s of L twice", best*1e3, nnz*8.0/best/1e9);
}

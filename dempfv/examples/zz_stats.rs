fn main() { let a = dempfv::io::matrix_market::read_matrix(std::path::Path::new(&std::env::args().nth(1).unwrap())).unwrap(); for _ in 0..3 {dempfv::solver::frontal::zz_stats(&a);} }

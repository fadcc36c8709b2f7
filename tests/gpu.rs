//! What the program does when CUDA fails, call by call, on the stand-in for CUDA:
//! `make cuda-test` runs this where there is no GPU.
#![cfg(feature = "cuda")]

mod program;

use program::{Folder, error};
use serde_json::Value;

/// Every function of CUDA, of its driver and of cuBLAS that CHOLMOD's way to a
/// GPU takes.
const FUNCTIONS: [&str; 36] = [
    "cudaGetDeviceCount",
    "cudaGetDevice",
    "cudaSetDevice",
    "cudaGetDeviceProperties",
    "cudaDeviceGetAttribute",
    "cudaRuntimeGetVersion",
    "cudaDriverGetVersion",
    "cudaGetLastError",
    "cudaMemGetInfo",
    "cudaMalloc",
    "cudaFree",
    "cudaMallocHost",
    "cudaFreeHost",
    "cudaMemset",
    "cudaMemcpy",
    "cudaMemcpyAsync",
    "cudaMemcpy2DAsync",
    "cudaDeviceSynchronize",
    "cudaStreamCreate",
    "cudaStreamDestroy",
    "cudaStreamSynchronize",
    "cudaStreamWaitEvent",
    "cudaEventCreateWithFlags",
    "cudaEventDestroy",
    "cudaEventRecord",
    "cudaEventQuery",
    "cudaEventSynchronize",
    "cublasCreate_v2",
    "cublasSetStream_v2",
    "cublasDgemm_v2",
    "cublasDsyrk_v2",
    "cublasDtrsm_v2",
    "cublasDestroy_v2",
    "cuModuleLoadData",
    "cuModuleGetFunction",
    "cuLaunchKernel",
];

/// Without these a GPU works as well.
const NEEDLESS: [&str; 9] = [
    "cudaDeviceGetAttribute",
    "cudaRuntimeGetVersion",
    "cudaDriverGetVersion",
    "cudaGetLastError",
    "cudaFree",
    "cudaFreeHost",
    "cudaStreamDestroy",
    "cudaEventDestroy",
    "cublasDestroy_v2",
];

/// The seven-point Laplacian on a bar of m x m x l unknowns.
fn laplacian(m: usize, l: usize) -> String {
    let mut lines = Vec::new();
    for j in 0..m * m * l {
        let (x, y, z) = (j % m, j / m % m, j / (m * m));
        lines.push(format!("{0} {0} 6", j + 1));
        for (inside, stride) in [(x + 1 < m, 1), (y + 1 < m, m), (z + 1 < l, m * m)] {
            if inside {
                lines.push(format!("{} {} -1", j + stride + 1, j + 1));
            }
        }
    }
    let head = "%%MatrixMarket matrix coordinate integer symmetric";
    format!("{head}\n{0} {0} {1}\n{2}\n", m * m * l, lines.len(), lines.join("\n"))
}

/// Solves the matrix with the GPU solver; returns what is told of it.
fn solve(folder: &Folder, environment: &[(&str, &str)]) -> Value {
    let mut command = folder.command(&["solve", "a.mtx", "--solver", "cholmod-gpu", "--json", "-"]);
    let output = command.envs(environment.iter().copied()).output().unwrap();
    assert!(output.status.success(), "{environment:?}: {}", error(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let solver = report["solvers"][0].clone();
    // The solution is all ones.
    assert!(solver["forward_error"].as_f64().unwrap() < 1e-10, "{environment:?}: {solver}");
    solver
}

/// Each function fails at its first, third or tenth call and from then on: one
/// reason that names it, and the CPU's result.
#[test]
fn an_error_of_cuda_ends_on_the_cpu() {
    let folder = Folder::new("gpu-errors");
    folder.write("a.mtx", &laplacian(26, 52));
    assert_eq!(solve(&folder, &[])["placement"]["device"], "gpu");
    for function in FUNCTIONS {
        for call in [1, 3, 10] {
            let wish = format!("{function}:{call}");
            let placement = solve(&folder, &[("CUDA_STANDIN_FAIL", &wish)])["placement"].clone();
            let needless = NEEDLESS.contains(&function);
            match placement["device"].as_str().unwrap() {
                "gpu" => assert!(needless || call > 1, "{wish}: {placement}"),
                "fallback" => {
                    assert!(!needless, "{wish}: {placement}");
                    let reason = placement["reason"].as_str().unwrap();
                    assert!(!reason.is_empty() && !reason.contains('\n'), "{wish}: {reason}");
                }
                other => panic!("{wish}: {other}"),
            }
        }
    }
}

/// What a user meets first: no library, no GPU, an old driver, no memory.
#[test]
fn the_reason_is_told() {
    let folder = Folder::new("gpu-reasons");
    folder.write("a.mtx", &laplacian(26, 52));
    let reason = |environment: &[(&str, &str)]| {
        solve(&folder, environment)["placement"]["reason"].as_str().unwrap().to_owned()
    };
    let fail = |wish| reason(&[("CUDA_STANDIN_FAIL", wish)]);
    assert!(fail("cudaGetDeviceCount:1:100").contains("no CUDA-capable device"));
    assert!(fail("cudaGetDeviceCount:1:35").contains("driver version is insufficient"));
    assert!(fail("cudaMalloc:1:2").contains("out of memory"));
    assert!(reason(&[("DEMPFV_CUDA_LIBRARIES", "nowhere")]).contains("no NVIDIA driver"));
    // Nothing fails, and the result is nonsense: the program looks at it.
    assert!(reason(&[("CUDA_STANDIN_LIES", "1")]).contains("its factor is wrong"));
    assert!(reason(&[("CUDA_STANDIN_MEMORY", "5000000")]).contains("2 MB may be taken"));
}

/// A coupled run: as far as the CPU's to round-off, with the calls in its summary;
/// a GPU that fails on the way changes nothing but who does the work.
#[test]
fn a_run_tells_what_the_gpu_did() {
    let folder = Folder::new("gpu-run");
    let packing = concat!(env!("CARGO_MANIFEST_DIR"), "/packings/oedometer-5000.txt");
    let scene = |solver: &str, remesh: &str| {
        format!(
            "[particles]\npacking = {packing:?}\nyoung = 1.0e6\n\
             [dem]\ndt = 1.0e-6\n\
             [fluid]\nviscosity = 1.0e-3\npressure = {{ y_max = 0.0 }}\nremesh_interval = 4\n\
             {solver}\n{remesh}\n\
             [[stage]]\nkind = \"run\"\nsteps = 9\nwalls = {{ y_max = {{ stress = 2000.0 }} }}\n\
             [output]\nprobes = [[0.019, 0.019, 0.019]]\n"
        )
    };
    let run = |name: &str, scene: &str, environment: &[(&str, &str)]| {
        folder.write(&format!("{name}.toml"), scene);
        let file = format!("{name}.toml");
        let mut command = folder.command(&["run", &file, "--out", name, "--threads", "2"]);
        let output = command.envs(environment.iter().copied()).output().unwrap();
        assert!(output.status.success(), "{}", error(&output));
        let summary: Value =
            serde_json::from_str(&folder.read(&format!("{name}/summary.json"))).unwrap();
        (summary, String::from_utf8(output.stdout).unwrap())
    };
    let gpu = "solver = \"cholmod-gpu\"\ngpu_memory = 4e8";
    let background = "remesh = \"background\"";
    let pressure = |name: &str| {
        let text = folder.read(&format!("{name}/history.csv"));
        let mut rows = text.lines().map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
        let at = rows.next().unwrap().iter().position(|c| c.starts_with("probe")).unwrap();
        rows.next_back().unwrap()[at].parse::<f64>().unwrap()
    };
    let (cpu, _) = run("cpu", &scene("", background), &[]);
    assert!(cpu["gpu"].is_null());
    for (name, remesh) in [("gpu", ""), ("background", background)] {
        let (summary, text) = run(name, &scene(gpu, remesh), &[]);
        assert!(summary["gpu"]["factorizations"].as_u64().unwrap() >= 2, "{}", summary["gpu"]);
        assert!(summary["gpu"]["syrk_calls"].as_u64().unwrap() > 0, "{}", summary["gpu"]);
        assert_eq!(summary["gpu"]["fallbacks"], 0);
        assert!(text.contains("factorizations on stand-in for CUDA"), "{text}");
    }
    assert!((pressure("background") / pressure("cpu") - 1.0).abs() < 1e-8);
    let (summary, text) =
        run("broken", &scene(gpu, background), &[("CUDA_STANDIN_FAIL", "cudaMemcpyAsync:100")]);
    assert!(summary["gpu"]["fallbacks"].as_u64().unwrap() >= 1, "{}", summary["gpu"]);
    assert!(text.contains("on the CPU: stand-in"), "{text}");
    assert!((pressure("broken") / pressure("cpu") - 1.0).abs() < 1e-8);
}

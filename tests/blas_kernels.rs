//! Which kernels the BLAS computes with: whom they concern, and what is said of old ones.

mod program;

use program::{Folder, error, scene};

/// The kernels that `OPENBLAS_CORETYPE` asks for, an old and a newer one; `None` where the BLAS has
/// no choice or the processor no newer vectors.
fn old_and_newer(test: &str) -> Option<[&'static str; 2]> {
    let folder = Folder::new(test);
    let doctor: serde_json::Value =
        serde_json::from_str(&folder.done(&["doctor", "--json", "-"])).unwrap();
    let has_choice = doctor["versions"]["blas"].as_str().unwrap().contains("DYNAMIC_ARCH");
    #[cfg(target_arch = "x86_64")]
    let has_avx2 = is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    let has_avx2 = false;
    (has_choice && has_avx2).then_some(["Prescott", "Haswell"])
}

fn done(folder: &Folder, kernels: &str, args: &[&str]) -> [String; 2] {
    let output = folder.command(args).env("OPENBLAS_CORETYPE", kernels).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", error(&output));
    [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap())
}

/// The seven-point Laplacian of a cube with 21 unknowns a side: more than `auto` leaves to CHOLMOD.
fn laplacian() -> String {
    let (m, mut lines) = (21, vec![]);
    for k in 0..m * m * m {
        lines.push(format!("{0} {0} 6", k + 1));
        for (place, step) in [(k % m, 1), (k / m % m, m), (k / (m * m), m * m)] {
            if place + 1 < m {
                lines.push(format!("{} {} -1", k + step + 1, k + 1));
            }
        }
    }
    let head = "%%MatrixMarket matrix coordinate integer symmetric";
    format!("{head}\n{0} {0} {1}\n{2}\n", m * m * m, lines.len(), lines.join("\n"))
}

/// The default solver of large systems multiplies by itself: a BLAS with other kernels leaves every
/// bit of a solution as it is, and nothing is said of it. (With products by the BLAS these two solutions
/// differ.)
#[test]
fn the_frontal_solver_does_not_depend_on_the_blas() {
    let Some(kernels) = old_and_newer("independent-doctor") else { return };
    let folder = Folder::new("independent");
    folder.write("a.mtx", &laplacian());
    let values: Vec<String> = (0..21 * 21 * 21).map(|k| format!("{}", k * 31 % 1_009)).collect();
    let head = "%%MatrixMarket matrix array integer general";
    folder.write("b.mtx", &format!("{head}\n{} 1\n{}\n", values.len(), values.join("\n")));
    let solutions = kernels.map(|kernels| {
        let args =
            ["solve", "a.mtx", "b.mtx", "--solver", "auto", "--solution", "x.mtx", "--force"];
        let [said, warned] = done(&folder, kernels, &args);
        assert!(said.contains("auto: by frontal") && !said.contains("BLAS"), "{said}");
        assert!(warned.is_empty(), "{warned}");
        folder.read("x.mtx")
    });
    assert!(solutions[0] == solutions[1]);
}

/// CHOLMOD takes longer with kernels of 2004 than it need: `doctor` and whoever asks for CHOLMOD hear
/// of it and of what to set, and nobody who has newer ones.
#[test]
fn old_kernels_are_told_to_those_who_use_cholmod() {
    let Some([old, newer]) = old_and_newer("old-kernels-doctor") else { return };
    let folder = Folder::new("old-kernels");
    let text = scene("", "").replace("[fluid]", "[fluid]\nsolver = \"cholmod\"");
    folder.write("scene.toml", &text);
    folder.write("a.mtx", &laplacian());
    let commands: [&[&str]; 3] = [
        &["doctor"],
        &["solve", "a.mtx", "--solver", "cholmod"],
        &["run", "scene.toml", "--out", "out", "--force"],
    ];
    let advice = "set OPENBLAS_CORETYPE=";
    for args in commands {
        let all = done(&folder, old, args).concat();
        assert!(all.contains("kernels for Prescott") && all.contains(advice), "{args:?}: {all}");
        let all = done(&folder, newer, args).concat();
        assert!(!all.contains(advice), "{args:?}: {all}");
    }
    let [said, warned] = done(&folder, old, commands[2]);
    assert!(warned.contains(advice), "before the work: {warned}\n{said}");
    let warnings = folder.json("out/summary.json")["warnings"].to_string();
    assert!(warnings.contains(advice), "{warnings}");
}

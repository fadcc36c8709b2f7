//! What is mutated: shipped files, cut to a size that is quick to read, and the forms that others
//! write.

use std::path::{Path, PathBuf};

use dempfv::scene::Plan;
use dempfv::simulation::{Simulation, SimulationState};

/// A folder of this process and target for inputs that are read from files.
pub fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("dempfv-fuzz-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn shipped(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    std::fs::read_to_string(root.join(path)).unwrap()
}

fn head(text: &str, lines: usize) -> Vec<u8> {
    let lines: Vec<&str> = text.lines().take(lines).collect();
    (lines.join("\n") + "\n").into_bytes()
}

/// Few spheres in a box: small enough to be triangulated and solved a hundred thousand times.
pub fn few_spheres() -> Vec<Vec<u8>> {
    let eight = "# box 0 0 0 1 1 1\n.2 .2 .2 .2\n.6 .2 .25 .2\n.2 .7 .2 .2\n.7 .7 .2 .2\n\
                 .2 .2 .7 .2\n.7 .2 .7 .2\n.2 .7 .7 .2\n.7 .7 .75 .2\n";
    let lattice: String = (0..27)
        .map(|i| {
            let at = |k: i32| f64::from(k) + 0.5;
            format!("{:?} {:?} {:?} 0.5\n", at(i % 3), at(i / 3 % 3), at(i / 9))
        })
        .collect();
    let overlapping = "# box 0 0 0 2 1 1\n.5 .5 .5 .45\n.9 .5 .5 .45\n1.5 .5 .5 .4\n";
    [eight, "# box 0 0 0 3 3 3\n", overlapping, ".5 .5 .5 .5\n"]
        .map(|text| if text.ends_with("3 3\n") { format!("{text}{lattice}") } else { text.into() })
        .map(String::into_bytes)
        .to_vec()
}

pub fn packings() -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = ["oedometer-1000.txt", "lattice-1000.txt", "polydisperse-2000.txt"]
        .map(|name| head(&shipped(&format!("packings/{name}")), 24))
        .to_vec();
    all.extend(few_spheres());
    all.extend(
        [
            "x,y,z,radius\n0.1,0.2,0.3,0.05\n0.4,0.5,0.6,0.05\n",
            "id;x;y;z;diameter\n1;0.1;0.2;0.3;0.05\n",
            "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n\
             0 1\nITEM: ATOMS id type x y z radius\n1 1 .2 .2 .2 .1\n2 1 .6 .6 .6 .1\n",
            "##PERIODIC:: 1 1 1\n0.1 0.2 0.3 0.05 -1\n",
            "#format x_y_z_r_attrs\n0.1\t0.2\t0.3\t0.05\tall\n0.3\t0.2\t0.3\t0.05\tall\n",
            "0 Sphere 0.1 0.2 0.3 0.05\n1 Sphere 0.4 0.2 0.3 0.05\n",
            "\u{feff}# Box: 0 0 0 1 1 1\r\n.5 .5 .5 1d-1\r\n",
        ]
        .map(|text| text.as_bytes().to_vec()),
    );
    all
}

/// Shipped scenes, each with the packing `few.txt` beside it.
pub fn scenes() -> Vec<Vec<u8>> {
    let names = ["first", "oedometer", "caulk2020", "dry-triaxial", "permeability"];
    names
        .iter()
        .map(|name| {
            let text = shipped(&format!("scenes/{name}.toml"));
            let line = |line: &str| match line.starts_with("packing =") {
                true => "packing = \"few.txt\"\n".to_owned(),
                false => format!("{line}\n"),
            };
            text.lines().map(line).collect::<String>().into_bytes()
        })
        .collect()
}

/// Scenes that are carried out: few spheres and steps.
pub fn small_scenes() -> Vec<Vec<u8>> {
    let wet = "seed = 3\n[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[particles]\n\
        packing = \"few.txt\"\nyoung = 1e6\ndensity = 2600\nfriction_angle = 30\n[dem]\n\
        damping = 0.2\ngravity = [0, -9.81, 0]\n[fluid]\nviscosity = 1e-3\n\
        remesh_interval = 2\npressure = { y_max = 0.0 }\n[[stage]]\nkind = \"run\"\nsteps = 4\n\
        walls = { y_max = { velocity = -0.1 }, x_min = { stress = 1e3 } }\n";
    let cloud = "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[particles]\n\
        cloud = { count = 20, spread = 0.3, porosity = 0.9 }\n[dem]\ndt = 1e-4\n[fluid]\n\
        viscosity = 1.0\nremesh = \"ahead\"\nupdate = \"every step\"\nremesh_strain = 0.01\n\
        tolerance = 1e-6\npressure = { y_max = 0.0, y_min = 1.0 }\n[[stage]]\nkind = \"compact\"\n\
        stress = 1e4\nfriction_angle = 3\n[[stage]]\nkind = \"permeability\"\naxis = \"y\"\n";
    let sizes = "[box]\nmin = [0, 0, 0]\nmax = [2, 1, 1]\n[particles]\n\
        cloud = { count = 30, sizes = [{ radius = 0.1, share = 0.5 }, { radius = 0.05, share = 0.5 }] }\n\
        [dem]\nrotation = false\n[[stage]]\nkind = \"run\"\ntime = 0.01\n";
    [wet, cloud, sizes].map(|text| text.as_bytes().to_vec()).to_vec()
}

pub fn matrices() -> Vec<Vec<u8>> {
    [
        "%%MatrixMarket matrix coordinate real symmetric\n% a comment\n3 3 5\n1 1 2.0\n2 1 -1.0\n\
         2 2 2.0\n3 2 -1.0\n3 3 2.0\n",
        "%%MatrixMarket matrix coordinate real general\n2 2 4\n1 1 4\n1 2 -1\n2 1 -1\n2 2 4\n",
        "%%MatrixMarket matrix array real symmetric\n2 2\n4\n-1\n4\n",
        "%%MatrixMarket matrix array integer general\n3 1\n1\n2\n3\n",
        "%%MatrixMarket matrix coordinate real general\n3 1 2\n1 1 1.0\n3 1 2.0\n",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// A wet run of a few spheres, to the middle of its only stage.
pub fn plan() -> Plan {
    let folder = folder("plan");
    std::fs::write(folder.join("few.txt"), &few_spheres()[0]).unwrap();
    let scene = String::from_utf8(small_scenes()[0].clone()).unwrap();
    Plan::from_toml(&scene, Some(&folder.join("scene.toml"))).unwrap()
}

pub fn state() -> SimulationState {
    let mut simulation = Simulation::new(plan()).unwrap();
    for _ in 0..3 {
        simulation.advance().unwrap();
    }
    simulation.state()
}

//! The README's first scene is the one that is shipped, and it is a scene.

use std::fs;
use std::path::Path;

use dempfv::scene::Plan;

#[test]
fn the_first_scene_is_the_one_that_is_shipped() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let block = readme.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let path = root.join("scenes/first.toml");
    assert_eq!(block, fs::read_to_string(&path).unwrap());
    let plan = Plan::load(&path).unwrap();
    assert!(plan.fluid.is_some() && plan.stages.len() == 1);
}

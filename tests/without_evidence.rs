//! The program without its measurements: it says where they are.
#![cfg(not(feature = "evidence"))]

mod program;

use program::{Folder, error};

#[test]
fn what_is_not_built_is_named_and_not_offered() {
    let folder = Folder::new("without-evidence");
    let help = folder.done(&["--help"]);
    assert!(help.contains("permeability") && !help.contains("paper"), "{help}");
    let measurements: [&[&str]; 6] = [
        &["compare", "yade", "--part", "time"],
        &["paper", "--help"],
        &["every-step"],
        &["effect-costs", "--turns", "1"],
        &["accuracy-yade", "--quick"],
        &["representative-volume", "--seeds", "2"],
    ];
    for words in measurements {
        let output = folder.dempfv(words);
        let message = error(&output);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(words[0]) && message.contains("`evidence`"), "{message}");
    }
    assert!(folder.files().is_empty());
}

//! The folder that results go to.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv::io::atomic;

/// Where results go, and whether older ones may be replaced.
#[derive(clap::Args)]
pub struct OutputArgs {
    /// Folder for the results; out/NAME of the scene if not given
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Replace results that are already there
    #[arg(long)]
    pub force: bool,
}

impl OutputArgs {
    /// Where the results of `input` go.
    pub fn place(&self, input: &Path) -> PathBuf {
        let name = input.file_stem().unwrap_or(input.as_os_str());
        self.out.clone().unwrap_or_else(|| Path::new("out").join(name))
    }

    /// The folder for the results of `input`; nothing is made yet.
    ///
    /// # Errors
    /// [`InputError`] when `result` (the file that marks a result) is in it and `--force`
    /// is not given, or the path is no folder.
    pub fn folder(&self, input: &Path, result: &str) -> Result<PathBuf, InputError> {
        let folder = self.place(input);
        if folder.exists() && !folder.is_dir() {
            return Err(InputError::new(
                format!("--out {} is no folder", folder.display()),
                "name a folder",
            ));
        }
        if !self.force && folder.join(result).exists() {
            return Err(InputError::new(
                format!("{} holds a result already", folder.display()),
                "give --force to replace it, or another --out",
            ));
        }
        Ok(folder)
    }
}

/// Makes a folder for results.
///
/// # Errors
/// [`InputError`] when the system refuses.
pub fn make_folder(folder: &Path) -> Result<(), InputError> {
    let refused = |e: std::io::Error| {
        let what = format!("--out {}: {e}", folder.display());
        InputError::new(what, "name a folder that can be made and that you may write to")
    };
    std::fs::create_dir_all(folder).map_err(refused)?;
    let probe = folder.join(".dempfv-probe");
    std::fs::write(&probe, "").and_then(|()| std::fs::remove_file(&probe)).map_err(refused)
}

/// A folder that no other run writes into while this is held; a crash lets go of it, too.
#[derive(Debug)]
pub struct FolderLock(#[expect(dead_code, reason = "closing it unlocks")] Option<File>);

/// Locks a folder for the results of one run, and removes what writers that were killed have left
/// half written in it. Where the file system knows no locks, there is none.
///
/// # Errors
/// [`InputError`] when another run holds it.
pub fn lock_folder(folder: &Path) -> Result<FolderLock, InputError> {
    let Ok(file) = File::open(folder) else { return Ok(FolderLock(None)) };
    match file.try_lock() {
        Ok(()) => {
            atomic::remove_leftovers(folder);
            Ok(FolderLock(Some(file)))
        }
        Err(TryLockError::WouldBlock) => Err(InputError::new(
            format!("another run writes into {}", folder.display()),
            "wait until it is done, or give another --out",
        )),
        Err(TryLockError::Error(_)) => Ok(FolderLock(None)),
    }
}

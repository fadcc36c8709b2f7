//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::io::IoError;
use crate::io::error::Result;

/// A file that is written beside its place and takes it on
/// [`commit`](AtomicFile::commit); dropped before that, it leaves nothing
/// behind and the old file, if any, as it was. What is no file but can be
/// written to, a pipe or `/dev/null`, is written to and stays what it is.
///
/// ```
/// use std::io::Write;
/// use dempfv::io::atomic::AtomicFile;
/// let folder = std::env::temp_dir().join("dempfv-doc-atomic");
/// std::fs::create_dir_all(&folder).unwrap();
/// let path = folder.join("answer.txt");
/// let mut file = AtomicFile::create(&path)?;
/// file.write_all(b"42").unwrap();
/// file.commit()?;
/// assert_eq!(std::fs::read(&path).unwrap(), b"42");
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), dempfv::Error>(())
/// ```
#[derive(Debug)]
pub struct AtomicFile {
    writer: BufWriter<File>,
    path: PathBuf,
    /// The file beside; `None` where `path` itself is written to.
    temporary: Option<Temporary>,
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `path`, or what is no file.
    ///
    /// # Errors
    /// [`IoError::File`] when the folder is missing or not writable.
    pub fn create(path: &Path) -> Result<Self> {
        let (file, temporary) = if is_pipe_or_device(path) {
            (File::options().write(true).open(path), None)
        } else {
            let temporary = Temporary(temporary_name(path));
            (File::create(&temporary.0), Some(temporary))
        };
        let file = file.map_err(|e| IoError::file(path, e))?;
        let writer = BufWriter::with_capacity(1 << 18, file);
        Ok(AtomicFile { writer, path: path.to_owned(), temporary })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// [`IoError::File`] when the rest cannot be written (a full disk) or the file
    /// cannot be renamed; then nothing of it remains.
    pub fn commit(self) -> Result<()> {
        self.finish(false)
    }

    /// Like [`commit`](AtomicFile::commit), after the disk has confirmed the
    /// data: what was there before is given up only for something that
    /// survives a power cut.
    ///
    /// # Errors
    /// As [`commit`](AtomicFile::commit).
    pub fn commit_durably(self) -> Result<()> {
        self.finish(true)
    }

    fn finish(mut self, durably: bool) -> Result<()> {
        let io = |e| IoError::file(&self.path, e);
        self.writer.flush().map_err(io)?;
        let Some(temporary) = &self.temporary else { return Ok(()) };
        if durably {
            self.writer.get_ref().sync_all().map_err(io)?;
        }
        fs::rename(&temporary.0, &self.path).map_err(io)
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Writes `contents` to `path`, whole or not at all.
///
/// # Errors
/// [`IoError::File`], as [`AtomicFile`].
pub fn write(path: &Path, contents: &[u8]) -> Result<()> {
    write_with(path, |file| file.write_all(contents))
}

/// Writes to `path` what `fill` writes, whole or not at all.
///
/// # Errors
/// [`IoError::File`], as [`AtomicFile`], and what `fill` returns.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut AtomicFile) -> io::Result<()>) -> Result<()> {
    let mut file = AtomicFile::create(path)?;
    fill(&mut file).map_err(|e| IoError::file(path, e))?;
    file.commit()
}

/// Removes temporary files in a folder whose writers are gone: killed in the midst of writing.
/// Does nothing where the system does not tell which processes there are.
pub fn remove_leftovers(folder: &Path) {
    if !Path::new("/proc/self").exists() {
        return;
    }
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let gone = writer_of(name).is_some_and(|id| !Path::new(&format!("/proc/{id}")).exists());
        if gone {
            // One that stays does no harm.
            let _ = fs::remove_file(&path);
        }
    }
}

/// The process whose temporary file has this name.
fn writer_of(name: &str) -> Option<u32> {
    let (_, ids) = name.strip_prefix('.')?.strip_suffix(".tmp")?.rsplit_once('.')?;
    let (process, serial) = ids.split_once('-')?;
    serial.parse::<u64>().ok()?;
    process.parse().ok()
}

/// Removes its file when dropped; after the rename there is none to remove.
#[derive(Debug)]
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// True for what a rename would replace by a file, to everybody's surprise.
fn is_pipe_or_device(path: &Path) -> bool {
    path.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// A name in the same folder (a rename must not cross file systems) that no
/// other writer of this or another process uses.
fn temporary_name(path: &Path) -> PathBuf {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let serial = NEXT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{serial}.tmp", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a killed process has left goes; what this one is writing, and all else, stays.
    #[test]
    fn only_leftovers_of_the_dead_are_removed() {
        let folder = std::env::temp_dir().join(format!("dempfv-leftovers-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let own = format!(".a.csv.{}-7.tmp", std::process::id());
        // No process has the largest number there is.
        let dead = format!(".a.csv.{}-3.tmp", u32::MAX);
        for name in [own.as_str(), dead.as_str(), "a.csv", ".tmp", ".a.4-x.tmp"] {
            fs::write(folder.join(name), "x").unwrap();
        }
        remove_leftovers(&folder);
        let there = |name: &str| folder.join(name).exists();
        assert!(
            !there(&dead) && there(&own) && there("a.csv") && there(".tmp") && there(".a.4-x.tmp")
        );
        fs::remove_dir_all(&folder).unwrap();
    }
}

//! Checkpoints: the state of a run in one file.
//!
//! The file starts with a head: eight magic bytes, the format's version (u32),
//! the CRC-32 and the length (u64) of what follows, the program's version
//! (length u32, text); then the state in postcard encoding. All integers are
//! little endian. Floating point numbers keep their bits.

use std::io;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::atomic::AtomicFile;
use crate::excerpt::excerpt;
use crate::input::InputError;
use crate::io::IoError;
use crate::io::error::Result;
use crate::{Aabb, Cell, Vec3};

const MAGIC: &[u8; 8] = b"dempfvCP";
/// To be raised when a state of the same program version would no longer load.
const FORMAT: u32 = 11;
const VERSION: &str = env!("CARGO_PKG_VERSION");
const REMEDY: &str =
    "give a checkpoint that this version of dempfv wrote, or begin the run anew without it";

/// What the first part of a state says it is.
const SPHERES: &str = "spheres";

/// Spheres with what is around them: what a state begins with whose checkpoint may be read as a
/// packing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spheres {
    kind: String,
    /// Centres (m), by the user's numbers.
    pub position: Vec<Vec3>,
    /// Radii (m).
    pub radius: Vec<f64>,
    /// The box (m); `None` in a periodic cell.
    pub bounds: Option<Aabb>,
    /// The periodic cell; `None` between walls.
    pub cell: Option<Cell>,
}

impl Spheres {
    /// Spheres in a box or in a cell.
    pub fn new(
        position: Vec<Vec3>,
        radius: Vec<f64>,
        bounds: Option<Aabb>,
        cell: Option<Cell>,
    ) -> Spheres {
        Spheres { kind: SPHERES.to_owned(), position, radius, bounds, cell }
    }

    /// The spheres that the state in a checkpoint begins with; `None` for bytes that are no checkpoint.
    pub(super) fn of_bytes(bytes: &[u8]) -> Option<Result<Spheres, InputError>> {
        if !bytes.starts_with(MAGIC) {
            return None;
        }
        let spheres = body(bytes).and_then(|body| {
            let other = "the checkpoint's state has no spheres to begin with";
            match postcard::take_from_bytes::<Spheres>(body) {
                Ok((spheres, _)) if spheres.kind == SPHERES => Ok(spheres),
                _ => Err(other.to_owned()),
            }
        });
        Some(spheres.map_err(|what| InputError::new(what, REMEDY)))
    }
}

/// Writes a checkpoint. The one that was there is replaced only once the disk
/// has the new one.
///
/// # Errors
/// [`IoError::File`] when the file cannot be written; nothing partial remains and
/// an older checkpoint of that name stands.
pub fn save<T: Serialize>(path: &Path, state: &T) -> Result<()> {
    let body = postcard::to_stdvec(state).map_err(|e| {
        IoError::file(path, io::Error::other(format!("the state cannot be stored: {e}")))
    })?;
    let mut head = Vec::with_capacity(64);
    head.extend_from_slice(MAGIC);
    head.extend_from_slice(&FORMAT.to_le_bytes());
    head.extend_from_slice(&crc32fast::hash(&body).to_le_bytes());
    head.extend_from_slice(&(body.len() as u64).to_le_bytes());
    head.extend_from_slice(&(VERSION.len() as u32).to_le_bytes());
    head.extend_from_slice(VERSION.as_bytes());
    let mut file = AtomicFile::create(path)?;
    io::Write::write_all(&mut file, &head)
        .and_then(|()| io::Write::write_all(&mut file, &body))
        .map_err(|e| IoError::file(path, e))?;
    file.commit_durably()
}

/// Reads a checkpoint.
///
/// ```
/// use dempfv::io::checkpoint;
/// let path = std::env::temp_dir().join("dempfv-doc.checkpoint");
/// checkpoint::save(&path, &(7_u64, vec![0.1, -0.0]))?;
/// let (step, values): (u64, Vec<f64>) = checkpoint::load(&path)?;
/// assert_eq!((step, values[1].to_bits()), (7, (-0.0_f64).to_bits()));
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), dempfv::Error>(())
/// ```
///
/// # Errors
/// [`InputError`] when there is no such file, it is no checkpoint, one of
/// another version, cut short, damaged, or of another state than `T`.
pub fn load<T: DeserializeOwned>(path: &Path) -> Result<T, InputError> {
    let wrong = |what: String| InputError::new(what, REMEDY).in_file(path);
    let bytes = std::fs::read(path).map_err(|e| match e.kind() {
        io::ErrorKind::NotFound => wrong("no such checkpoint".into()),
        _ => wrong(format!("the checkpoint cannot be read: {e}")),
    })?;
    let body = body(&bytes).map_err(wrong)?;
    match postcard::take_from_bytes(body) {
        Ok((state, [])) => Ok(state),
        Ok(_) => Err(wrong("the checkpoint holds more than this kind of state".into())),
        Err(e) => Err(wrong(format!("the checkpoint holds another kind of state ({e})"))),
    }
}

/// The state's bytes, once the head vouches for them.
fn body(bytes: &[u8]) -> Result<&[u8], String> {
    let mut rest = bytes;
    if take(&mut rest, MAGIC.len()) != Some(MAGIC) {
        return Err("not a checkpoint".into());
    }
    let cut = "the checkpoint is cut short";
    let format = take_u32(&mut rest).ok_or(cut)?;
    if format != FORMAT {
        return Err(format!("a checkpoint of format {format}; this program reads format {FORMAT}"));
    }
    let checksum = take_u32(&mut rest).ok_or(cut)?;
    let low = take_u32(&mut rest).ok_or(cut)?;
    let high = take_u32(&mut rest).ok_or(cut)?;
    let length = u64::from(high) << 32 | u64::from(low);
    let name = take_u32(&mut rest).ok_or(cut)? as usize;
    let version = String::from_utf8_lossy(take(&mut rest, name).ok_or(cut)?);
    if version != VERSION {
        let version = excerpt(&version);
        return Err(format!("a checkpoint of dempfv {version}; this is dempfv {VERSION}"));
    }
    match (rest.len() as u64).cmp(&length) {
        std::cmp::Ordering::Less => {
            Err(format!("{cut}: {} bytes of state where {length} are due", rest.len()))
        }
        std::cmp::Ordering::Greater => Err("the checkpoint has bytes after its end".into()),
        std::cmp::Ordering::Equal if crc32fast::hash(rest) != checksum => {
            Err("the checkpoint is damaged: its checksum does not match".into())
        }
        std::cmp::Ordering::Equal => Ok(rest),
    }
}

fn take<'a>(rest: &mut &'a [u8], n: usize) -> Option<&'a [u8]> {
    let (head, tail) = rest.split_at_checked(n)?;
    *rest = tail;
    Some(head)
}

fn take_u32(rest: &mut &[u8]) -> Option<u32> {
    take(rest, 4)?.try_into().ok().map(u32::from_le_bytes)
}

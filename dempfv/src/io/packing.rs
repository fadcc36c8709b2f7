//! Packing files: spheres as text, one per line.
//!
//! ```text
//! # anything after a hash is a comment, but for the box:
//! # box 0 0 0 0.1 0.1 0.1
//! 0.010 0.020 0.030 0.001
//! ```
//!
//! A line holds `x y z r` in metres. The box is `xmin ymin zmin xmax ymax
//! zmax`. Files that YADE's `export.text` writes load as they are.

use std::io::{self, Write};
use std::path::Path;

use super::atomic;
use crate::input::InputError;
use crate::io::error::Result;
use crate::{Aabb, Vec3};

const LINE_FORM: &str = "a line is `x y z r` in metres, separated by blanks";
const BOX_FORM: &str = "the form is `# box xmin ymin zmin xmax ymax zmax` in metres";

/// Spheres are numbered in 32 bits, walls and one number for none behind them.
const TOO_MANY: u64 = u32::MAX as u64 - 8;

/// The spheres of a packing file, in the file's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packing {
    /// Centres (m).
    pub position: Vec<Vec3>,
    /// Radii (m), all positive.
    pub radius: Vec<f64>,
    /// Line of the file that each sphere stands on, counted from 1.
    pub line: Vec<usize>,
    /// The box that the file states, if it does.
    pub bounds: Option<Aabb>,
}

impl Packing {
    /// Reads a packing file.
    ///
    /// # Errors
    /// [`InputError`] with file and line: the file is missing or unreadable, a
    /// line has not four numbers, a number is not finite, a radius is not
    /// positive, the box is malformed, there is no sphere.
    pub fn read(path: &Path) -> Result<Packing, InputError> {
        let bytes = std::fs::read(path).map_err(|e| unreadable(path, &e))?;
        let text = std::str::from_utf8(&bytes).map_err(|e| {
            let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            InputError::new("not text", LINE_FORM).in_file(path).at_line(line)
        })?;
        Packing::parse(text).map_err(|e| e.in_file(path))
    }

    /// Reads the text of a packing file.
    ///
    /// ```
    /// use dempfv::io::packing::Packing;
    /// let packing = Packing::parse("# box 0 0 0 1 1 1\n.5 .5 .5 .1\n")?;
    /// assert_eq!(packing.len(), 1);
    /// assert_eq!(packing.bounds.unwrap().volume(), 1.0);
    /// let error = Packing::parse(".5 .5 .5 .1\n.5 .5 .5 -1\n").unwrap_err();
    /// assert_eq!(error.line, Some(2));
    /// # Ok::<(), dempfv::InputError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Packing::read`], without the file's name.
    pub fn parse(text: &str) -> Result<Packing, InputError> {
        let mut packing = Packing::default();
        for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            packing.add_line(line, i + 1).map_err(|e| e.at_line(i + 1))?;
        }
        if packing.is_empty() {
            return Err(InputError::new("the packing has no sphere", LINE_FORM));
        }
        Ok(packing)
    }

    fn add_line(&mut self, line: &str, number: usize) -> Result<(), InputError> {
        let (values, comment) = line.split_once('#').unwrap_or((line, ""));
        let mut words = comment.split_whitespace();
        if words.next() == Some("box") {
            self.add_box(words)?;
        }
        if values.trim().is_empty() {
            return Ok(());
        }
        let [x, y, z, r] = numbers(values.split_whitespace(), LINE_FORM)?;
        if r <= 0.0 {
            return Err(InputError::new(
                format!("the radius is {r}"),
                "a radius is the fourth column and positive",
            ));
        }
        self.position.push(Vec3::new(x, y, z));
        self.radius.push(r);
        self.line.push(number);
        Ok(())
    }

    fn add_box<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), InputError> {
        let [x0, y0, z0, x1, y1, z1] = numbers(words, BOX_FORM)?;
        let bounds = Aabb { min: Vec3::new(x0, y0, z0), max: Vec3::new(x1, y1, z1) };
        if let Some(axis) = (0..3).find(|&a| bounds.max[a] <= bounds.min[a]) {
            let name = ["x", "y", "z"][axis];
            let what = format!(
                "the box's {name}max ({}) is not above its {name}min ({})",
                bounds.max[axis], bounds.min[axis]
            );
            return Err(InputError::new(what, BOX_FORM));
        }
        if self.bounds.is_some_and(|b| b != bounds) {
            return Err(InputError::new("a second, different box", "keep one `# box` line"));
        }
        self.bounds = Some(bounds);
        Ok(())
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.radius.len()
    }

    /// True when there is no sphere.
    pub fn is_empty(&self) -> bool {
        self.radius.is_empty()
    }

    /// The box that the file states, else the tight box of the spheres;
    /// `None` when there is neither.
    pub fn bounds_or_tight(&self) -> Option<Aabb> {
        self.bounds.or_else(|| Aabb::of_spheres(&self.position, &self.radius))
    }

    /// Copies side by side, so many along each axis, in the box that holds them all.
    ///
    /// The first spheres are those of the packing itself; copies follow along x, then y,
    /// then z. Spheres that press into a wall of the packing come to press into those
    /// behind it, by no more than both press into the wall.
    ///
    /// ```
    /// use dempfv::io::packing::Packing;
    /// let one = Packing::parse("# box 0 0 0 1 1 2\n.5 .5 .5 .1\n")?;
    /// let four = one.tiled([2, 1, 2])?;
    /// assert_eq!((four.len(), four.bounds.unwrap().volume()), (4, 8.0));
    /// assert_eq!(four.position[3].as_slice(), [1.5, 0.5, 2.5]);
    /// # Ok::<(), dempfv::InputError>(())
    /// ```
    ///
    /// # Errors
    /// A number of copies is 0, or there are more spheres than fit 32-bit numbers.
    pub fn tiled(&self, copies: [u32; 3]) -> Result<Packing, InputError> {
        let count =
            copies.iter().map(|&n| u64::from(n)).try_fold(self.len() as u64, u64::checked_mul);
        let [nx, ny, nz] = copies;
        let (Some(1..=TOO_MANY), Some(bounds)) = (count, self.bounds_or_tight()) else {
            let what =
                format!("{nx} × {ny} × {nz} copies of {} spheres make no packing", self.len());
            return Err(InputError::new(what, format!("give one sphere to {TOO_MANY} in all")));
        };
        let mut tiled = Packing::default();
        let size = bounds.size();
        for (i, j, k) in
            (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j, k))))
        {
            let shift = size.component_mul(&Vec3::new(i.into(), j.into(), k.into()));
            tiled.position.extend(self.position.iter().map(|x| x + shift));
            tiled.radius.extend(&self.radius);
            tiled.line.extend(&self.line);
        }
        let copies = Vec3::new(nx.into(), ny.into(), nz.into());
        tiled.bounds =
            Some(Aabb { min: bounds.min, max: bounds.min + size.component_mul(&copies) });
        Ok(tiled)
    }
}

/// Writes a packing file that reads back to the same bits. Each line of
/// `comment` becomes a comment line at its head.
///
/// # Errors
/// [`IoError::File`](crate::io::IoError::File) when the file cannot be written; nothing partial
/// remains.
pub fn write(
    path: &Path,
    position: &[Vec3],
    radius: &[f64],
    bounds: Option<&Aabb>,
    comment: &str,
) -> Result<()> {
    debug_assert_eq!(position.len(), radius.len());
    atomic::write_with(path, |out| write_to(out, position, radius, bounds, comment))
}

fn write_to(
    out: &mut impl Write,
    position: &[Vec3],
    radius: &[f64],
    bounds: Option<&Aabb>,
    comment: &str,
) -> io::Result<()> {
    for line in comment.lines() {
        writeln!(out, "# {line}")?;
    }
    // `{:?}` prints the shortest decimals that read back to the same bits.
    if let Some(Aabb { min, max }) = bounds {
        write!(out, "# box {:?} {:?} {:?} ", min.x, min.y, min.z)?;
        writeln!(out, "{:?} {:?} {:?}", max.x, max.y, max.z)?;
    }
    writeln!(out, "# x y z r")?;
    for (x, r) in position.iter().zip(radius) {
        writeln!(out, "{:?} {:?} {:?} {r:?}", x.x, x.y, x.z)?;
    }
    Ok(())
}

/// Exactly `N` finite numbers.
fn numbers<'a, const N: usize>(
    words: impl Iterator<Item = &'a str>,
    form: &str,
) -> Result<[f64; N], InputError> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in words {
        if let Some(value) = values.get_mut(count) {
            *value = number(word, form)?;
        }
        count += 1;
    }
    if count != N {
        return Err(InputError::new(format!("{count} columns where {N} are due"), form));
    }
    Ok(values)
}

fn number(word: &str, form: &str) -> Result<f64, InputError> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(InputError::new(format!("`{word}` is not a finite number"), form)),
        Err(_) => Err(InputError::new(format!("`{word}` is not a number"), form)),
    }
}

fn unreadable(path: &Path, error: &io::Error) -> InputError {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let (what, remedy) = match (error.kind(), folder) {
        (io::ErrorKind::NotFound, Some(folder)) if !folder.is_dir() => (
            format!("no such packing file: there is no folder {}", folder.display()),
            "give the path of an existing packing, or make one with `dempfv pack`",
        ),
        (io::ErrorKind::NotFound, _) => (
            "no such packing file".to_owned(),
            "give the path of an existing packing, or make one with `dempfv pack`",
        ),
        _ => (format!("the packing cannot be read: {error}"), "give a readable text file"),
    };
    InputError::new(what, remedy).in_file(path)
}

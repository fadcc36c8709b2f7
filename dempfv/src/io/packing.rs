//! Packing files: spheres as text, one per line.
//!
//! ```text
//! # anything after a hash is a comment, but for the box:
//! # box 0 0 0 0.1 0.1 0.1
//! 0.010 0.020 0.030 0.001
//! ```
//!
//! A packing of a periodic cell has its three edges in the place of the box,
//! `# cell ax ay az bx by bz cx cy cz`, and any copy of each sphere.
//!
//! A line holds `x y z r` in metres. The box is `xmin ymin zmin xmax ymax
//! zmax`. Files that others write load as they are: YADE's `export.text`, `textExt` and
//! `SpherePack.save`, Woo's sphere lists, tables with a line of column names (CSV), and dumps of
//! LAMMPS, whose last snapshot and box are taken. Clumps are the spheres that they consist of. Of a
//! checkpoint of a run, the spheres are taken with their box or cell, at rest.

use std::io::{self, Write};
use std::path::Path;

use super::atomic;
use super::checkpoint::Spheres;
use super::number::number;
use super::packing_layout::{LINE_FORM, Layout, is_header, words};
use crate::input::InputError;
use crate::io::error::Result;
use crate::{Aabb, Cell, Vec3};

const BOX_FORM: &str = "the form is `# box xmin ymin zmin xmax ymax zmax` in metres";

const CELL_FORM: &str = "the form is `# cell ax ay az bx by bz cx cy cz` in metres";

/// Spheres are numbered in 32 bits, walls and one number for none behind them.
const TOO_MANY: u64 = u32::MAX as u64 - 8;

/// The spheres of a packing file, in the file's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packing {
    /// Centres (m).
    pub position: Vec<Vec3>,
    /// Radii (m), all positive.
    pub radius: Vec<f64>,
    /// Line of the file that each sphere stands on, counted from 1; empty for a checkpoint.
    pub line: Vec<usize>,
    /// The box that the file states, if it does.
    pub bounds: Option<Aabb>,
    /// The periodic cell that the file states, if it does.
    pub cell: Option<Cell>,
}

impl Packing {
    /// Reads a packing file, or the spheres of a run's checkpoint.
    ///
    /// # Errors
    /// [`InputError`] with file and line: the file is missing or unreadable, a
    /// line has not four numbers, a number is not finite, a radius is not
    /// positive, the box is malformed, there is no sphere.
    pub fn read(path: &Path) -> Result<Packing, InputError> {
        let bytes = std::fs::read(path).map_err(|e| unreadable(path, &e))?;
        if let Some(spheres) = Spheres::of_bytes(&bytes) {
            return spheres.and_then(Packing::of).map_err(|e| e.in_file(path));
        }
        let text = std::str::from_utf8(&bytes).map_err(|e| {
            let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            InputError::new("not text", LINE_FORM).in_file(path).at_line(line)
        })?;
        Packing::parse(text).map_err(|e| e.in_file(path))
    }

    /// The spheres of a checkpoint.
    fn of(spheres: Spheres) -> Result<Packing, InputError> {
        let Spheres { position, radius, bounds, cell, .. } = spheres;
        let numbers = position.iter().flatten().chain(&radius);
        let sound = numbers.into_iter().all(|x| x.is_finite()) && radius.iter().all(|r| *r > 0.0);
        if position.len() != radius.len() || !sound {
            let what = "the checkpoint's spheres are none: a number is missing, not finite or not positive";
            return Err(InputError::new(what, "take a checkpoint that this program wrote"));
        }
        Ok(Packing { position, radius, line: vec![], bounds, cell })
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
        let mut reader = Reader::default();
        for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            reader.read(line, i + 1).map_err(|e| e.at_line(i + 1))?;
        }
        let packing = reader.packing;
        if packing.is_empty() {
            return Err(InputError::new("the packing has no sphere", LINE_FORM));
        }
        Ok(packing)
    }

    fn add_sphere(&mut self, [x, y, z, r]: [f64; 4], line: usize) -> Result<(), InputError> {
        if r <= 0.0 {
            return Err(InputError::new(
                format!("the radius is {r}"),
                "a radius is the fourth column and positive",
            ));
        }
        self.position.push(Vec3::new(x, y, z));
        self.radius.push(r);
        self.line.push(line);
        Ok(())
    }

    fn add_box(&mut self, [x0, y0, z0, x1, y1, z1]: [f64; 6]) -> Result<(), InputError> {
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

    fn add_cell(&mut self, numbers: [f64; 9]) -> Result<(), InputError> {
        let [a, b, c] = [0, 3, 6].map(|k| Vec3::from_row_slice(&numbers[k..k + 3]));
        let cell = Cell::new([a, b, c]);
        let cell = cell.map_err(|error| InputError::new(error.to_string(), CELL_FORM))?;
        if self.cell.is_some_and(|known| known != cell) {
            return Err(InputError::new("a second, different cell", "keep one `# cell` line"));
        }
        self.cell = Some(cell);
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
    /// A number of copies is 0, there are more spheres than fit 32-bit numbers or memory, the
    /// copies reach beyond double precision, or the packing is none ([`write()`] has the rules).
    pub fn tiled(&self, copies: [u32; 3]) -> Result<Packing, InputError> {
        check(&self.position, &self.radius, self.bounds.as_ref())?;
        let count =
            copies.iter().map(|&n| u64::from(n)).try_fold(self.len() as u64, u64::checked_mul);
        let [nx, ny, nz] = copies;
        let (Some(1..=TOO_MANY), Some(bounds)) = (count, self.bounds_or_tight()) else {
            return Err(self.no_tiling(copies, &format!("give one sphere to {TOO_MANY} in all")));
        };
        let mut tiled = Packing::default();
        let size = bounds.size();
        let high = bounds.min + size.component_mul(&Vec3::from(copies.map(f64::from)));
        if !high.iter().all(|x| x.is_finite()) {
            return Err(self.no_tiling(copies, "give a smaller box, or another unit of length"));
        }
        let total = count.unwrap_or_default() as usize;
        let reserved = tiled.position.try_reserve_exact(total).is_ok()
            && tiled.radius.try_reserve_exact(total).is_ok()
            && tiled.line.try_reserve_exact(total).is_ok();
        if !reserved {
            return Err(self.no_tiling(copies, "there is no memory for so many; give fewer copies"));
        }
        for (i, j, k) in
            (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j, k))))
        {
            let shift = size.component_mul(&Vec3::new(i.into(), j.into(), k.into()));
            tiled.position.extend(self.position.iter().map(|x| x + shift));
            tiled.radius.extend(&self.radius);
            tiled.line.extend(&self.line);
        }
        tiled.bounds = Some(Aabb { min: bounds.min, max: high });
        Ok(tiled)
    }

    fn no_tiling(&self, [nx, ny, nz]: [u32; 3], remedy: &str) -> InputError {
        let spheres = self.len();
        let what = format!("{nx} × {ny} × {nz} copies of {spheres} spheres make no packing");
        InputError::new(what, remedy)
    }
}

/// What the next line of a LAMMPS dump is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Item {
    /// A sphere, as in any other file.
    Atoms,
    /// Nothing that counts here.
    Other,
    /// The bounds along an axis.
    Bounds(usize),
}

/// Reads a packing line by line.
struct Reader {
    packing: Packing,
    layout: Option<Layout>,
    item: Item,
    /// Bounds of a dump so far.
    bounds: [f64; 6],
}

impl Default for Reader {
    fn default() -> Reader {
        let packing = Packing::default();
        Reader { packing, layout: None, item: Item::Atoms, bounds: [0.0; 6] }
    }
}

impl Reader {
    fn read(&mut self, line: &str, number: usize) -> Result<(), InputError> {
        if let Some(item) = line.strip_prefix("ITEM:") {
            return self.begin_item(item);
        }
        let (values, comment) = line.split_once('#').unwrap_or((line, ""));
        self.read_comment(comment)?;
        let words = words(values.trim());
        match self.item {
            _ if values.trim().is_empty() => Ok(()),
            Item::Other => Ok(()),
            Item::Bounds(axis) => self.read_bounds(axis, &words),
            Item::Atoms if self.layout.is_none() && is_header(&words) => {
                self.layout = Some(Layout::named(&words)?);
                Ok(())
            }
            Item::Atoms => {
                let layout = self.layout.get_or_insert_with(|| Layout::of_line(&words));
                self.packing.add_sphere(layout.read(&words)?, number)
            }
        }
    }

    fn read_comment(&mut self, comment: &str) -> Result<(), InputError> {
        if comment.starts_with("#PERIODIC") {
            return Err(InputError::new(
                "a periodic packing: its spheres reach past the cell's faces",
                "fill a box with walls, or take this line out and the spheres that reach past the box",
            ));
        }
        let mut words = comment.split_whitespace();
        match words.next() {
            Some("format") => {
                self.layout = words.next().and_then(Layout::of_format);
                Ok(())
            }
            // Other comments begin with the word, too.
            Some("cell") if words.clone().next().is_some_and(|w| w.parse::<f64>().is_ok()) => {
                self.packing.add_cell(numbers(words, CELL_FORM)?)
            }
            Some(word) if is_box(word) => self.packing.add_box(numbers(words, BOX_FORM)?),
            _ => Ok(()),
        }
    }

    /// A section of a dump begins.
    fn begin_item(&mut self, item: &str) -> Result<(), InputError> {
        let words: Vec<&str> = item.split_whitespace().collect();
        self.item = match words[..] {
            ["ATOMS", ref names @ ..] => {
                self.layout = Some(Layout::named(names)?);
                Item::Atoms
            }
            ["BOX", "BOUNDS", "xy", ..] => {
                let what = "a triclinic box: its walls are not along the axes";
                return Err(InputError::new(what, "dump a box that is not tilted"));
            }
            ["BOX", "BOUNDS", ..] => Item::Bounds(0),
            ["TIMESTEP"] => {
                // The last snapshot counts.
                self.packing = Packing::default();
                Item::Other
            }
            _ => Item::Other,
        };
        Ok(())
    }

    fn read_bounds(&mut self, axis: usize, words: &[&str]) -> Result<(), InputError> {
        let form = "the bounds of an axis are two numbers";
        let [low, high] = numbers(words.iter().copied(), form)?;
        (self.bounds[axis], self.bounds[axis + 3]) = (low, high);
        self.item = if axis < 2 { Item::Bounds(axis + 1) } else { Item::Other };
        if axis == 2 { self.packing.add_box(self.bounds) } else { Ok(()) }
    }
}

/// Whether a comment's first word announces the box: `box`, in any case, with a colon or an equals
/// sign.
fn is_box(word: &str) -> bool {
    word.trim_end_matches([':', '=']).eq_ignore_ascii_case("box")
}

/// Writes a packing file that reads back to the same bits. Each line of
/// `comment` becomes a comment line at its head.
///
/// # Errors
/// [`IoError::File`](crate::io::IoError::File) when the file cannot be written; nothing partial
/// remains. An [`InputError`] for what would not read back: arrays of different lengths or
/// without a sphere, numbers that are not finite, a radius that is not positive, an inverted box.
pub fn write(
    path: &Path,
    position: &[Vec3],
    radius: &[f64],
    bounds: Option<&Aabb>,
    comment: &str,
) -> Result<()> {
    check(position, radius, bounds)?;
    atomic::write_with(path, |out| write_to(out, position, radius, bounds, comment))
}

/// Writes the packing of a periodic cell, with its edges as a comment that is read back to the same
/// bits.
///
/// # Errors
/// As [`write()`].
pub fn write_in_cell(
    path: &Path,
    position: &[Vec3],
    radius: &[f64],
    cell: &Cell,
    comment: &str,
) -> Result<()> {
    let edges = cell.edges().map(|e| format!("{:?} {:?} {:?}", e.x, e.y, e.z));
    let lines: Vec<&str> = comment.lines().collect();
    let edges = format!("cell {}", edges.join(" "));
    let comment = [lines, vec![edges.as_str()]].concat().join("\n");
    write(path, position, radius, None, &comment)
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

/// Refuses what is no packing, or would be none when it is read again.
fn check(position: &[Vec3], radius: &[f64], bounds: Option<&Aabb>) -> Result<(), InputError> {
    if position.is_empty() || position.len() != radius.len() {
        let what =
            format!("`position` has {} entries and `radius` {}", position.len(), radius.len());
        return Err(InputError::new(what, "give one of each for every sphere, and one sphere"));
    }
    if let Some(i) = position.iter().position(|x| !x.iter().all(|c| c.is_finite())) {
        return Err(InputError::new(format!("`position` {i} is not finite"), "give numbers in m"));
    }
    if let Some(i) = radius.iter().position(|r| !(*r > 0.0 && r.is_finite())) {
        let what = format!("`radius` {i} is {}", radius[i]);
        return Err(InputError::new(what, "give a radius above 0 in m"));
    }
    let is_box =
        |b: &Aabb| (0..3).all(|k| b.min[k] < b.max[k] && (b.max[k] - b.min[k]).is_finite());
    match bounds.filter(|b| !is_box(b)) {
        None => Ok(()),
        Some(b) => {
            let what =
                format!("`bounds` from {} to {} is no box", b.min.transpose(), b.max.transpose());
            Err(InputError::new(what, "give finite corners, the larger one last"))
        }
    }
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

//! Pictures: the same drawing as SVG and as PNG, without any font or library
//! of the machine.

pub mod axis;
mod chart;
pub mod color;
mod consolidation;
mod panel;
pub mod picture;
mod png;
pub mod section;
mod svg;
pub mod text;

use std::path::Path;

use dempfv::io::atomic;

pub use axis::Axis;
pub use chart::{row, xy};
pub use color::SERIES;
pub use consolidation::{Consolidation, Layers, Profile, consolidation, profiles};
pub use panel::{Mark, Panel, Series};
pub use picture::Picture;
pub use section::{Section, section};

impl Picture {
    /// The drawing as SVG, to stand in a page.
    pub fn to_svg(&self) -> String {
        svg::render(self)
    }

    /// Writes `NAME.svg` and `NAME.png` into a folder.
    ///
    /// # Errors
    /// [`dempfv::Error::Io`] when a file cannot be written; nothing partial
    /// remains.
    pub fn save(&self, folder: &Path, name: &str) -> dempfv::Result<()> {
        atomic::write(&folder.join(format!("{name}.svg")), svg::render(self).as_bytes())?;
        let path = folder.join(format!("{name}.png"));
        let bytes = png::render(self).ok_or_else(|| {
            dempfv::Error::io(&path, std::io::Error::other("the picture is too large"))
        })?;
        Ok(atomic::write(&path, &bytes)?)
    }
}

//! Plots as pixels, for what cannot show SVG.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, fontdb};
use std::sync::Arc;

/// Pixels for one of the plot's own units: 300 dpi at the size of a printed column.
const SCALE: f32 = 3.0;

/// Turns plots into PNG files with the fonts of this machine.
pub struct Painter {
    options: usvg::Options<'static>,
}

impl Painter {
    /// Looks for a font.
    ///
    /// # Errors
    /// When there is none: the plots would have no text.
    pub fn new() -> Result<Self, String> {
        const USUAL: [&str; 6] = ["DejaVu Sans", "Liberation Sans", "Noto Sans", "Arial", "Helvetica", "Segoe UI"];
        let mut fonts = fontdb::Database::new();
        fonts.load_system_fonts();
        let has = |family: &str| {
            let mut families = fonts.faces().flat_map(|face| &face.families);
            families.any(|(name, _)| name == family)
        };
        let usual = USUAL.into_iter().find(|family| has(family));
        let any = || Some(fonts.faces().next()?.families.first()?.0.clone());
        let family = usual
            .map(str::to_owned)
            .or_else(any)
            .ok_or("PNG files need a font, and none is installed; install one such as fonts-dejavu-core")?;
        fonts.set_sans_serif_family(family.as_str());
        let options = usvg::Options { font_family: family, fontdb: Arc::new(fonts), ..usvg::Options::default() };
        Ok(Self { options })
    }

    /// The PNG file of a plot.
    ///
    /// # Errors
    /// When the plot is no SVG, or there is no memory for its pixels.
    pub fn png(&self, svg: &str) -> Result<Vec<u8>, String> {
        let tree = usvg::Tree::from_str(svg, &self.options).map_err(|e| e.to_string())?;
        let size = tree.size().to_int_size().scale_by(SCALE);
        let size = size.ok_or("the plot has no size")?;
        let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the plot is too large")?;
        resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
        pixels.encode_png().map_err(|e| e.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::{Frame, plain};

    #[test]
    fn a_plot_becomes_pixels_with_its_colours() {
        let frame = Frame::new(100.0, 80.0, [0.0, 1.0], [0.0, 1.0]);
        let plot = frame.wrap("a bar", "<path class=\"bar solid in\" d=\"M20,20H80V60H20z\"/>");
        // The fonts are not looked for: this plot has no text.
        let painter = Painter { options: usvg::Options::default() };
        let file = painter.png(&plain(&plot)).unwrap();
        let pixels = Pixmap::decode_png(&file).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (300, 240));
        let colour = |x, y| pixels.pixel(x, y).unwrap().demultiply();
        let (paper, bar) = (colour(10, 10), colour(150, 120));
        assert_eq!((paper.red(), paper.green(), paper.blue()), (255, 255, 255));
        // #0063a8 at 90 %.
        assert!(bar.red() < 40 && bar.blue() > 160, "{bar:?}");
    }
}

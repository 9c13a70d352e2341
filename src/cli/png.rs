//! Pictures as PNG, drawn from their SVG. Only with the feature `png`: the rasteriser takes a minute of the build.

/// Pixels per unit of a picture: plots stay sharp in print and on dense screens.
const SCALE: f32 = 2.0;

/// Fonts without serifs of the usual systems, in the order of preference.
const FONTS: [&str; 6] = ["DejaVu Sans", "Arial", "Helvetica", "Liberation Sans", "Noto Sans", "Segoe UI"];

/// Draws a picture with twice its size in pixels.
///
/// # Errors
/// A message if no font is installed.
pub(super) fn render(svg: &str) -> Result<Vec<u8>, String> {
    use resvg::tiny_skia::{Color, Pixmap, Transform};
    use resvg::usvg::{Options, Tree};

    let mut options = Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_system_fonts();
    let family = |face: &resvg::usvg::fontdb::FaceInfo| face.families.first().map(|(name, _)| name.clone());
    let installed: Vec<String> = fonts.faces().filter_map(family).collect();
    let preferred = FONTS.into_iter().find(|name| installed.iter().any(|each| each == name));
    let Some(sans_serif) = preferred.or(installed.first().map(String::as_str)) else {
        return Err("no font is installed, so the texts of a PNG cannot be drawn; install one (such as the package \
                    fonts-dejavu), or write an .svg"
            .to_string());
    };
    fonts.set_sans_serif_family(sans_serif);
    let tree = Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|length| (SCALE * length).ceil() as u32);
    let mut pixels = Pixmap::new(width, height).ok_or("the picture is empty")?;
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use resvg::tiny_skia::Pixmap;

    /// Pixels that are not white, of a picture of 60 by 20 units.
    fn inked(content: &str) -> usize {
        let svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"60\" height=\"20\">{content}</svg>");
        let pixels = Pixmap::decode_png(&render(&svg).expect("a picture")).expect("a PNG");
        assert_eq!((pixels.width(), pixels.height()), (120, 40));
        pixels.pixels().iter().filter(|pixel| pixel.red() < 128).count()
    }

    #[test]
    fn shapes_and_texts_are_drawn_on_white() {
        assert_eq!(inked(""), 0);
        assert_eq!(inked("<rect x=\"10\" y=\"5\" width=\"20\" height=\"10\"/>"), 40 * 20);
        let text = inked("<text x=\"5\" y=\"15\" font-family=\"sans-serif\" font-size=\"11\">held</text>");
        assert!((100..700).contains(&text), "{text} pixels");
    }
}

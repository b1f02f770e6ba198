//! [`Canvas`]: coloured pixels, what is drawn on them, and the PNG that they become.

use super::font;

/// A colour: red, green, blue, as sRGB has them.
pub type Rgb = [u8; 3];

/// `width` × `height` pixels, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
}

impl Canvas {
    /// Of one colour.
    pub fn new(width: usize, height: usize, colour: Rgb) -> Canvas {
        Canvas { width, height, pixels: vec![colour; width * height] }
    }

    /// Of these pixels, which fill whole rows; what is missing of the last is black.
    pub fn of(width: usize, mut pixels: Vec<Rgb>) -> Canvas {
        let height = pixels.len().div_ceil(width.max(1));
        pixels.resize(width * height, [0; 3]);
        Canvas { width, height, pixels }
    }

    /// Pixels across.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// The colour at a place on it.
    pub fn get(&self, x: usize, y: usize) -> Rgb {
        self.pixels[y * self.width + x]
    }

    /// Colour one pixel, the more of `opacity` the less of what was there. Outside there is nothing to colour.
    pub fn blend(&mut self, x: i64, y: i64, colour: Rgb, opacity: f64) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y * self.width + x];
            // Most of what is drawn hides what was there.
            *pixel = if opacity >= 1.0 { colour } else { mix(*pixel, colour, opacity) };
        }
    }

    /// Fill a rectangle.
    pub fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2], colour: Rgb) {
        for row in y..(y + height).min(self.height) {
            let row = row * self.width;
            self.pixels[row + x.min(self.width)..row + (x + width).min(self.width)].fill(colour);
        }
    }

    /// Put another canvas on this one, its upper left corner at `x`, `y`; what does not fit is left out.
    pub fn put(&mut self, [x, y]: [usize; 2], other: &Canvas) {
        let across = other.width.min(self.width.saturating_sub(x));
        if across == 0 {
            return;
        }
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let (from, to) = (row * other.width, (y + row) * self.width + x);
            self.pixels[to..to + across].copy_from_slice(&other.pixels[from..from + across]);
        }
    }

    /// Write a line of text with its upper left corner at `x`, `y`, each of a letter's pixels `size` wide.
    pub fn text(&mut self, [x, y]: [usize; 2], size: usize, text: &str, colour: Rgb) {
        for [column, row] in letters(text) {
            self.fill([x + column * size, y + row * size], [size, size], colour);
        }
    }

    /// The mean of each `by` × `by` pixels: what was drawn `by` times too large becomes smooth. Rows and columns that fill no square are left out.
    pub fn shrunk(&self, by: usize) -> Canvas {
        if by <= 1 {
            return self.clone();
        }
        let (width, height) = (self.width / by, self.height / by);
        let mut pixels = Vec::with_capacity(width * height);
        let mut sums = vec![[0u32; 3]; width];
        for y in 0..height {
            sums.fill([0; 3]);
            for row in self.pixels[y * by * self.width..].chunks_exact(self.width.max(1)).take(by) {
                for (sum, square) in sums.iter_mut().zip(row.chunks_exact(by)) {
                    square.iter().for_each(|rgb| [0, 1, 2].iter().for_each(|c: &usize| sum[*c] += u32::from(rgb[*c])));
                }
            }
            pixels.extend(sums.iter().map(|sum| sum.map(|c| (c / (by * by) as u32) as u8)));
        }
        Canvas { width, height, pixels }
    }

    /// As a PNG file. The same pixels make the same bytes.
    ///
    /// # Errors
    /// Where a side is 0 or more than PNG can have.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let side = |n: usize| u32::try_from(n).unwrap_or(0);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, side(self.width), side(self.height));
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Balanced);
        encoder.add_text_chunk("Software".into(), "bvhc".into())?;
        encoder.write_header()?.write_image_data(self.pixels.as_flattened())?;
        Ok(bytes)
    }
}

/// The pixels of a line of text, column and row from its upper left corner.
pub(in crate::report) fn letters(text: &str) -> impl Iterator<Item = [usize; 2]> {
    text.chars().enumerate().flat_map(|(i, letter)| {
        font::rows(letter).enumerate().flat_map(move |(row, bits)| {
            let inked = bits.bytes().enumerate().filter(|(_, bit)| *bit == b'#');
            inked.map(move |(column, _)| [i * font::ADVANCE + column, row])
        })
    })
}

/// How wide a line of text is, in pixels.
pub(in crate::report) fn text_width(text: &str, size: usize) -> usize {
    text.chars().count() * font::ADVANCE * size
}

/// How high a line of text is, in pixels.
pub(in crate::report) fn text_height(size: usize) -> usize {
    font::HEIGHT * size
}

/// From one colour to another, `share` of the way.
pub(super) fn mix(from: Rgb, to: Rgb, share: f64) -> Rgb {
    [0, 1, 2].map(|c| {
        let (a, b) = (f64::from(from[c]), f64::from(to[c]));
        (a + (b - a) * share.clamp(0.0, 1.0)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_is_read_back_as_it_was_drawn() {
        let mut canvas = Canvas::new(40, 12, [9, 8, 7]);
        canvas.text([1, 1], 1, "a 7?", [255, 0, 0]);
        canvas.blend(39, 11, [200, 200, 200], 0.5);
        canvas.blend(-1, 40, [1, 1, 1], 1.0);
        canvas.put([38, 0], &Canvas::new(9, 2, [1, 2, 3]));
        let bytes = canvas.png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height, &pixels[..]), (40, 12, canvas.pixels.as_flattened()));
        assert_eq!((canvas.get(39, 11), canvas.get(39, 1)), ([105, 104, 104], [1, 2, 3]));
        assert!(canvas.pixels.contains(&[255, 0, 0]));
    }

    #[test]
    fn shrinking_takes_means() {
        let canvas = Canvas::of(4, vec![[0; 3], [100; 3], [7; 3], [9; 3], [0; 3], [100; 3], [7; 3], [9; 3]]);
        assert_eq!(canvas.shrunk(2), Canvas::of(2, vec![[50; 3], [8; 3]]));
        assert_eq!(canvas.shrunk(1), canvas);
    }
}

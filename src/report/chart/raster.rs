//! Charts in pixels: the pen's shapes on a [`Canvas`], drawn four times too large and made half as large, so that lines are smooth. Letters are the canvas's
//! own, since no font need be installed.

use crate::report::picture::{Canvas, letters, text_height, text_width};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind};
use std::convert::Infallible;

/// Pixels that are drawn for each unit of a chart, across and down.
const FINE: i32 = 4;
/// Of which so many become one.
const MEAN: usize = 2;

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// Where the pen draws in the units of a chart.
pub(super) struct Raster<'a> {
    size: (u32, u32),
    fine: &'a mut Fine,
}

/// The pixels themselves; shapes are put together from these by the pen.
pub(super) struct Fine(Canvas);

impl Fine {
    pub fn new((width, height): (u32, u32)) -> Fine {
        Fine(Canvas::new(width as usize * FINE as usize, height as usize * FINE as usize, [255; 3]))
    }

    /// What was drawn, at twice the size of a chart.
    pub fn smooth(&self) -> Canvas {
        self.0.shrunk(MEAN)
    }
}

impl<'a> Raster<'a> {
    pub fn new(size: (u32, u32), fine: &'a mut Fine) -> Raster<'a> {
        Raster { size, fine }
    }
}

impl DrawingBackend for Fine {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.0.width() as u32, self.0.height() as u32)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        let (red, green, blue) = colour.rgb;
        self.0.blend(x.into(), y.into(), [red, green, blue], colour.alpha);
        Ok(())
    }

    /// The largest shapes are filled row by row: the ground alone is most of the pixels.
    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Drawn {
        let colour = style.color();
        if !fill || colour.alpha < 1.0 {
            return plotters_backend::rasterizer::draw_rect(self, from, to, style, fill);
        }
        // Both corners are within.
        let side = |a: i32, b: i32| (a.min(b).max(0) as usize, (a.max(b) + 1).max(0) as usize);
        let ((left, right), (top, bottom)) = (side(from.0, to.0), side(from.1, to.1));
        let (red, green, blue) = colour.rgb;
        self.0.fill([left, top], [right - left, bottom - top], [red, green, blue]);
        Ok(())
    }
}

/// A style whose lines are wider.
struct Wide<'a, S>(&'a S);

impl<S: BackendStyle> BackendStyle for Wide<'_, S> {
    fn color(&self) -> BackendColor {
        self.0.color()
    }

    fn stroke_width(&self) -> u32 {
        self.0.stroke_width() * FINE as u32
    }
}

/// The middle of a unit in pixels.
fn scaled((x, y): BackendCoord) -> BackendCoord {
    (x * FINE + FINE / 2, y * FINE + FINE / 2)
}

impl DrawingBackend for Raster<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        let corner = |x, y| (x * FINE, y * FINE);
        let (left, top) = corner(x, y);
        self.fine.draw_rect((left, top), (left + FINE - 1, top + FINE - 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.fine.draw_path([scaled(from), scaled(to)], &Wide(style))
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Drawn {
        self.fine.draw_rect(scaled(from), scaled(to), &Wide(style), fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        self.fine.draw_path(path.into_iter().map(scaled), &Wide(style))
    }

    fn draw_circle<S: BackendStyle>(&mut self, at: BackendCoord, radius: u32, style: &S, fill: bool) -> Drawn {
        self.fine.draw_circle(scaled(at), radius * FINE as u32, &Wide(style), fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, corners: I, style: &S) -> Drawn {
        self.fine.fill_polygon(corners.into_iter().map(scaled), style)
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, at: BackendCoord) -> Drawn {
        let (wide, high) = (text_width(text, FINE as usize) as i32, text_height(FINE as usize) as i32);
        let left = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => -wide / 2,
            HPos::Right => -wide,
        };
        let top = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -high / 2,
            VPos::Bottom => -high,
        };
        let (turn, (x, y)) = (style.transform(), scaled(at));
        for [column, row] in letters(text) {
            for (across, down) in (0..FINE).flat_map(|i| (0..FINE).map(move |j| (i, j))) {
                let point = (left + column as i32 * FINE + across, top + row as i32 * FINE + down);
                let (dx, dy) = turn.transform(point.0, point.1);
                self.fine.draw_pixel((x + dx, y + dy), style.color())?;
            }
        }
        Ok(())
    }

    fn estimate_text_size<T: BackendTextStyle>(
        &self,
        text: &str,
        _: &T,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        Ok((text_width(text, 1) as u32, text_height(1) as u32))
    }
}

#[cfg(test)]
mod tests {
    use crate::report::chart::{Axis, Chart, Panel, Point, Series};

    #[test]
    fn pixels_show_what_svg_shows() {
        let axis = || Axis::linear("x");
        let series = Series::new("a", 1, vec![Point::new(1.0, 1.0).named("one"), Point::new(2.0, 3.0)]).connected();
        let chart = Chart {
            title: "Title".into(),
            panels: vec![Panel::new("p", axis(), axis()).with(series)],
            columns: 1,
            ..Chart::default()
        };
        let canvas = chart.canvas().unwrap();
        let svg = chart.svg().unwrap();
        assert!(svg.contains(&format!("width=\"{}\" height=\"{}\"", canvas.width() / 2, canvas.height() / 2)), "{svg}");
        // The series' colour, at its marker and in the legend, and much white around.
        let red = |pixel: &&[u8; 3]| **pixel == [213, 94, 0];
        assert!(canvas.pixels().iter().filter(red).count() > 200);
        assert!(canvas.pixels().iter().filter(|pixel| **pixel == [255; 3]).count() * 2 > canvas.pixels().len());
        assert_eq!(chart.canvas().unwrap(), canvas);
    }
}

//! A picture as text, for terminals of every age.

use crate::report::picture::{Canvas, Rgb};
use std::fmt::Write;

/// What a terminal can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// 24 bits a colour.
    Full,
    /// The palette of 256.
    Palette,
    /// Letters alone, the denser the brighter.
    None,
}

impl Colours {
    /// As `COLORTERM` and `TERM` say, where colour is wanted at all.
    pub fn of(wanted: bool, variable: impl Fn(&str) -> Option<String>) -> Colours {
        let says = |name: &str, word: &str| variable(name).is_some_and(|value| value.contains(word));
        if !wanted {
            Colours::None
        } else if says("COLORTERM", "truecolor") || says("COLORTERM", "24bit") || says("TERM", "direct") {
            Colours::Full
        } else {
            Colours::Palette
        }
    }

    /// The picture, two rows of pixels a line. What is lit by a colour alone is a half block with one colour above and one below.
    pub fn text(self, canvas: &Canvas) -> String {
        let mut text = String::new();
        for top in (0..canvas.height()).step_by(2) {
            let mut before = None;
            for x in 0..canvas.width() {
                let above = canvas.get(x, top);
                let below = if top + 1 < canvas.height() { canvas.get(x, top + 1) } else { above };
                if self == Colours::None {
                    text.push(letter(above, below));
                    continue;
                }
                // A run of the same colours is told once.
                if before.replace((above, below)) != Some((above, below)) {
                    let _ = write!(text, "\x1b[38;{};48;{}m", self.code(above), self.code(below));
                }
                text.push('▀');
            }
            text.push_str(if self == Colours::None { "\n" } else { "\x1b[0m\n" });
        }
        text
    }

    fn code(self, [r, g, b]: Rgb) -> String {
        match self {
            Colours::Full => format!("2;{r};{g};{b}"),
            _ => format!("5;{}", palette([r, g, b])),
        }
    }
}

/// The nearest of the 216 colours of the palette's cube.
fn palette(rgb: Rgb) -> u8 {
    const STEPS: [u8; 6] = [0, 95, 135, 175, 215, 255];
    let nearest = rgb.map(|c| (0..6u8).min_by_key(|i| STEPS[usize::from(*i)].abs_diff(c)).unwrap_or(0));
    16 + 36 * nearest[0] + 6 * nearest[1] + nearest[2]
}

/// From empty to full.
const RAMP: &[u8] = b" .:-=+*#%@";

fn letter(above: Rgb, below: Rgb) -> char {
    let light = |[r, g, b]: Rgb| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
    let share = (light(above) + light(below)) / 510.0;
    char::from(RAMP[((share * RAMP.len() as f64) as usize).min(RAMP.len() - 1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_terminal_says_what_it_can() {
        let with = |color: &'static str, term: &'static str| {
            move |name: &str| Some(if name == "COLORTERM" { color } else { term }.to_string())
        };
        assert_eq!(Colours::of(true, with("truecolor", "xterm")), Colours::Full);
        assert_eq!(Colours::of(true, with("", "xterm-256color")), Colours::Palette);
        assert_eq!(Colours::of(false, with("truecolor", "xterm")), Colours::None);
        assert_eq!(Colours::of(true, |_| None), Colours::Palette);
    }

    #[test]
    fn two_rows_are_a_line_and_a_run_is_told_once() {
        let canvas = Canvas::of(2, vec![[0; 3], [0; 3], [255; 3], [255; 3], [255, 0, 0], [0; 3]]);
        assert_eq!(Colours::None.text(&canvas), "==\n: \n");
        let full = Colours::Full.text(&canvas);
        assert!(full.starts_with("\x1b[38;2;0;0;0;48;2;255;255;255m▀▀\x1b[0m\n"), "{full:?}");
        assert!(Colours::Palette.text(&canvas).contains("\x1b[38;5;196;48;5;196m▀"));
        assert_eq!([palette([0; 3]), palette([255; 3]), palette([100, 0, 0])], [16, 231, 52]);
    }
}

//! [`Scale`]: what the colours of a picture mean in numbers, and the strip that says so.

use super::canvas::{Canvas, Rgb, mix, text_height, text_width};

/// What is behind a scene, and behind a strip.
pub const BACKGROUND: Rgb = [24, 28, 36];
const INK: Rgb = [228, 230, 235];

/// Dark to bright: brighter is always more, also for eyes that see no hues.
const HEAT: [Rgb; 5] = [[8, 8, 32], [84, 22, 112], [196, 48, 88], [246, 146, 44], [255, 248, 186]];
/// Less, the same, more.
const SIGNED: [Rgb; 3] = [[36, 92, 204], [236, 236, 236], [204, 48, 36]];

/// From numbers to colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// What is counted, in words.
    pub title: String,
    /// What the last colour stands for; more has the same colour.
    pub most: f64,
    /// Whether the colours also stand for what is below 0, down to −`most`.
    pub signed: bool,
}

impl Scale {
    /// A scale that ends at the first of 1, 2, 5, 10, 20, 50 … that at most one in fifty of the sizes of `values` is above.
    pub fn over(title: &str, mut values: Vec<f64>, signed: bool) -> Scale {
        values.iter_mut().for_each(|v| *v = v.abs());
        values.sort_unstable_by(f64::total_cmp);
        let nearly_all = values.get((values.len() * 49 / 50).min(values.len().saturating_sub(1)));
        let (mut most, mut steps) = (1.0, [2.0, 2.5, 2.0].into_iter().cycle());
        while nearly_all.is_some_and(|v| *v > most && most < 1e12) {
            most *= steps.next().unwrap_or(2.0);
        }
        Scale { title: title.to_string(), most, signed }
    }

    /// The colour of a number.
    pub fn colour(&self, value: f64) -> Rgb {
        let share = if self.signed { 0.5 + 0.5 * value / self.most } else { value / self.most };
        let stops: &[Rgb] = if self.signed { &SIGNED } else { &HEAT };
        let place = share.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
        let stop = (place as usize).min(stops.len() - 2);
        mix(stops[stop], stops[stop + 1], place - stop as f64)
    }

    /// A strip of this width for under a picture: the title, the colours, and the numbers below them.
    pub fn strip(&self, width: usize) -> Canvas {
        let size = letter_size(width);
        let (line, margin) = (text_height(size), 4 * size);
        let mut strip = Canvas::new(width, 3 * line + 4 * margin, BACKGROUND);
        strip.text([margin, margin], size, &self.title, INK);
        let (top, across) = (2 * margin + line, width.saturating_sub(2 * margin).max(1));
        let value = |share: f64| if self.signed { (2.0 * share - 1.0) * self.most } else { share * self.most };
        for x in 0..across {
            let colour = self.colour(value((x as f64 + 0.5) / across as f64));
            strip.fill([margin + x, top], [1, line], colour);
        }
        for quarter in 0..=4 {
            let share = f64::from(quarter) / 4.0;
            let mut label = number(value(share));
            if self.signed && value(share) > 0.0 {
                label.insert(0, '+');
            }
            if quarter == 4 {
                label.push_str(" and more");
            }
            // At the ends the numbers stay on the strip, elsewhere they stand in the middle under their colour.
            let (place, wide) = ((share * across as f64) as usize, text_width(&label, size));
            let x = (margin + place).saturating_sub(wide / 2).min((margin + across).saturating_sub(wide)).max(margin);
            let hides_the_last = quarter == 3 && width < 40 * size * 8;
            if !hides_the_last {
                strip.text([x, top + line + margin], size, &label, INK);
            }
        }
        strip
    }
}

/// A heading of this width for over a picture.
pub(super) fn heading(width: usize, text: &str) -> Canvas {
    let size = letter_size(width);
    let mut heading = Canvas::new(width, text_height(size) + 8 * size, BACKGROUND);
    heading.text([4 * size, 4 * size], size, text, INK);
    heading
}

/// How large letters are drawn on a picture of this width.
fn letter_size(width: usize) -> usize {
    (width / 480).clamp(1, 4)
}

/// A number without digits that say nothing.
fn number(value: f64) -> String {
    if value == value.trunc() { format!("{value:.0}") } else { format!("{value:.2}").trim_end_matches('0').to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_ends_at_a_round_number_above_nearly_all() {
        let most = |values: Vec<f64>| Scale::over("", values, false).most;
        assert_eq!([most(vec![]), most(vec![0.0; 9]), most(vec![1.0, 3.0]), most(vec![-47.0])], [1.0, 1.0, 5.0, 50.0]);
        // Two of four hundred and two may be above, eleven may not.
        let mut values = vec![90.0; 400];
        values.extend([5000.0, 6000.0]);
        assert_eq!(most(values.clone()), 100.0);
        values.extend([5000.0; 9]);
        assert_eq!(most(values), 5000.0);
    }

    #[test]
    fn brighter_is_more_and_the_middle_of_a_signed_scale_is_grey() {
        let scale = Scale { title: String::new(), most: 40.0, signed: false };
        let light = |rgb: Rgb| 0.2 * f64::from(rgb[0]) + 0.7 * f64::from(rgb[1]) + 0.1 * f64::from(rgb[2]);
        let lights: Vec<f64> = (0..=40).map(|v| light(scale.colour(f64::from(v)))).collect();
        assert!(lights.windows(2).all(|w| w[0] < w[1]), "{lights:?}");
        assert_eq!(scale.colour(1e9), HEAT[4]);
        let signed = Scale { signed: true, ..scale };
        assert_eq!([signed.colour(-99.0), signed.colour(0.0), signed.colour(40.0)], SIGNED);
    }

    #[test]
    fn the_strip_is_as_wide_as_it_is_asked_for() {
        let scale = Scale { title: "triangle tests a ray".into(), most: 50.0, signed: false };
        for width in [1, 30, 320, 1280, 4000] {
            assert_eq!(scale.strip(width).width(), width);
        }
        assert_eq!([number(0.25), number(2.5), number(-40.0)], ["0.25", "2.5", "-40"]);
    }
}

//! Values as positions along an axis, and the round numbers that stand beside it.

/// How values are spaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scale {
    /// From zero.
    Linear,
    /// Positive values only.
    Logarithmic,
    /// Logarithmic, with a place of its own for zero below all others.
    LogarithmicOrZero,
    /// Positive values only, spaced by their logarithms and fitted closely: for values that differ little.
    Close,
}

impl Scale {
    /// Whether such a value has a position.
    pub fn takes(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Scale::Linear => true,
                Scale::Logarithmic | Scale::Close => value > 0.0,
                Scale::LogarithmicOrZero => value >= 0.0,
            }
    }
}

/// What a panel's values are along one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    /// How values are spaced along it.
    pub scale: Scale,
    /// For the front.
    pub higher_is_better: bool,
}

impl Axis {
    /// [`Scale::Linear`], higher values better.
    pub fn linear(label: impl Into<String>) -> Axis {
        Axis { label: label.into(), scale: Scale::Linear, higher_is_better: true }
    }

    /// [`Scale::Logarithmic`], higher values better.
    pub fn logarithmic(label: impl Into<String>) -> Axis {
        Axis { scale: Scale::Logarithmic, ..Axis::linear(label) }
    }

    /// [`Scale::LogarithmicOrZero`], higher values better.
    pub fn logarithmic_or_zero(label: impl Into<String>) -> Axis {
        Axis { scale: Scale::LogarithmicOrZero, ..Axis::linear(label) }
    }

    /// [`Scale::Close`], higher values better.
    pub fn close(label: impl Into<String>) -> Axis {
        Axis { scale: Scale::Close, ..Axis::linear(label) }
    }

    /// The same axis, on which the front looks for low values.
    #[must_use]
    pub fn lower_is_better(self) -> Axis {
        Axis { higher_is_better: false, ..self }
    }
}

/// An axis fitted to its values.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    scale: Scale,
    /// In the value's unit, or its decimal logarithm.
    low: f64,
    high: f64,
    /// Where the axis begins that is not for zero.
    floor: f64,
}

/// The share of an axis below all positive values that belongs to zero.
const ZERO_SHARE: f64 = 0.12;

impl Fit {
    pub fn new(scale: Scale, values: impl Iterator<Item = f64>) -> Fit {
        let (mut low, mut high, mut zero) = (f64::INFINITY, f64::NEG_INFINITY, false);
        for value in values.filter(|v| scale.takes(*v)) {
            zero |= value == 0.0;
            if scale == Scale::Linear || value > 0.0 {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        if low > high {
            (low, high) = (1.0, 10.0);
        }
        let floor = if scale == Scale::LogarithmicOrZero && zero { ZERO_SHARE } else { 0.0 };
        if scale == Scale::Linear {
            let (low, high) = (low.min(0.0), high.max(0.0));
            let span = if high > low { high - low } else { 1.0 };
            let low = if low < 0.0 { low - 0.06 * span } else { 0.0 };
            return Fit { scale, low, high: high + 0.08 * span, floor };
        }

        // At least a factor of three, or of a tenth more, and some room at both ends.
        let (low, high) = (low.log10(), high.log10());
        let least = if scale == Scale::Close { 0.02 } else { 0.24 };
        let spare = (least - 0.5 * (high - low)).max(0.0) + 0.07 * (high - low);
        Fit { scale, low: low - spare, high: high + spare, floor }
    }

    /// 0 at the axis's beginning, 1 at its end.
    pub fn position(&self, value: f64) -> f64 {
        if self.scale == Scale::Linear {
            return (value - self.low) / (self.high - self.low);
        }
        if value <= 0.0 {
            return 0.5 * self.floor;
        }
        self.floor + (1.0 - self.floor) * (value.log10() - self.low) / (self.high - self.low)
    }

    /// Values to mark, ascending: 1, 2 or 5 times a power of ten, about six of them.
    pub fn ticks(&self) -> Vec<f64> {
        let mut ticks = Vec::new();
        match self.scale {
            Scale::Linear => return even(self.low, self.high),
            // Within a decade even steps are as good as any.
            Scale::Close if self.high - self.low < 0.6 => {
                return even(10f64.powf(self.low), 10f64.powf(self.high));
            }
            _ => {}
        }
        if self.floor > 0.0 {
            ticks.push(0.0);
        }
        // Within a decade or so more of its numbers, over many decades not even each of them.
        let decades = self.high - self.low;
        let steps: &[f64] = match decades {
            d if d < 0.6 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
            d if d < 1.1 => &[1.0, 1.5, 2.0, 3.0, 4.0, 6.0],
            d if d < 2.3 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let stride = (decades / 7.0).ceil().max(1.0) as i32;
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        for exponent in (first..=last).filter(|e| e.rem_euclid(stride) == 0) {
            let values = steps.iter().map(|m| m * 10f64.powi(exponent));
            ticks.extend(values.filter(|v| (self.low..=self.high).contains(&v.log10())));
        }
        ticks
    }
}

/// 1, 2 or 5 times a power of ten apart, about six of them.
fn even(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough);
    let step = step.unwrap_or(10.0 * power);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

/// `0.2`, `50`, `20k`, `1M`, `1e-6`.
pub fn short(value: f64) -> String {
    let magnitude = value.abs();
    // Three digits, and none that say nothing.
    let digits = |v: f64| {
        let text = match v.abs() {
            m if m >= 100.0 => format!("{v:.0}"),
            m if m >= 10.0 => format!("{v:.1}"),
            m if m >= 1.0 => format!("{v:.2}"),
            _ => format!("{v:.3}"),
        };
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
    };
    if magnitude == 0.0 {
        "0".into()
    } else if !(1e-3..1e9).contains(&magnitude) {
        format!("{value:.0e}")
    } else if magnitude >= 1e6 {
        format!("{}M", digits(value / 1e6))
    } else if magnitude >= 1e4 {
        format!("{}k", digits(value / 1e3))
    } else {
        digits(value)
    }
}

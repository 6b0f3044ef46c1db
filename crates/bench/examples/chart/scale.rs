//! From a value to its place along an axis.

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spread {
    Linear,
    Log,
    /// One step from each value to the next, whatever their distance.
    Even,
}

/// An axis: places run from 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    spread: Spread,
    low: f64,
    high: f64,
    /// Values that are named, and their names.
    ticks: Vec<(f64, String)>,
}

impl Scale {
    /// An axis over values, each named.
    pub(crate) fn over(spread: Spread, named: Vec<(f64, String)>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (value, _) in &named {
            (low, high) = (low.min(*value), high.max(*value));
        }
        Self {
            spread,
            low,
            high,
            ticks: named,
        }
    }

    /// A logarithmic axis over the decades that hold some values.
    pub(crate) fn decades(values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| v.is_finite() && *v > 0.0) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.1, 10.0);
        }
        let first = libm::log10(low).floor() as i32;
        let last = (libm::log10(high).ceil() as i32).max(first + 1);
        let value = |decade: i32| libm::pow(10.0, f64::from(decade));
        Self {
            spread: Spread::Log,
            low: value(first),
            high: value(last),
            ticks: (first..=last)
                .map(|decade| (value(decade), number(value(decade))))
                .collect(),
        }
    }

    /// Where a value is, 0…1.
    pub(crate) fn at(&self, value: f64) -> f64 {
        match self.spread {
            Spread::Linear => (value - self.low) / (self.high - self.low),
            Spread::Log => libm::log(value / self.low) / libm::log(self.high / self.low),
            Spread::Even => {
                let place = self.ticks.iter().position(|(v, _)| *v == value);
                let steps = self.ticks.len().saturating_sub(1).max(1);
                place.map_or(f64::NAN, |place| place as f64 / steps as f64)
            }
        }
    }

    /// The value kept within the axis.
    pub(crate) fn clamped(&self, value: f64) -> f64 {
        self.at(value.clamp(self.low, self.high))
    }

    /// Places of the ticks and their names, without those that would be written over the one before: a name takes so much of the axis
    /// per letter.
    pub(crate) fn ticks(&self, per_letter: f64) -> Vec<(f64, &str)> {
        let mut kept: Vec<(f64, &str)> = Vec::new();
        for (value, name) in &self.ticks {
            let place = self.at(*value);
            let is_free = kept.last().is_none_or(|(before, other)| {
                let letters = 0.5 * (name.chars().count() + other.chars().count()) as f64 + 0.5;
                (place - before).abs() >= per_letter * letters
            });
            if is_free {
                kept.push((place, name));
            }
        }
        kept
    }

    /// Places of all ticks.
    pub(crate) fn places(&self) -> Vec<f64> {
        self.ticks.iter().map(|(v, _)| self.at(*v)).collect()
    }
}

/// A number as short as it can be written.
pub(crate) fn number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        format!("{}", libm::round(value * 1e6) / 1e6)
    }
}

//! Progress on standard error: a bar on a terminal, nothing elsewhere.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar for one piece of work.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn new(label: &str) -> Self {
        // indicatif draws only on a terminal; NO_COLOR it honours itself.
        let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{msg:<24} {bar:32} {percent:>3}% {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        Self::started(bar, label)
    }

    /// For work that does not say how far it is.
    pub(crate) fn busy(label: &str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{msg:<24} {spinner} {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_spinner());
        bar.set_style(style);
        Self::started(bar, label)
    }

    fn started(bar: ProgressBar, label: &str) -> Self {
        bar.set_message(label.to_owned());
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }

    /// Fraction done, in [0, 1].
    pub(crate) fn set(&self, fraction: f64) {
        let position = (fraction * 1000.0) as u64;
        if position > self.0.position() {
            self.0.set_position(position);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

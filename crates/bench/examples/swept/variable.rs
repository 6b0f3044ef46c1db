//! What changes in a sweep, and over which values.

use crate::chart::scale::{Spread, number};

/// The values of a variable.
#[derive(Clone, Copy)]
pub(crate) enum Values {
    Of(Spread, &'static [f64]),
    /// Named, not measured: a value is its place in the list.
    Named(&'static [&'static str]),
}

/// One variable.
#[derive(Clone, Copy)]
pub(crate) struct Variable {
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    /// What the values are, with their unit.
    pub(crate) meaning: &'static str,
    pub(crate) values: Values,
}

impl Variable {
    pub(crate) const fn new(
        name: &'static str,
        [title, meaning]: [&'static str; 2],
        values: Values,
    ) -> Self {
        Self {
            name,
            title,
            meaning,
            values,
        }
    }

    /// Values and their names, in order.
    pub(crate) fn values(&self) -> Vec<(f64, String)> {
        match self.values {
            Values::Of(_, values) => values.iter().map(|v| (*v, number(*v))).collect(),
            Values::Named(names) => names
                .iter()
                .enumerate()
                .map(|(k, name)| (k as f64, (*name).to_owned()))
                .collect(),
        }
    }

    pub(crate) fn spread(&self) -> Spread {
        match self.values {
            Values::Of(spread, _) => spread,
            Values::Named(_) => Spread::Even,
        }
    }
}

//! Axes, and what is drawn between them.

use core::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::scale::Scale;
use super::{Area, DrawError, INK, LABEL_PX, text};

/// Places, linear, with ticks where they are wanted.
struct Places {
    range: Range<f64>,
    ticks: Vec<f64>,
}

impl Ranged for Places {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from_px, to_px): (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        from_px + libm::round(share * f64::from(to_px - from_px)) as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// Axes on which places run from 0 to 1.
pub(crate) struct Panel<'a, 'b> {
    chart: ChartContext<'a, SVGBackend<'b>, Cartesian2d<Places, Places>>,
}

/// Room beside the outermost places.
const ASIDE: f64 = 0.06;
/// How much of the horizontal axis a letter takes.
const PER_LETTER: f64 = 0.018;

impl<'a, 'b> Panel<'a, 'b> {
    /// Axes with their titles; a horizontal axis without one is not labelled.
    pub(crate) fn new(
        area: &'a Area<'b>,
        [x, y]: [&Scale; 2],
        x_title: Option<&str>,
        y_title: &str,
    ) -> Result<Self, DrawError> {
        let names = x.ticks(PER_LETTER);
        let y_names = y.ticks(0.0);
        let mut chart = ChartBuilder::on(area)
            .margin_left(18)
            .margin_right(22)
            .margin_top(10)
            .x_label_area_size(if x_title.is_some() { 66 } else { 8 })
            .y_label_area_size(96)
            .build_cartesian_2d(
                Places {
                    range: -ASIDE..1.0 + ASIDE,
                    ticks: x.places(),
                },
                Places {
                    range: 0.0..1.0,
                    ticks: y.places(),
                },
            )?;
        let name_at = |names: &[(f64, &str)], place: f64| {
            let named = names.iter().find(|(at, _)| (at - place).abs() < 1e-9);
            named.map_or(String::new(), |(_, name)| (*name).to_owned())
        };
        let x_name = |place: &f64| {
            if x_title.is_some() {
                name_at(&names, *place)
            } else {
                String::new()
            }
        };
        let y_name = |place: &f64| name_at(&y_names, *place);
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(INK.mix(0.15))
            .axis_style(INK)
            .label_style(text(LABEL_PX, HPos::Center, VPos::Center))
            .axis_desc_style(text(LABEL_PX, HPos::Center, VPos::Center))
            .x_label_formatter(&x_name)
            .y_label_formatter(&y_name)
            .x_labels(x.places().len())
            .y_labels(y.places().len())
            .y_desc(y_title);
        if let Some(title) = x_title {
            mesh.x_desc(title);
        }
        mesh.draw()?;
        Ok(Self { chart })
    }

    /// A line with a mark at each point.
    pub(crate) fn line(
        &mut self,
        points: &[(f64, f64)],
        colour: RGBColor,
        mark_px: u32,
    ) -> Result<(), DrawError> {
        let style = colour.stroke_width(3).filled();
        self.chart.draw_series(LineSeries::new(
            points.iter().copied(),
            colour.stroke_width(3),
        ))?;
        let marks = points.iter().map(|at| Circle::new(*at, mark_px, style));
        self.chart.draw_series(marks)?;
        Ok(())
    }

    /// A line of dashes, px long and as far apart.
    pub(crate) fn dashed(
        &mut self,
        points: &[(f64, f64)],
        colour: RGBColor,
        dash_px: u32,
    ) -> Result<(), DrawError> {
        self.chart.draw_series(DashedLineSeries::new(
            points.iter().copied(),
            dash_px,
            dash_px.min(6),
            colour.stroke_width(3),
        ))?;
        Ok(())
    }

    /// What lies between two lines, given as (place, low, high).
    pub(crate) fn band(
        &mut self,
        between: &[(f64, f64, f64)],
        colour: RGBColor,
    ) -> Result<(), DrawError> {
        let low = between.iter().map(|(x, low, _)| (*x, *low));
        let high = between.iter().rev().map(|(x, _, high)| (*x, *high));
        let outline: Vec<_> = low.chain(high).collect();
        self.chart
            .draw_series([Polygon::new(outline, colour.mix(0.2))])?;
        Ok(())
    }

    /// A mark with its interval, given as (place, low, middle, high).
    pub(crate) fn whisker(
        &mut self,
        (place, low, middle, high): (f64, f64, f64, f64),
        colour: RGBColor,
        mark_px: u32,
    ) -> Result<(), DrawError> {
        let span = [(place, low), (place, high)];
        self.chart
            .draw_series([PathElement::new(span, colour.mix(0.35).stroke_width(9))])?;
        self.chart
            .draw_series([Circle::new((place, middle), mark_px, colour.filled())])?;
        Ok(())
    }

    /// A rectangle.
    pub(crate) fn bar(
        &mut self,
        corners: [(f64, f64); 2],
        colour: RGBColor,
    ) -> Result<(), DrawError> {
        self.chart
            .draw_series([Rectangle::new(corners, colour.filled())])?;
        Ok(())
    }
}

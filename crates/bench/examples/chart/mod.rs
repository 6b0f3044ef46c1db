//! What the charts of the examples share: scales, colours, fonts, a legend. Drawn by plotters, as SVG.
#![allow(dead_code, reason = "each program uses a part")]
#![allow(
    clippy::allow_attributes,
    reason = "`expect` cannot say `in some of the programs`"
)]

pub(crate) mod panel;
pub(crate) mod scale;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Colours of Okabe and Ito (2008), which the colour-blind tell apart.
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const AMBER: RGBColor = RGBColor(230, 159, 0);
pub(crate) const GREY: RGBColor = RGBColor(170, 170, 170);
pub(crate) const INK: RGBColor = RGBColor(40, 40, 40);

/// Width of a chart, px, and its fonts: on a phone of 360 px still 10 px high.
pub(crate) const WIDTH_PX: u32 = 800;
pub(crate) const TITLE_PX: u32 = 26;
pub(crate) const LABEL_PX: u32 = 22;

/// An area of an SVG file.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
/// What drawing may fail with.
pub(crate) type DrawError = Box<dyn std::error::Error>;

/// Text of the labels' size.
pub(crate) fn text(size_px: u32, h: HPos, v: VPos) -> TextStyle<'static> {
    ("sans-serif", size_px)
        .into_font()
        .color(&INK)
        .pos(Pos::new(h, v))
}

/// How a line of a legend looks.
#[derive(Clone, Copy)]
pub(crate) enum Mark {
    /// A line with points.
    Line,
    Dashed,
    Dotted,
    /// A filled square.
    Square,
}

/// Entries side by side in an area, each so many px after the one before.
pub(crate) fn legend(
    area: &Area<'_>,
    [x, y]: [i32; 2],
    entries: &[(Mark, RGBColor, &str)],
) -> Result<(), DrawError> {
    let mut at = x;
    for (mark, colour, name) in entries {
        match mark {
            Mark::Square => area.draw(&Rectangle::new(
                [(at, y - 9), (at + 18, y + 9)],
                colour.filled(),
            ))?,
            Mark::Line => {
                area.draw(&PathElement::new(
                    [(at, y), (at + 34, y)],
                    colour.stroke_width(3),
                ))?;
                area.draw(&Circle::new((at + 17, y), 5, colour.filled()))?;
            }
            Mark::Dashed => {
                for k in 0..3 {
                    let from = at + 12 * k;
                    area.draw(&PathElement::new(
                        [(from, y), (from + 8, y)],
                        colour.stroke_width(3),
                    ))?;
                }
            }
            Mark::Dotted => {
                for k in 0..5 {
                    area.draw(&Circle::new((at + 2 + 7 * k, y), 2, colour.filled()))?;
                }
            }
        }
        at += if matches!(mark, Mark::Square) { 24 } else { 42 };
        area.draw(&Text::new(
            (*name).to_owned(),
            (at, y),
            text(LABEL_PX, HPos::Left, VPos::Center),
        ))?;
        // As wide as a sans-serif letter is on average, and a gap.
        at += (0.55 * f64::from(LABEL_PX) * name.chars().count() as f64) as i32 + 22;
    }
    Ok(())
}

//! Self-contained HTML pages: one file, no script, no network.

use std::io::Write;

use minijinja::{Environment, context};
use serde::Serialize;

use crate::failure::Failure;
use crate::picture::Canvas;

/// A page: a heading, numbers, pictures.
#[derive(Serialize)]
pub(crate) struct Page {
    pub(crate) title: String,
    /// One sentence under the title.
    pub(crate) lead: String,
    pub(crate) sections: Vec<Section>,
    /// How it came about: name and value.
    pub(crate) provenance: Vec<(String, String)>,
}

/// A part of a page.
#[derive(Serialize)]
pub(crate) struct Section {
    pub(crate) heading: String,
    pub(crate) text: String,
    pub(crate) tables: Vec<HtmlTable>,
    pub(crate) figures: Vec<Figure>,
    /// Pictures in a row.
    pub(crate) columns: usize,
}

/// The first row of `rows` is its header.
#[derive(Serialize)]
pub(crate) struct HtmlTable {
    pub(crate) caption: String,
    pub(crate) header: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

/// A picture with its caption.
#[derive(Serialize)]
pub(crate) struct Figure {
    url: String,
    caption: String,
}

impl Figure {
    /// A picture no wider than a page needs.
    pub(crate) fn new(picture: &Canvas, caption: impl Into<String>) -> Result<Self, Failure> {
        Ok(Self {
            url: picture.shrunk(960).data_url()?,
            caption: caption.into(),
        })
    }
}

impl Page {
    pub(crate) fn to_html(&self) -> Result<String, Failure> {
        let mut environment = Environment::new();
        environment
            .add_template("page.html", include_str!("page.html"))
            .map_err(Failure::failed)?;
        let template = environment
            .get_template("page.html")
            .map_err(Failure::failed)?;
        template
            .render(context! { page => minijinja::value::Serde(self) })
            .map_err(Failure::failed)
    }

    pub(crate) fn write(&self, path: &std::path::Path) -> Result<(), Failure> {
        let html = self.to_html()?;
        Ok(rodsight_render::write_whole(path, |file| {
            file.write_all(html.as_bytes())
        })?)
    }
}

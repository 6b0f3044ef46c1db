//! Plain-text tables for the terminal.

/// Columns aligned: the first to the left, the others to the right.
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(header: Vec<String>) -> Self {
        Self { rows: vec![header] }
    }

    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows
                .iter()
                .filter_map(|row| row.get(column))
                .map(|c| c.chars().count())
                .max()
        };
        let widths: Vec<usize> = (0..columns)
            .map(|column| width(column).unwrap_or(0))
            .collect();
        if self.rows.len() < 2 {
            return Ok(());
        }
        for row in &self.rows {
            for (column, cell) in row.iter().enumerate() {
                if column == 0 {
                    write!(f, "  {cell:<width$}", width = widths[0])?;
                } else {
                    write!(f, "  {cell:>width$}", width = widths[column])?;
                }
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

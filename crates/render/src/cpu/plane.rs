//! Three-band images with cells around them, and what the halo does to them.

use rayon::prelude::*;

/// Shape `[height + 2 margin, width + 2 margin, 3]`, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    width: usize,
    height: usize,
    margin: usize,
    values: Vec<f32>,
}

impl Plane {
    pub(super) fn new(width: usize, height: usize, margin: usize) -> Self {
        Self {
            width,
            height,
            margin,
            values: vec![0.0; 3 * (width + 2 * margin) * (height + 2 * margin)],
        }
    }

    fn stride(&self) -> usize {
        3 * (self.width + 2 * self.margin)
    }

    /// A row with its margins; the first row of the image is 0.
    fn row(&self, row: isize) -> &[f32] {
        let at = (row + self.margin.cast_signed()) as usize * self.stride();
        &self.values[at..at + self.stride()]
    }

    /// The image's rows with their margins to either side, so many at a time.
    pub(super) fn rows_mut(
        &mut self,
        rows: usize,
    ) -> impl IndexedParallelIterator<Item = &mut [f32]> {
        let stride = self.stride();
        let image = self.margin * stride..(self.margin + self.height) * stride;
        self.values[image].par_chunks_mut(rows * stride)
    }

    /// The values of a plane without margin, pixel by pixel.
    pub(super) fn pixels(&self) -> &[[f32; 3]] {
        assert_eq!(self.margin, 0, "a plane of nothing but its image");
        self.values.as_chunks().0
    }

    /// Sets every cell by its column and row; the margin's are negative or beyond the size.
    pub(super) fn fill(&mut self, value: impl Fn(isize, isize) -> [f32; 3] + Sync) {
        let (stride, margin) = (self.stride(), self.margin.cast_signed());
        let rows = self.values.par_chunks_mut(stride).enumerate();
        rows.for_each(|(row, cells)| {
            for (column, cell) in cells.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                *cell = value(column.cast_signed() - margin, row.cast_signed() - margin);
            }
        });
    }

    /// Sets what of a rectangle lies in the margin. The rectangle must lie outside the image.
    pub(super) fn fill_margin(&mut self, at: [isize; 2], size: [isize; 2], value: [f32; 3]) {
        let margin = self.margin.cast_signed();
        let [columns, rows] = [(0, self.width), (1, self.height)].map(|(axis, extent)| {
            let end = (at[axis] + size[axis]).min(extent.cast_signed() + margin);
            at[axis].max(-margin) + margin..end + margin
        });
        let stride = self.width + 2 * self.margin;
        for row in rows {
            for column in columns.clone() {
                self.values.as_chunks_mut().0[row as usize * stride + column as usize] = value;
            }
        }
    }

    /// The image without its margin.
    pub(super) fn cropped(&self) -> Self {
        let mut image = Self::new(self.width, self.height, 0);
        let stride = image.stride();
        for (row, cells) in image.values.chunks_mut(stride).enumerate() {
            let from = 3 * self.margin;
            cells.copy_from_slice(&self.row(row.cast_signed())[from..from + stride]);
        }
        image
    }

    /// Adds a plane of the same shape.
    pub(super) fn add(&mut self, other: &Self) {
        let pairs = self.values.par_iter_mut().zip(&other.values);
        pairs.for_each(|(sum, value)| *sum += value);
    }

    /// The convolution with a symmetric kernel, given from its middle outwards, along rows and columns; of the margin only `border`
    /// cells are kept, which with the kernel must lie within it.
    pub(super) fn blurred(&self, kernel: &[f32], border: usize) -> Self {
        let mut blurred = Self::new(self.width, self.height, border);
        let stride = blurred.stride();
        let lost = self.margin - border;
        // All rows that the second pass asks for.
        let reach = kernel.len() - 1;
        let mut rows = vec![0.0; stride * (self.height + 2 * (border + reach))];
        rows.par_chunks_mut(stride)
            .enumerate()
            .for_each(|(row, out)| {
                let source = self.row(row.cast_signed() - (border + reach).cast_signed());
                let from = |shift: isize| {
                    let at = (3 * (lost.cast_signed() + shift)) as usize;
                    &source[at..at + stride]
                };
                convolve(out, kernel, from);
            });
        blurred
            .values
            .par_chunks_mut(stride)
            .enumerate()
            .for_each(|(row, out)| {
                let from = |shift: isize| {
                    let at = (row + reach).wrapping_add_signed(shift) * stride;
                    &rows[at..at + stride]
                };
                convolve(out, kernel, from);
            });
        blurred
    }

    /// Adds a plane of half the resolution with a border of one cell, bilinearly: 3/4 of the cell a value lies in and 1/4 of the next
    /// nearest, on both axes.
    pub(super) fn add_magnified(&mut self, coarse: &Self) {
        assert_eq!(coarse.margin, 1, "one cell around the image");
        let (stride, margin) = (self.stride(), self.margin.cast_signed());
        let rows = self.values.par_chunks_mut(stride).enumerate();
        rows.for_each(|(row, cells)| {
            let (near, next) = parents(row.cast_signed() - margin);
            let (near, next) = (coarse.row(near), coarse.row(next));
            let down: Vec<f32> = near
                .iter()
                .zip(next)
                .map(|(near, next)| 0.75 * near + 0.25 * next)
                .collect();
            let down = down.as_chunks::<3>().0;
            for (column, cell) in cells.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let (near, next) = parents(column.cast_signed() - margin);
                let (near, next) = (&down[(near + 1) as usize], &down[(next + 1) as usize]);
                for k in 0..3 {
                    cell[k] += 0.75 * near[k] + 0.25 * next[k];
                }
            }
        });
    }
}

/// The cell of half the resolution that a cell lies in, and the next nearest.
pub(crate) fn parents(at: isize) -> (isize, isize) {
    let near = at.div_euclid(2);
    (
        near,
        if at.rem_euclid(2) == 0 {
            near - 1
        } else {
            near + 1
        },
    )
}

/// Σ over shifts of kernel × shifted values, from the middle outwards.
fn convolve<'a>(out: &mut [f32], kernel: &[f32], from: impl Fn(isize) -> &'a [f32]) {
    for (out, value) in out.iter_mut().zip(from(0)) {
        *out = kernel[0] * value;
    }
    for (shift, weight) in (1..).zip(&kernel[1..]) {
        let (before, after) = (from(-shift), from(shift));
        for ((out, before), after) in out.iter_mut().zip(before).zip(after) {
            *out += weight * (before + after);
        }
    }
}

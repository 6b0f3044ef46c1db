//! Sums of an image along all digital lines steeper than 45° (a fast discrete Radon transform).
//!
//! A line is where it passes the middle row and how steep it is. Rows are added to sums of short strips, those to sums of longer
//! ones: what lines of a strip have in common is added once. Of n rows that is about 6 ∛n additions a line where line by line it
//! would be n; the price is that a line is off its straight course by half a pixel, at worst by two.

use std::borrow::Cow;

/// Strips of up to so many rows are added row by row.
const ROWS: usize = 9;
/// Strips that are put together at a time, at most.
const PIECES: usize = 6;
/// Zeros that an image has before and after each row: with them all pieces of a line are read alike.
pub(crate) const MARGIN: usize = ROWS;

/// Places at both ends of each slope that have no sums.
pub(crate) const BESIDE: usize = 2;

/// Which lines there are: shape `[slope][place]`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Grid {
    /// Of the image.
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Slopes are −1 to 1 in steps of 1/half.
    half: usize,
    /// Places left and right of the image where lines pass the middle row.
    reach: usize,
    /// Rows of the shortest line.
    least: f32,
}

impl Grid {
    /// Of an image; lines with fewer rows than `least` in it are not looked at.
    pub(crate) fn new(width: usize, height: usize, least: f32) -> Self {
        let mut grid = Self {
            width,
            height,
            half: height / 2,
            reach: 0,
            least,
        };
        // Never less than what peaks are compared with.
        grid.reach = grid.reach_of(0) + BESIDE;
        grid
    }

    pub(crate) fn slopes(&self) -> usize {
        2 * self.half + 1
    }

    pub(crate) fn places(&self) -> usize {
        self.width + 2 * self.reach
    }

    /// Pixels to the right a row further down.
    pub(crate) fn slope(&self, index: f64) -> f64 {
        (index - self.half as f64) / (self.half as f64).max(1.0)
    }

    /// Where a line passes the middle of the image's height, pixel centres at halves.
    pub(crate) fn place_px(&self, index: f64) -> f64 {
        index - self.reach as f64 + 0.5
    }

    /// Places outside the image on either side where lines of a slope are long enough.
    fn reach_of(&self, slope: usize) -> usize {
        let far = 0.5 * self.height as f32 - self.least;
        (far * self.slope(slope as f64).abs() as f32)
            .max(0.0)
            .ceil() as usize
    }

    /// The places of a slope that are looked at.
    pub(crate) fn range(&self, slope: usize) -> core::ops::Range<usize> {
        let reach = self.reach_of(slope);
        self.reach - reach..self.reach + self.width + reach
    }

    /// Of a slope's places the rows that a line has in the image without its first and last column; 0 of those that are too short.
    pub(crate) fn counts(&self, slope: usize) -> impl Fn(usize) -> f32 + use<> {
        // A line is within for 1/|slope| rows a pixel.
        let per_px = (1.0 / self.slope(slope as f64).abs().max(1e-6)) as f32;
        let (half, least) = (0.5 * self.height as f32, self.least);
        let before_first = self.place_px(0.0) as f32 - 1.0;
        let last = self.width as f32 - 2.0;
        move |place| {
            let inside = before_first + place as f32;
            let count = (inside * per_px).min(half) + ((last - inside) * per_px).min(half);
            if count < least { 0.0 } else { count }
        }
    }

    /// How many lines.
    pub(crate) fn len(&self) -> usize {
        self.slopes() * self.places()
    }

    /// The straight line through the pixels of a line that are in the image: where it passes the middle row, and its slope.
    pub(crate) fn course(&self, slope: usize, place: usize) -> (f64, f64) {
        let mut columns = Vec::with_capacity(self.height);
        course(self.height, self.half, slope, 0, &mut columns);
        let place_px = self.place_px(place as f64);
        let is_inside = |x: &f64| (0.0..self.width as f64).contains(x);
        let points: Vec<(f64, f64)> = (0..self.height)
            .map(|row| row as f64 + 0.5 - 0.5 * self.height as f64)
            .zip(columns.iter().map(|column| place_px + *column as f64))
            .filter(|(_, x)| is_inside(x))
            .collect();
        let mean = |f: &dyn Fn(f64, f64) -> f64| {
            points.iter().map(|(y, x)| f(*y, *x)).sum::<f64>() / points.len() as f64
        };
        let (y, x) = (mean(&|y, _| y), mean(&|_, x| x));
        let squares = mean(&|v, _| (v - y) * (v - y));
        if points.is_empty() || squares == 0.0 {
            return (place_px, self.slope(slope as f64));
        }
        let turn = mean(&|v, u| (v - y) * (u - x)) / squares;
        (x - turn * y, turn)
    }

    /// Appends the sums along all lines of an image whose rows have `MARGIN` zeros before and after them.
    pub(crate) fn sum(&self, image: &[f32], sums: &mut Vec<f32>) {
        let shape = Shape {
            height: self.height,
            half: self.half,
            reach: self.reach,
            margin: self.reach,
        };
        shape.add(image, self.width, |slope| self.reach_of(slope), sums);
    }
}

/// Which lines of a strip of rows there are: `[slope][place]`.
#[derive(Clone, Copy)]
struct Shape {
    height: usize,
    /// Slopes are −1 to 1 in steps of 1/half.
    half: usize,
    /// Places before and after the image where there are sums.
    reach: usize,
    /// Places before and after the image where there are sums or zeros.
    margin: usize,
}

/// Sums along the lines of a strip.
struct Strip<'a> {
    shape: Shape,
    values: Cow<'a, [f32]>,
}

/// Rows of the parts that a strip is added from.
fn parts(height: usize) -> impl Iterator<Item = usize> {
    let parts = if height <= ROWS {
        height
    } else {
        // None of a single row: its margin would be too short.
        height.div_ceil(ROWS).min(PIECES)
    };
    // As even as can be.
    let first = move |part| part * height / parts;
    (0..parts).map(move |part| first(part + 1) - first(part))
}

/// Places that a line of a part may be moved by.
fn moved(height: usize, part: usize) -> usize {
    (height - part).div_ceil(2)
}

/// Where the sums of a strip end.
fn reach(height: usize) -> usize {
    if height <= 1 {
        return 0;
    }
    let each = parts(height).map(|part| reach(part) + moved(height, part));
    each.max().unwrap_or(0)
}

impl<'a> Strip<'a> {
    /// Of some rows, with zeros for `margin` places before and after.
    fn of(image: &'a [f32], width: usize, margin: usize) -> Self {
        let height = image.len() / (width + 2 * MARGIN);
        let reach = reach(height);
        let mut shape = Shape {
            height,
            half: height / 2,
            reach,
            margin,
        };
        if height == 1 {
            shape.margin = MARGIN;
            let values = Cow::Borrowed(image);
            return Self { shape, values };
        }
        let mut values = Vec::with_capacity((2 * shape.half + 1) * (width + 2 * margin));
        shape.add(image, width, |_| reach, &mut values);
        let values = Cow::Owned(values);
        Self { shape, values }
    }
}

impl Shape {
    /// Appends the sums along the lines of an image, slope by slope as far as `reach_of` says and zeros beyond.
    fn add(
        self,
        image: &[f32],
        width: usize,
        reach_of: impl Fn(usize) -> usize,
        sums: &mut Vec<f32>,
    ) {
        let height = self.height;
        let mut rest = image;
        let mut above = 0;
        // With the distance of each part's middle from that of the whole, in rows.
        let pieces: Vec<(Strip<'_>, f64)> = parts(height)
            .map(|part| {
                let (rows, below) = rest.split_at(part * (width + 2 * MARGIN));
                rest = below;
                let off = off(height, above, part);
                above += part;
                (
                    Strip::of(rows, width, self.reach + moved(height, part)),
                    off,
                )
            })
            .collect();
        let mut lines = Vec::with_capacity(pieces.len());
        for index in 0..=2 * self.half {
            let slope = (index as f64 - self.half as f64) / self.half.max(1) as f64;
            let reach = reach_of(index);
            let length = width + 2 * reach;
            lines.clear();
            lines.extend(pieces.iter().map(|(piece, off)| {
                // The nearest of the piece's slopes, and the place nearest to where the line passes its middle.
                let Self { half, margin, .. } = piece.shape;
                let row = nearest(half, slope * half as f64) * (width + 2 * margin);
                let first = row + nearest(margin - reach, slope * off);
                &piece.values[first..first + length]
            }));
            sums.resize(sums.len() + self.margin - reach, 0.0);
            add(sums, &lines);
            sums.resize(sums.len() + self.margin - reach, 0.0);
        }
    }
}

/// Appends where the pixels of a line are, row by row, from the place where it passes the middle of its strip.
fn course(height: usize, half: usize, slope: usize, moved: isize, columns: &mut Vec<isize>) {
    if height == 1 {
        columns.push(moved);
        return;
    }
    let slope = (slope as f64 - half as f64) / half.max(1) as f64;
    let mut above = 0;
    for part in parts(height) {
        let (half, off) = (part / 2, off(height, above, part));
        let further = nearest(height, slope * off).cast_signed() - height.cast_signed();
        let slope = nearest(half, slope * half as f64);
        course(part, half, slope, moved + further, columns);
        above += part;
    }
}

/// How far the middle of a part is below that of the whole, in rows.
fn off(height: usize, above: usize, part: usize) -> f64 {
    (above as f64 + 0.5 * part as f64) - 0.5 * height as f64
}

/// The index that is nearest to a distance from another, both at least 0.
fn nearest(from: usize, distance: f64) -> usize {
    // Rounding by way of a smaller number is faster than `round`.
    (from as f64 + distance + 0.5) as u32 as usize
}

/// Appends the sums of rows, four at a time: sums are read and written less often.
fn add(sums: &mut Vec<f32>, rows: &[&[f32]]) {
    let start = sums.len();
    let (first, rest) = rows.split_at((rows.len() + 3) % 4 + 1);
    match first {
        [a] => sums.extend_from_slice(a),
        [a, b] => sums.extend(a.iter().zip(*b).map(|(a, b)| a + b)),
        [a, b, c] => {
            let rows = a.iter().zip(*b).zip(*c);
            sums.extend(rows.map(|((a, b), c)| a + b + c));
        }
        [a, b, c, d] => {
            let rows = a.iter().zip(*b).zip(*c).zip(*d);
            sums.extend(rows.map(|(((a, b), c), d)| (a + b) + (c + d)));
        }
        _ => {}
    }
    for four in rest.chunks_exact(4) {
        if let [a, b, c, d] = four {
            let sums = sums[start..].iter_mut();
            for ((((sum, a), b), c), d) in sums.zip(*a).zip(*b).zip(*c).zip(*d) {
                *sum += (a + b) + (c + d);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deviates, the same on every machine.
    fn noise(count: usize) -> Vec<f32> {
        let mut state = 1_u32;
        let next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        core::iter::repeat_with(next).take(count).collect()
    }

    fn sums(grid: &Grid, image: &[f32]) -> Vec<f32> {
        let margin = [0.0; MARGIN];
        let rows = image.chunks_exact(grid.width);
        let padded = rows.flat_map(|row| [&margin[..], row, &margin[..]].concat());
        let mut sums = Vec::new();
        grid.sum(&padded.collect::<Vec<_>>(), &mut sums);
        assert_eq!(sums.len(), grid.len());
        sums
    }

    /// Where every line passes every row, by the sums of images with a single bright pixel.
    fn courses(width: usize, height: usize) -> Vec<Vec<Vec<isize>>> {
        let grid = Grid::new(width, height, 1.0);
        let mut courses = vec![vec![vec![]; height]; grid.len()];
        for row in 0..height {
            for column in 0..width {
                let mut image = vec![0.0; width * height];
                image[row * width + column] = 1.0;
                let sums = sums(&grid, &image);
                for (line, sum) in courses.iter_mut().zip(&sums) {
                    assert!(*sum == 0.0 || *sum == 1.0, "{sum}");
                    if *sum == 1.0 {
                        line[row].push(column.cast_signed());
                    }
                }
            }
        }
        courses
    }

    /// Each line takes one pixel of every row that it crosses, near where it should; of any height, also of few rows.
    #[test]
    fn lines_take_a_pixel_a_row_near_their_course() {
        for (width, height) in [
            (9, 8),
            (12, 9),
            (7, 10),
            (8, 11),
            (10, 23),
            (9, 60),
            (6, 70),
        ] {
            let grid = Grid::new(width, height, 1.0);
            let (mut squares, mut count) = (0.0, 0.0);
            let mut told = Vec::new();
            for (line, rows) in courses(width, height).into_iter().enumerate() {
                let (slope, place) = (line / grid.places(), line % grid.places());
                if !grid.range(slope).contains(&place) {
                    assert!(rows.iter().all(Vec::is_empty));
                    continue;
                }
                told.clear();
                course(height, height / 2, slope, 0, &mut told);
                for ((row, columns), told) in rows.into_iter().enumerate().zip(&told) {
                    let told = grid.place_px(place as f64) + *told as f64 - 0.5;
                    assert!(
                        columns.iter().all(|c| *c as f64 == told),
                        "{columns:?} {told}"
                    );
                    let down = row as f64 + 0.5 - 0.5 * height as f64;
                    let at = grid.place_px(place as f64) + grid.slope(slope as f64) * down;
                    let off: Vec<f64> = columns.iter().map(|c| *c as f64 + 0.5 - at).collect();
                    assert!(off.len() <= 1, "{width}×{height}: {columns:?}");
                    let inside = (2.0..width as f64 - 2.0).contains(&at);
                    assert!(off.len() == 1 || !inside, "{width}×{height}: none at {at}");
                    for off in off {
                        assert!(off.abs() < 2.2, "{width}×{height}: {off} px off");
                        squares += off * off;
                        count += 1.0;
                    }
                }
            }
            let rms: f64 = f64::sqrt(squares / count);
            assert!(rms < 0.7, "{width}×{height}: {rms} px");
        }
    }

    /// The sums are those of the pixels on the lines.
    #[test]
    fn sums_are_of_the_pixels_on_the_lines() {
        let (width, height) = (9, 31);
        let grid = Grid::new(width, height, 1.0);
        let image = noise(width * height);
        for (rows, sum) in courses(width, height).into_iter().zip(sums(&grid, &image)) {
            let pixels = rows.iter().enumerate();
            let plain: f32 = pixels
                .flat_map(|(row, columns)| columns.iter().map(move |c| (row, c.cast_unsigned())))
                .map(|(row, column)| image[row * width + column])
                .sum();
            assert!((plain - sum).abs() < 1e-5, "{plain} {sum}");
        }
    }

    /// Rows that a line has in the image, but for what its wobbling does at the borders.
    #[test]
    fn counts_are_of_the_pixels_on_the_lines() {
        for (width, height) in [(30, 20), (12, 40)] {
            let grid = Grid::new(width, height, 3.0);
            let mut image = vec![1.0; width * height];
            for row in image.chunks_exact_mut(width) {
                (row[0], row[width - 1]) = (0.0, 0.0);
            }
            let sums = sums(&grid, &image);
            for slope in 0..grid.slopes() {
                let counts = grid.counts(slope);
                // Rows until the line is a pixel and a half further right.
                let slack = (1.5 / grid.slope(slope as f64).abs()).min(height as f64);
                for place in grid.range(slope) {
                    let (count, sum) = (counts(place), sums[slope * grid.places() + place]);
                    let is_near = f64::from((count - sum).abs()) <= slack;
                    assert!(count == 0.0 || is_near, "{slope} {place}: {count} {sum}");
                }
            }
        }
    }
}

//! Sizes of a system: constants of its type, or numbers at run time.
//!
//! Constants suit a few coordinates, whose loops the compiler unrolls. Numbers at run time need one copy of the integrator
//! for systems of any size. Vectors and matrices are allocated once; steps only write to them.

use std::fmt::Debug;
use std::ops::{Index, IndexMut};

/// An entry of a vector or matrix.
pub trait Entry: Copy + Debug + Send + 'static {}

impl<T: Copy + Debug + Send + 'static> Entry for T {}

/// A vector whose length does not change.
pub trait Vector<T>:
    Clone + Debug + PartialEq + Send + AsRef<[T]> + AsMut<[T]> + Index<usize, Output = T> + IndexMut<usize> + 'static
{
}

impl<T: Entry + PartialEq, const N: usize> Vector<T> for [T; N] {}

impl<T: Entry + PartialEq> Vector<T> for Vec<T> {}

/// A matrix, whose rows are slices.
pub trait Matrix<T>: Clone + Debug + Send + Index<usize, Output = [T]> + IndexMut<usize> + 'static {
    /// Sets all entries.
    fn fill(&mut self, value: T);

    /// All entries by rows, and the number of columns.
    fn entries(&self) -> (&[T], usize);

    /// Like [`Matrix::entries`], but mutable.
    fn entries_mut(&mut self) -> (&mut [T], usize);
}

/// Matrix of a constant size.
#[derive(Clone, Copy, Debug)]
pub struct FixedMatrix<T, const ROWS: usize, const COLUMNS: usize>(pub [[T; COLUMNS]; ROWS]);

/// Matrix whose size is known at run time.
#[derive(Clone, Debug)]
pub struct DynamicMatrix<T> {
    entries: Vec<T>,
    columns: usize,
}

impl<T, const ROWS: usize, const COLUMNS: usize> Index<usize> for FixedMatrix<T, ROWS, COLUMNS> {
    type Output = [T];

    #[inline(always)]
    fn index(&self, row: usize) -> &[T] {
        &self.0[row]
    }
}

impl<T, const ROWS: usize, const COLUMNS: usize> IndexMut<usize> for FixedMatrix<T, ROWS, COLUMNS> {
    #[inline(always)]
    fn index_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.0[row]
    }
}

impl<T: Entry, const ROWS: usize, const COLUMNS: usize> Matrix<T> for FixedMatrix<T, ROWS, COLUMNS> {
    #[inline(always)]
    fn fill(&mut self, value: T) {
        self.0 = [[value; COLUMNS]; ROWS];
    }

    #[inline(always)]
    fn entries(&self) -> (&[T], usize) {
        (self.0.as_flattened(), COLUMNS)
    }

    #[inline(always)]
    fn entries_mut(&mut self) -> (&mut [T], usize) {
        (self.0.as_flattened_mut(), COLUMNS)
    }
}

impl<T> Index<usize> for DynamicMatrix<T> {
    type Output = [T];

    #[inline(always)]
    fn index(&self, row: usize) -> &[T] {
        &self.entries[row * self.columns..][..self.columns]
    }
}

impl<T> IndexMut<usize> for DynamicMatrix<T> {
    #[inline(always)]
    fn index_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.entries[row * self.columns..][..self.columns]
    }
}

impl<T> DynamicMatrix<T> {
    /// Returns row `i`, mutable, and another row `k`.
    #[inline(always)]
    pub fn rows_mut(&mut self, i: usize, k: usize) -> (&mut [T], &[T]) {
        let columns = self.columns;
        let (before, after) = self.entries.split_at_mut(i.max(k) * columns);
        let (low, high) = (&mut before[i.min(k) * columns..][..columns], &mut after[..columns]);
        if i < k { (low, high) } else { (high, low) }
    }
}

impl<T: Entry> Matrix<T> for DynamicMatrix<T> {
    fn fill(&mut self, value: T) {
        self.entries.fill(value);
    }

    #[inline(always)]
    fn entries(&self) -> (&[T], usize) {
        (&self.entries, self.columns)
    }

    #[inline(always)]
    fn entries_mut(&mut self) -> (&mut [T], usize) {
        (&mut self.entries, self.columns)
    }
}

/// Numbers of coordinates and quadratures of a system, with the types of its vectors and matrices.
pub trait Layout: Copy + Debug + Send + Sync + 'static {
    /// Whether the sizes are constants.
    const IS_FIXED: bool;
    /// One entry for each coordinate.
    type Vector<T: Entry + PartialEq>: Vector<T>;
    /// One row and column for each coordinate.
    type Square<T: Entry>: Matrix<T>;
    /// One entry for each quadrature.
    type Quadratures: Vector<f64>;
    /// One row for each quadrature, one column for each coordinate.
    type QuadratureRows: Matrix<f64>;

    fn coordinates(self) -> usize;
    fn quadratures(self) -> usize;
    fn vector<T: Entry + PartialEq>(self, value: T) -> Self::Vector<T>;
    fn square<T: Entry>(self, value: T) -> Self::Square<T>;
    /// Zero for each quadrature.
    fn zero_quadratures(self) -> Self::Quadratures;
    fn zero_quadrature_rows(self) -> Self::QuadratureRows;
}

/// Vector with one number for each coordinate of a system.
pub type VectorOf<L> = <L as Layout>::Vector<f64>;

/// N coordinates and Z quadratures.
#[derive(Clone, Copy, Debug)]
pub struct Fixed<const N: usize, const Z: usize>;

/// Numbers of coordinates and quadratures that are known at run time.
#[derive(Clone, Copy, Debug)]
pub struct Dynamic {
    pub coordinates: usize,
    pub quadratures: usize,
}

impl<const N: usize, const Z: usize> Layout for Fixed<N, Z> {
    const IS_FIXED: bool = true;
    type Vector<T: Entry + PartialEq> = [T; N];
    type Square<T: Entry> = FixedMatrix<T, N, N>;
    type Quadratures = [f64; Z];
    type QuadratureRows = FixedMatrix<f64, Z, N>;

    #[inline(always)]
    fn coordinates(self) -> usize {
        N
    }

    #[inline(always)]
    fn quadratures(self) -> usize {
        Z
    }

    #[inline(always)]
    fn vector<T: Entry + PartialEq>(self, value: T) -> [T; N] {
        [value; N]
    }

    #[inline(always)]
    fn square<T: Entry>(self, value: T) -> FixedMatrix<T, N, N> {
        FixedMatrix([[value; N]; N])
    }

    #[inline(always)]
    fn zero_quadratures(self) -> [f64; Z] {
        [0.0; Z]
    }

    #[inline(always)]
    fn zero_quadrature_rows(self) -> FixedMatrix<f64, Z, N> {
        FixedMatrix([[0.0; N]; Z])
    }
}

impl Layout for Dynamic {
    const IS_FIXED: bool = false;
    type Vector<T: Entry + PartialEq> = Vec<T>;
    type Square<T: Entry> = DynamicMatrix<T>;
    type Quadratures = Vec<f64>;
    type QuadratureRows = DynamicMatrix<f64>;

    fn coordinates(self) -> usize {
        self.coordinates
    }

    fn quadratures(self) -> usize {
        self.quadratures
    }

    fn vector<T: Entry + PartialEq>(self, value: T) -> Vec<T> {
        vec![value; self.coordinates]
    }

    fn square<T: Entry>(self, value: T) -> DynamicMatrix<T> {
        DynamicMatrix { entries: vec![value; self.coordinates * self.coordinates], columns: self.coordinates }
    }

    fn zero_quadratures(self) -> Vec<f64> {
        vec![0.0; self.quadratures]
    }

    fn zero_quadrature_rows(self) -> DynamicMatrix<f64> {
        DynamicMatrix { entries: vec![0.0; self.quadratures * self.coordinates], columns: self.coordinates }
    }
}

/// y += w x.
#[inline(always)]
pub(crate) fn add_scaled(y: &mut [f64], w: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += w * x);
}

/// y += Σ wⱼ xⱼ, term by term for each entry, with the vectors xⱼ of these terms.
#[inline(always)]
pub(crate) fn add_weighted<X>(y: &mut [f64], w: &[f64], terms: &[X], x: impl Fn(&X) -> &[f64]) {
    let n = y.len();
    let mut start = 0;
    // Eight or four sums at a time stay in registers.
    while start + 8 <= n {
        add_to_chunk::<8, X>(&mut y[start..], w, terms, |term| &x(term)[start..]);
        start += 8;
    }
    if start + 4 <= n {
        add_to_chunk::<4, X>(&mut y[start..], w, terms, |term| &x(term)[start..]);
        start += 4;
    }
    if start < n {
        for (weight, term) in w.iter().zip(terms) {
            add_scaled(&mut y[start..], *weight, &x(term)[start..]);
        }
    }
}

/// [`add_weighted`] for the first N entries.
#[inline(always)]
fn add_to_chunk<'a, const N: usize, X>(y: &mut [f64], w: &[f64], terms: &'a [X], x: impl Fn(&'a X) -> &'a [f64]) {
    let Some(y) = y.first_chunk_mut::<N>() else { return };
    let mut sums = *y;
    for (weight, term) in w.iter().zip(terms) {
        let Some(x) = x(term).first_chunk::<N>() else { continue };
        (0..N).for_each(|k| sums[k] += weight * x[k]);
    }
    *y = sums;
}

/// y += x.
#[inline(always)]
pub(crate) fn add(y: &mut [f64], x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += x);
}

/// y = x.
#[inline(always)]
pub(crate) fn copy<T: Copy>(y: &mut impl AsMut<[T]>, x: &impl AsRef<[T]>) {
    y.as_mut().copy_from_slice(x.as_ref());
}

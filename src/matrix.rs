//! Products of matrices, and eigenvectors of small symmetric ones: the one place that calls the GEMM
//! kernels.
//!
//! In: views of any strides, `f32` or `f64`. Out: the product, written or added. The kernels are
//! chosen at run time for the machine; a result does not depend on the number of threads.

use gemm_common::Parallelism;
use nalgebra::{DMatrix, SymmetricEigen};
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};

/// A kernel: sides, target with column and row stride, whether it is added to, both factors likewise, what the target
/// and the product are multiplied by, which are conjugated, threads.
type Kernel<T> = unsafe fn(
    usize,
    usize,
    usize,
    *mut T,
    isize,
    isize,
    bool,
    *const T,
    isize,
    isize,
    *const T,
    isize,
    isize,
    T,
    T,
    bool,
    bool,
    bool,
    Parallelism,
);

/// A number type the kernels know.
pub trait Real: Copy + Send + Sync + From<u8> + 'static {
    /// The kernel for this machine.
    fn kernel() -> Kernel<Self>;
}

impl Real for f32 {
    fn kernel() -> Kernel<Self> {
        gemm_f32::gemm::f32::get_gemm_fn()
    }
}

impl Real for f64 {
    fn kernel() -> Kernel<Self> {
        gemm_f64::gemm::f64::get_gemm_fn()
    }
}

/// Numbers in rows as a matrix; the sides are the caller's promise.
pub fn as_rows<T>(numbers: &[T], rows: usize, columns: usize) -> ArrayView2<'_, T> {
    match ArrayView2::from_shape((rows, columns), numbers) {
        Ok(matrix) => matrix,
        Err(_) => unreachable!("{} numbers as {rows} × {columns}", numbers.len()),
    }
}

/// Numbers in rows as a matrix to write; the sides are the caller's promise.
pub fn as_rows_mut<T>(numbers: &mut [T], rows: usize, columns: usize) -> ArrayViewMut2<'_, T> {
    let count = numbers.len();
    match ArrayViewMut2::from_shape((rows, columns), numbers) {
        Ok(matrix) => matrix,
        Err(_) => unreachable!("{count} numbers as {rows} × {columns}"),
    }
}

/// What becomes of the numbers already in the target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// target ← a b
    Replace,
    /// target ← target + a b
    Add,
}

/// a b into `target` on the calling thread; for use inside parallel loops.
pub fn multiply<T: Real>(
    a: ArrayView2<'_, T>,
    b: ArrayView2<'_, T>,
    target: ArrayViewMut2<'_, T>,
    update: Update,
) {
    product(a, b, target, update, Parallelism::None);
}

/// a b into `target` on all threads.
pub fn multiply_on_all_threads<T: Real>(
    a: ArrayView2<'_, T>,
    b: ArrayView2<'_, T>,
    target: ArrayViewMut2<'_, T>,
    update: Update,
) {
    product(a, b, target, update, Parallelism::Rayon(0));
}

/// The product a b as a new matrix, on the calling thread.
pub fn product_of<T: Real>(a: ArrayView2<'_, T>, b: ArrayView2<'_, T>) -> Array2<T> {
    let mut target = Array2::from_elem((a.nrows(), b.ncols()), T::from(0));
    multiply(a, b, target.view_mut(), Update::Replace);
    target
}

fn product<T: Real>(
    a: ArrayView2<'_, T>,
    b: ArrayView2<'_, T>,
    mut target: ArrayViewMut2<'_, T>,
    update: Update,
    parallelism: Parallelism,
) {
    let (mut a, mut b) = (a.reborrow(), b.reborrow());
    let (rows, inner, columns) = (a.nrows(), a.ncols(), b.ncols());
    assert!(
        b.nrows() == inner && target.dim() == (rows, columns),
        "{:?} times {:?} into {:?}",
        a.dim(),
        b.dim(),
        target.dim()
    );
    // Kernels write columns: of a target in rows they write the transpose.
    if target.strides()[1].abs() < target.strides()[0].abs() {
        (a, b, target) = (b.reversed_axes(), a.reversed_axes(), target.reversed_axes());
    }
    // They count upwards in the target and along the rows of the first factor.
    if target.strides()[0] < 0 {
        target.invert_axis(Axis(0));
        a.invert_axis(Axis(0));
    }
    if target.strides()[1] < 0 {
        target.invert_axis(Axis(1));
        b.invert_axis(Axis(1));
    }
    if a.strides()[1] < 0 {
        a.invert_axis(Axis(1));
        b.invert_axis(Axis(0));
    }
    #[allow(
        unsafe_code,
        reason = "the kernels take pointers; sides are checked above, strides and bounds are ndarray's"
    )]
    unsafe {
        T::kernel()(
            a.nrows(),
            b.ncols(),
            inner,
            target.as_mut_ptr(),
            target.strides()[1],
            target.strides()[0],
            update == Update::Add,
            a.as_ptr(),
            a.strides()[1],
            a.strides()[0],
            b.as_ptr(),
            b.strides()[1],
            b.strides()[0],
            T::from(1),
            T::from(1),
            false,
            false,
            false,
            parallelism,
        );
    }
}

/// Eigenvalues, largest first, and eigenvectors as columns of a symmetric matrix.
pub fn eigen(matrix: Array2<f64>) -> (Vec<f64>, Array2<f64>) {
    let side = matrix.nrows();
    if side == 0 {
        return (Vec::new(), matrix);
    }
    let found = SymmetricEigen::new(DMatrix::from_fn(side, side, |i, j| matrix[[i, j]]));
    let mut order: Vec<usize> = (0..side).collect();
    order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
    let values = order.iter().map(|&at| found.eigenvalues[at]).collect();
    let vectors = Array2::from_shape_fn((side, side), |(i, j)| found.eigenvectors[(i, order[j])]);
    (values, vectors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::s;

    fn numbers(rows: usize, columns: usize, seed: usize) -> Array2<f64> {
        Array2::from_shape_fn((rows, columns), |(r, c)| {
            ((r * 31 + c * 17 + seed * 7) % 23) as f64 - 11.0
        })
    }

    #[test]
    fn products_agree_with_the_definition_for_any_strides() {
        let (a, b) = (numbers(5, 8, 1), numbers(6, 4, 2));
        let (a, b) = (a.slice(s![.., ..;2]), b.slice(s![1..5, ..]));
        let expected = a.dot(&b);
        assert_eq!(product_of(a, b), expected);
        let mut transposed = Array2::<f64>::ones((4, 5));
        multiply(a, b, transposed.view_mut().reversed_axes(), Update::Add);
        assert_eq!(transposed.t(), &expected + 1.0);
        // Upside down and from right to left, target and factors.
        let mut turned = Array2::<f64>::zeros((5, 4));
        let (a, b) = (a.slice(s![..;-1, ..;-1]), b.slice(s![..;-1, ..;-1]));
        multiply(a, b, turned.slice_mut(s![..;-1, ..;-1]), Update::Replace);
        assert_eq!(turned, expected);
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let a = numbers(300, 700, 1).mapv(|v| v as f32 * 0.137);
        let b = numbers(700, 190, 2).mapv(|v| v as f32 * 0.311);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| {
                let mut target = Array2::zeros((300, 190));
                multiply_on_all_threads(a.view(), b.view(), target.view_mut(), Update::Replace);
                target
            })
        };
        let single = run(1);
        assert_eq!(single, run(2));
        assert_eq!(single, run(8));
    }
}

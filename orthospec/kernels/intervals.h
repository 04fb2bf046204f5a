/* The kernels of intervals as Python sees them. */
#ifndef ORTHOSPEC_INTERVALS_H
#define ORTHOSPEC_INTERVALS_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "kernels.h"

/* Quantities are tuples: (numbers,), (lo, hi) or (lo, hi, c, g, r), float64 with any strides; g has one axis more, of
 * the d coordinates, at the end. They are broadcast to `out`, float64 (rows, ...), C-contiguous: its rows are lo and hi
 * and, where d > 0, c, r and d slopes. */
PyObject *add_intervals(const Kernels *kernels, PyObject *arguments);
PyObject *multiply_intervals(const Kernels *kernels, PyObject *arguments);
PyObject *narrow_intervals(const Kernels *kernels, PyObject *arguments);

/* Sums of products (x, x_axes, y, y_axes, out): bytes name, by number, what each axis of x and of y runs over: first
 * come the axes of out without its rows, then what is summed over. */
PyObject *contract_intervals(const Kernels *kernels, PyObject *arguments);

#endif

/* The kernels as Python sees them: buffers checked, the GIL released while a kernel runs.
 *
 * Only the limited API of Python 3.11 and its buffer protocol: one binary serves all later Pythons, and NumPy
 * is not needed to build it.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "kernels.h"

#include <string.h>

/* What an argument has to be: its buffer formats, one letter each, and how many dimensions. */
typedef struct {
    const char *name;
    const char *formats;
    const char *type;
    int dimensions;
    int written;
} Argument;

static const char *mismatch(const Py_buffer *view, const Argument *wanted, PyObject **exception)
{
    *exception = PyExc_TypeError;
    if (view->format == NULL || strlen(view->format) != 1 || strchr(wanted->formats, view->format[0]) == NULL)
        return "has the wrong type of element";
    *exception = PyExc_ValueError;
    if (view->ndim != wanted->dimensions)
        return "has the wrong number of dimensions";
    if (!PyBuffer_IsContiguous(view, 'C'))
        return "is not C-contiguous";
    if (wanted->written && view->readonly)
        return "is read-only";
    return NULL;
}

/* The buffer of an argument, or -1 and an exception that names the argument. */
static int take(PyObject *array, Py_buffer *view, const Argument *wanted)
{
    if (PyObject_GetBuffer(array, view, PyBUF_FULL_RO) < 0) {
        PyErr_Format(PyExc_TypeError, "%s: expected an array of %s", wanted->name, wanted->type);
        return -1;
    }
    PyObject *exception;
    const char *problem = mismatch(view, wanted, &exception);
    if (problem == NULL)
        return 0;
    PyErr_Format(exception, "%s %s: expected a C-contiguous array of %s with %d dimensions", wanted->name, problem,
                 wanted->type, wanted->dimensions);
    PyBuffer_Release(view);
    return -1;
}

static void release(Py_buffer views[], int count)
{
    for (int i = 0; i < count; i++)
        PyBuffer_Release(&views[i]);
}

enum { MOST_ARGUMENTS = 4 };

/* All arguments of a kernel, which are released together, or none. */
static int take_all(PyObject *arguments, const char *signature, const Argument wanted[], Py_buffer views[], int count)
{
    PyObject *arrays[MOST_ARGUMENTS];
    if (!PyArg_ParseTuple(arguments, signature, &arrays[0], &arrays[1], &arrays[2], &arrays[3]))
        return -1;
    for (int i = 0; i < count; i++)
        if (take(arrays[i], &views[i], &wanted[i]) < 0) {
            release(views, i);
            return -1;
        }
    return 0;
}

static PyObject *release_all(Py_buffer views[], int count, const char *problem)
{
    release(views, count);
    if (problem == NULL)
        Py_RETURN_NONE;
    PyErr_SetString(PyExc_ValueError, problem);
    return NULL;
}

static int overlap(const Py_buffer *a, const Py_buffer *b)
{
    const char *const start_a = a->buf, *const start_b = b->buf;
    return start_a < start_b + b->len && start_b < start_a + a->len;
}

static const char *wrong_sizes(const Py_buffer *mask, const Py_buffer *out)
{
    if (memcmp(mask->shape, out->shape, 3 * sizeof *mask->shape) != 0)
        return "out has another shape than mask";
    if (overlap(mask, out))
        return "out overlaps mask";
    const Py_ssize_t greatest = out->itemsize == 1 ? UINT8_MAX : UINT16_MAX;
    if (mask->shape[0] > greatest && mask->shape[1] > greatest && mask->shape[2] > greatest)
        return "out is too narrow for the largest cube that mask has room for";
    return NULL;
}

static PyObject *cube_sizes(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[2] = {{"mask", "B?", "uint8 or bool", 3, 0}, {"out", "BH", "uint8 or uint16", 3, 1}};
    Py_buffer views[2];
    if (take_all(arguments, "OO:cube_sizes", wanted, views, 2) < 0)
        return NULL;
    const char *const problem = wrong_sizes(&views[0], &views[1]);
    if (problem == NULL) {
        const Py_ssize_t *const extents = views[0].shape;
        const size_t shape[3] = {(size_t)extents[0], (size_t)extents[1], (size_t)extents[2]};
        Py_BEGIN_ALLOW_THREADS
        if (views[1].itemsize == 1)
            cube_sizes_u8(views[0].buf, views[1].buf, shape);
        else
            cube_sizes_u16(views[0].buf, views[1].buf, shape);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 2, problem);
}

static const char *wrong_eigenvalues(const Py_buffer *matrices, const Py_buffer *out)
{
    if (matrices->shape[1] != 3 || matrices->shape[2] != 3)
        return "matrices has another shape than (n, 3, 3)";
    if (out->shape[0] != matrices->shape[0] || out->shape[1] != 3)
        return "out has another shape than (n, 3)";
    if (overlap(matrices, out))
        return "out overlaps matrices";
    return NULL;
}

static PyObject *eigenvalues(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[2] = {{"matrices", "d", "float64", 3, 0}, {"out", "d", "float64", 2, 1}};
    Py_buffer views[2];
    if (take_all(arguments, "OO:symmetric_eigenvalues_3", wanted, views, 2) < 0)
        return NULL;
    const char *const problem = wrong_eigenvalues(&views[0], &views[1]);
    if (problem == NULL) {
        Py_BEGIN_ALLOW_THREADS
        symmetric_eigenvalues_3(views[0].buf, views[1].buf, (size_t)views[0].shape[0]);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 2, problem);
}

static const char *wrong_chains(const Py_buffer views[4])
{
    const Py_ssize_t *const d = views[0].shape, *const w = views[1].shape;
    const Py_ssize_t *const out = views[2].shape, *const safe = views[3].shape;
    if (d[2] != d[3] || d[2] < 1 || d[2] > 6)
        return "compliances has another shape than (n, chains, m, m) with m of 1 to 6";
    if (memcmp(d, w, 3 * sizeof *d) != 0 || w[3] != 6)
        return "wrenches has another shape than (n, chains, m, 6), by the compliances";
    if (out[0] != d[0] || out[1] != 6 || out[2] != 6)
        return "out has another shape than (n, 6, 6)";
    if (safe[0] != d[0])
        return "safe has another shape than (n,)";
    for (int written = 2; written < 4; written++)
        for (int other = 0; other < written; other++)
            if (overlap(&views[written], &views[other]))
                return written == 2 ? "out overlaps another argument" : "safe overlaps another argument";
    return NULL;
}

static PyObject *compliance(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[4] = {{"compliances", "d", "float64", 4, 0},
                                       {"wrenches", "d", "float64", 4, 0},
                                       {"out", "d", "float64", 3, 1},
                                       {"safe", "B?", "uint8 or bool", 1, 1}};
    Py_buffer views[4];
    if (take_all(arguments, "OOOO:chain_compliance", wanted, views, 4) < 0)
        return NULL;
    const char *const problem = wrong_chains(views);
    if (problem == NULL) {
        const Py_ssize_t *const shape = views[0].shape;
        const Chains chains = {views[0].buf, views[1].buf, (size_t)shape[0], (size_t)shape[1], (size_t)shape[2]};
        Py_BEGIN_ALLOW_THREADS
        chain_compliance(&chains, views[2].buf, views[3].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 4, problem);
}

static PyMethodDef methods[] = {
    {"cube_sizes", cube_sizes, METH_VARARGS,
     "cube_sizes(mask, out)\n--\n\nEdge in nodes of the largest cube of nonzero nodes that ends at each node."},
    {"symmetric_eigenvalues_3", eigenvalues, METH_VARARGS,
     "symmetric_eigenvalues_3(matrices, out)\n--\n\nEigenvalues, ascending, from the lower triangles."},
    {"chain_compliance", compliance, METH_VARARGS,
     "chain_compliance(compliances, wrenches, out, safe)\n--\n\nCompliance of a platform on chains side by side."},
    {NULL, NULL, 0, NULL},
};

static PyModuleDef_Slot slots[] = {{0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, .m_name = "_kernels", .m_doc = "The kernels, over buffers.", .m_methods = methods,
    .m_slots = slots,
};

PyMODINIT_FUNC PyInit__kernels(void)
{
    return PyModuleDef_Init(&definition);
}

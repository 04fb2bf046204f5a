/* The kernels as Python sees them: buffers checked, the GIL released while a kernel runs.
 *
 * Only the limited API of Python 3.11 and its buffer protocol: one binary serves all later Pythons, and NumPy
 * is not needed to build it.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "kernels.h"

#include <string.h>

/* The kernels in use: the best that this processor can run, unless another choice was made. */
static const Kernels *in_use;

typedef enum { READ, READ_STRIDED, WRITTEN } Access;

/* What an argument has to be: its buffer formats, one letter each, and how many dimensions. */
typedef struct {
    const char *name;
    const char *formats;
    const char *type;
    int dimensions;
    Access access;
} Argument;

static const char *mismatch(const Py_buffer *view, const Argument *wanted, PyObject **exception)
{
    *exception = PyExc_TypeError;
    if (view->format == NULL || strlen(view->format) != 1 || strchr(wanted->formats, view->format[0]) == NULL)
        return "has the wrong type of element";
    *exception = PyExc_ValueError;
    if (view->ndim != wanted->dimensions)
        return "has the wrong number of dimensions";
    if (wanted->access != READ_STRIDED && !PyBuffer_IsContiguous(view, 'C'))
        return "is not C-contiguous";
    if (wanted->access == WRITTEN && view->readonly)
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
    PyErr_Format(exception, "%s %s: expected %s array of %s with %d dimensions", wanted->name, problem,
                 wanted->access == READ_STRIDED ? "an" : "a C-contiguous", wanted->type, wanted->dimensions);
    PyBuffer_Release(view);
    return -1;
}

static void release(Py_buffer views[], int count)
{
    for (int i = 0; i < count; i++)
        PyBuffer_Release(&views[i]);
}

enum { MOST_ARGUMENTS = 6 };

/* All arguments of a kernel, which are released together, or none. */
static int take_all(PyObject *arguments, const char *signature, const Argument wanted[], Py_buffer views[], int count)
{
    PyObject *arrays[MOST_ARGUMENTS];
    if (!PyArg_ParseTuple(arguments, signature, &arrays[0], &arrays[1], &arrays[2], &arrays[3], &arrays[4],
                          &arrays[5]))
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

/* The bytes from the first element of a view to the end of its last, whatever the signs of its strides. */
static void extent(const Py_buffer *view, const char **start, const char **end)
{
    *start = view->buf;
    *end = *start + (view->len > 0 ? view->itemsize : 0);
    for (int axis = 0; view->len > 0 && axis < view->ndim; axis++) {
        const Py_ssize_t reach = (view->shape[axis] - 1) * view->strides[axis];
        if (reach < 0)
            *start += reach;
        else
            *end += reach;
    }
}

static int overlap(const Py_buffer *a, const Py_buffer *b)
{
    const char *start_a, *end_a, *start_b, *end_b;
    extent(a, &start_a, &end_a);
    extent(b, &start_b, &end_b);
    return start_a < end_b && start_b < end_a;
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
    static const Argument wanted[2] = {{"mask", "B?", "uint8 or bool", 3, READ}, {"out", "BH", "uint8 or uint16", 3, WRITTEN}};
    Py_buffer views[2];
    if (take_all(arguments, "OO:cube_sizes", wanted, views, 2) < 0)
        return NULL;
    const char *const problem = wrong_sizes(&views[0], &views[1]);
    if (problem == NULL) {
        const Py_ssize_t *const extents = views[0].shape;
        const size_t shape[3] = {(size_t)extents[0], (size_t)extents[1], (size_t)extents[2]};
        Py_BEGIN_ALLOW_THREADS
        if (views[1].itemsize == 1)
            in_use->cube_sizes_u8(views[0].buf, views[1].buf, shape);
        else
            in_use->cube_sizes_u16(views[0].buf, views[1].buf, shape);
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
    for (int axis = 0; axis < 3; axis++)
        if (matrices->strides[axis] % matrices->itemsize != 0)
            return "matrices has strides that are no whole numbers of its elements";
    return NULL;
}

static PyObject *eigenvalues_by(void (*kernel)(const Matrices *, double *), PyObject *arguments, const char *signature)
{
    static const Argument wanted[2] = {{"matrices", "d", "float64", 3, READ_STRIDED}, {"out", "d", "float64", 2, WRITTEN}};
    Py_buffer views[2];
    if (take_all(arguments, signature, wanted, views, 2) < 0)
        return NULL;
    const char *const problem = wrong_eigenvalues(&views[0], &views[1]);
    if (problem == NULL) {
        const Py_ssize_t *const strides = views[0].strides, item = views[0].itemsize;
        const Matrices matrices = {views[0].buf, strides[0] / item, strides[1] / item, strides[2] / item,
                                   (size_t)views[0].shape[0]};
        Py_BEGIN_ALLOW_THREADS
        kernel(&matrices, views[1].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 2, problem);
}

static PyObject *symmetric_eigenvalues(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return eigenvalues_by(in_use->symmetric_eigenvalues_3, arguments, "OO:symmetric_eigenvalues_3");
}

static PyObject *gram_eigenvalues(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return eigenvalues_by(in_use->gram_eigenvalues_3, arguments, "OO:gram_eigenvalues_3");
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
    static const Argument wanted[4] = {{"compliances", "d", "float64", 4, READ},
                                       {"wrenches", "d", "float64", 4, READ},
                                       {"out", "d", "float64", 3, WRITTEN},
                                       {"safe", "B?", "uint8 or bool", 1, WRITTEN}};
    Py_buffer views[4];
    if (take_all(arguments, "OOOO:chain_compliance", wanted, views, 4) < 0)
        return NULL;
    const char *const problem = wrong_chains(views);
    if (problem == NULL) {
        const Py_ssize_t *const shape = views[0].shape;
        const Chains chains = {views[0].buf, views[1].buf, (size_t)shape[0], (size_t)shape[1], (size_t)shape[2]};
        Py_BEGIN_ALLOW_THREADS
        in_use->chain_compliance(&chains, views[2].buf, views[3].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 4, problem);
}

static const char *wrong_legs(const Py_buffer views[6])
{
    const Py_ssize_t *const geometry = views[0].shape, count = views[1].shape[0];
    const Py_ssize_t *const rho = views[2].shape, *const s = views[3].shape;
    if (geometry[0] != 3 || geometry[1] != 8)
        return "geometry has another shape than (3, 8)";
    if (views[1].shape[1] != 3 || rho[0] != count || rho[1] != 3)
        return "poses or rho has another shape than (n, 3)";
    if (s[0] != 3 || s[1] != 3 || s[2] != count)
        return "s has another shape than (3, 3, n)";
    for (int written = 4; written < 6; written++)
        if (views[written].shape[0] != 3 || views[written].shape[1] != count)
            return written == 4 ? "along has another shape than (3, n)" : "closing has another shape than (3, n)";
    for (int written = 2; written < 6; written++)
        for (int other = 0; other < written; other++)
            if (overlap(&views[written], &views[other]))
                return "an array that is written overlaps another argument";
    return NULL;
}

static PyObject *close_legs(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[6] = {{"geometry", "d", "float64", 2, READ}, {"poses", "d", "float64", 2, READ},
                                       {"rho", "d", "float64", 2, WRITTEN},   {"s", "d", "float64", 3, WRITTEN},
                                       {"along", "d", "float64", 2, WRITTEN}, {"closing", "d", "float64", 2, WRITTEN}};
    Py_buffer views[6];
    if (take_all(arguments, "OOOOOO:close_legs", wanted, views, 6) < 0)
        return NULL;
    const char *const problem = wrong_legs(views);
    if (problem == NULL) {
        const Slides slides = {views[0].buf, views[1].buf, (size_t)views[1].shape[0]};
        const ClosedLegs legs = {views[2].buf, views[3].buf, views[4].buf, views[5].buf};
        Py_BEGIN_ALLOW_THREADS
        in_use->close_legs(&slides, &legs);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 6, problem);
}

static const char *wrong_margins(const Py_buffer views[4])
{
    const Py_ssize_t *const scales = views[0].shape, *const s = views[1].shape;
    const Py_ssize_t *const closing = views[2].shape, *const margins = views[3].shape;
    if (scales[0] != 3 || scales[1] != 7)
        return "scales has another shape than (3, 7)";
    if (s[0] != 3 || s[1] != 3)
        return "s has another shape than (3, 3, n)";
    if (closing[0] != 3 || closing[1] != s[2])
        return "closing has another shape than (3, n)";
    if (margins[0] != 5 || margins[1] != s[2])
        return "margins has another shape than (5, n)";
    for (int other = 0; other < 3; other++)
        if (overlap(&views[3], &views[other]))
            return "margins overlaps another argument";
    return NULL;
}

static PyObject *leg_margins(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[4] = {{"scales", "d", "float64", 2, READ},
                                       {"s", "d", "float64", 3, READ},
                                       {"closing", "d", "float64", 2, READ},
                                       {"margins", "d", "float64", 2, WRITTEN}};
    Py_buffer views[4];
    if (take_all(arguments, "OOOO:leg_margins", wanted, views, 4) < 0)
        return NULL;
    const char *const problem = wrong_margins(views);
    if (problem == NULL) {
        const LegRoom room = {views[0].buf, views[1].buf, views[2].buf, (size_t)views[1].shape[2]};
        Py_BEGIN_ALLOW_THREADS
        in_use->leg_margins(&room, views[3].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 4, problem);
}

static PyObject *instruction_sets(PyObject *Py_UNUSED(module), PyObject *Py_UNUSED(none))
{
    PyObject *const names = PyList_New(0);
    for (const Kernels *const *one = kernels_at_hand(); names != NULL && *one != NULL; one++) {
        PyObject *const name = PyUnicode_FromString((*one)->name);
        if (name == NULL || PyList_Append(names, name) < 0) {
            Py_XDECREF(name);
            Py_DECREF(names);
            return NULL;
        }
        Py_DECREF(name);
    }
    return names;
}

static PyObject *use(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    const char *name;
    if (!PyArg_ParseTuple(arguments, "s:use", &name))
        return NULL;
    for (const Kernels *const *one = kernels_at_hand(); *one != NULL; one++)
        if (strcmp((*one)->name, name) == 0) {
            in_use = *one;
            Py_RETURN_NONE;
        }
    PyErr_Format(PyExc_ValueError, "%s: this processor or build has no such kernels", name);
    return NULL;
}

static PyMethodDef methods[] = {
    {"cube_sizes", cube_sizes, METH_VARARGS,
     "cube_sizes(mask, out)\n--\n\nEdge in nodes of the largest cube of nonzero nodes that ends at each node."},
    {"symmetric_eigenvalues_3", symmetric_eigenvalues, METH_VARARGS,
     "symmetric_eigenvalues_3(matrices, out)\n--\n\nEigenvalues, ascending, from the lower triangles."},
    {"gram_eigenvalues_3", gram_eigenvalues, METH_VARARGS,
     "gram_eigenvalues_3(matrices, out)\n--\n\nEigenvalues, ascending, of each matrix's transpose times itself."},
    {"chain_compliance", compliance, METH_VARARGS,
     "chain_compliance(compliances, wrenches, out, safe)\n--\n\nCompliance of a platform on chains side by side."},
    {"close_legs", close_legs, METH_VARARGS,
     "close_legs(geometry, poses, rho, s, along, closing)\n--\n\nThe loops of three legs on slides."},
    {"leg_margins", leg_margins, METH_VARARGS,
     "leg_margins(scales, s, closing, margins)\n--\n\nHow far three legs are from their singularities."},
    {"instruction_sets", instruction_sets, METH_NOARGS,
     "instruction_sets()\n--\n\nThose that the kernels are there for and this processor has, the best first."},
    {"use", use, METH_VARARGS, "use(name)\n--\n\nTake the kernels of this instruction set from now on."},
    {NULL, NULL, 0, NULL},
};

static int choose(PyObject *Py_UNUSED(module))
{
    in_use = kernels_at_hand()[0];
    return 0;
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, choose}, {0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, .m_name = "_kernels", .m_doc = "The kernels, over buffers.", .m_methods = methods,
    .m_slots = slots,
};

PyMODINIT_FUNC PyInit__kernels(void)
{
    return PyModuleDef_Init(&definition);
}

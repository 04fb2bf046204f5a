#include "arguments.h"

#include <string.h>

static const char *mismatch(const Py_buffer *view, const Argument *wanted, PyObject **exception)
{
    *exception = PyExc_TypeError;
    if (view->format == NULL || strlen(view->format) != 1 || strchr(wanted->formats, view->format[0]) == NULL)
        return "has the wrong type of element";
    *exception = PyExc_ValueError;
    if (wanted->dimensions != ANY_DIMENSIONS && view->ndim != wanted->dimensions)
        return "has the wrong number of dimensions";
    if (wanted->access != READ_STRIDED && !PyBuffer_IsContiguous(view, 'C'))
        return "is not C-contiguous";
    if (wanted->access == WRITTEN && view->readonly)
        return "is read-only";
    return NULL;
}

int take(PyObject *array, Py_buffer *view, const Argument *wanted)
{
    if (PyObject_GetBuffer(array, view, PyBUF_FULL_RO) < 0) {
        PyErr_Format(PyExc_TypeError, "%s: expected an array of %s", wanted->name, wanted->type);
        return -1;
    }
    PyObject *exception;
    const char *problem = mismatch(view, wanted, &exception);
    if (problem == NULL)
        return 0;
    const char *const array_of = wanted->access == READ_STRIDED ? "an array of" : "a C-contiguous array of";
    if (wanted->dimensions == ANY_DIMENSIONS)
        PyErr_Format(exception, "%s %s: expected %s %s", wanted->name, problem, array_of, wanted->type);
    else
        PyErr_Format(exception, "%s %s: expected %s %s with %d dimensions", wanted->name, problem, array_of,
                     wanted->type, wanted->dimensions);
    PyBuffer_Release(view);
    return -1;
}

void release_views(Py_buffer views[], int count)
{
    for (int i = 0; i < count; i++)
        PyBuffer_Release(&views[i]);
}

enum { MOST_ARGUMENTS = 6 };

int take_all(PyObject *arguments, const char *signature, const Argument wanted[], Py_buffer views[], int count)
{
    PyObject *arrays[MOST_ARGUMENTS];
    if (!PyArg_ParseTuple(arguments, signature, &arrays[0], &arrays[1], &arrays[2], &arrays[3], &arrays[4],
                          &arrays[5]))
        return -1;
    for (int i = 0; i < count; i++)
        if (take(arrays[i], &views[i], &wanted[i]) < 0) {
            release_views(views, i);
            return -1;
        }
    return 0;
}

PyObject *release_all(Py_buffer views[], int count, const char *problem)
{
    release_views(views, count);
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

int overlap(const Py_buffer *a, const Py_buffer *b)
{
    const char *start_a, *end_a, *start_b, *end_b;
    extent(a, &start_a, &end_a);
    extent(b, &start_b, &end_b);
    return start_a < end_b && start_b < end_a;
}

/* Arguments of the kernels: buffers of the right element, dimensions, order and access, or an exception that names them. */
#ifndef ORTHOSPEC_ARGUMENTS_H
#define ORTHOSPEC_ARGUMENTS_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

typedef enum { READ, READ_STRIDED, WRITTEN } Access;

enum { ANY_DIMENSIONS = -1 };

/* What an argument has to be: its buffer formats, one letter each, and how many dimensions. */
typedef struct {
    const char *name;
    const char *formats;
    const char *type;
    int dimensions;
    Access access;
} Argument;

/* The buffer of an argument, or -1 and an exception that names the argument. */
int take(PyObject *array, Py_buffer *view, const Argument *wanted);

/* All arguments of a kernel, which are released together, or none. */
int take_all(PyObject *arguments, const char *signature, const Argument wanted[], Py_buffer views[], int count);

void release_views(Py_buffer views[], int count);

/* None, or NULL and a ValueError of the problem. */
PyObject *release_all(Py_buffer views[], int count, const char *problem);

/* Whether two views share a byte. */
int overlap(const Py_buffer *a, const Py_buffer *b);

#endif

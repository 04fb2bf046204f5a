/* The kernels as Python sees them: buffers checked, the GIL released while a kernel runs.
 *
 * Only the limited API of Python 3.11 and its buffer protocol: one binary serves all later Pythons, and NumPy
 * is not needed to build it.
 */
#include "arguments.h"
#include "intervals.h"
#include "kernels.h"

/* The kernels in use: the best that this processor can run, unless another choice was made. */
static const Kernels *in_use;

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

/* The bounds' part of nodes: low and high have one shape and one layout. */
static const char *wrong_bounds(const Py_buffer views[2])
{
    if (memcmp(views[0].shape, views[1].shape, 3 * sizeof *views[0].shape) != 0)
        return "high has another shape than low";
    for (int axis = 0; axis < 3; axis++) {
        if (views[0].strides[axis] != views[1].strides[axis])
            return "high has other strides than low";
        if (views[0].strides[axis] % views[0].itemsize != 0)
            return "low has strides that are no whole numbers of its elements";
    }
    return NULL;
}

/* The nodes that (mask,) or (low, high, at_least, at_most) tells, in up to two views; how many, or -1. */
static int take_nodes(PyObject *source, int axes, Py_buffer views[2], Nodes *nodes)
{
    static const Argument mask = {"mask", "B?", "uint8 or bool", 3, READ};
    static const Argument fields[2] = {{"low", "d", "float64", 3, READ_STRIDED}, {"high", "d", "float64", 3, READ_STRIDED}};
    PyObject *low, *high = NULL;
    memset(nodes, 0, sizeof *nodes);
    if (!PyArg_ParseTuple(source, PyTuple_Size(source) == 1 ? "O" : "OOdd;nodes are (mask,) or (low, high, at_least, at_most)",
                          &low, &high, &nodes->bounds.at_least, &nodes->bounds.at_most))
        return -1;
    const int count = high == NULL ? 1 : 2;
    if (take(low, &views[0], count == 1 ? &mask : &fields[0]) < 0)
        return -1;
    if (count == 2 && take(high, &views[1], &fields[1]) < 0) {
        release_views(views, 1);
        return -1;
    }
    const char *problem = count == 2 ? wrong_bounds(views) : NULL;
    if (axes != 3 && (axes != 2 || views[0].shape[1] != 1))
        problem = "axes is neither 3, nor 2 with a second axis of one node";
    if (problem != NULL) {
        release_all(views, count, problem);
        return -1;
    }
    nodes->flat = axes == 2;
    nodes->mask = count == 1 ? views[0].buf : NULL;
    nodes->bounds.low = views[0].buf;
    nodes->bounds.high = count == 2 ? views[1].buf : NULL;
    for (int axis = 0; axis < 3; axis++) {
        nodes->shape[axis] = (size_t)views[0].shape[axis];
        nodes->bounds.strides[axis] = views[0].strides[axis] / (Py_ssize_t)sizeof(double);
    }
    return count;
}

static PyObject *largest_cube(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    PyObject *source;
    int axes;
    Py_buffer views[2];
    Nodes nodes;
    if (!PyArg_ParseTuple(arguments, "O!i:largest_cube", &PyTuple_Type, &source, &axes))
        return NULL;
    const int count = take_nodes(source, axes, views, &nodes);
    if (count < 0)
        return NULL;
    uint64_t *const room = PyMem_New(uint64_t, room_for_cubes(&nodes, longest_edge(&nodes)));
    size_t edge = 0;
    if (room != NULL) {
        Py_BEGIN_ALLOW_THREADS
        edge = in_use->largest_cube(&nodes, room);
        Py_END_ALLOW_THREADS
    }
    release_views(views, count);
    PyMem_Free(room);
    return room == NULL ? PyErr_NoMemory() : PyLong_FromSize_t(edge);
}

static const char *wrong_ends(const Nodes *nodes, Py_ssize_t edge, const Py_buffer *out)
{
    if (edge < 1 || (size_t)edge > longest_edge(nodes))
        return "edge is not that of a cube that there is room for";
    if (out->itemsize != 8)
        return "out has another type of element than uint64";
    const size_t wanted[3] = {nodes->shape[0], nodes->shape[1], words_of_row(nodes)};
    for (int axis = 0; axis < 3; axis++)
        if ((size_t)out->shape[axis] != wanted[axis])
            return "out has another shape than the nodes' rows of 64-bit words";
    return NULL;
}

static PyObject *cube_ends(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted = {"out", "LQ", "uint64", 3, WRITTEN};
    PyObject *source, *array;
    int axes;
    Py_ssize_t edge;
    Py_buffer views[3];
    Nodes nodes;
    if (!PyArg_ParseTuple(arguments, "O!inO:cube_ends", &PyTuple_Type, &source, &axes, &edge, &array))
        return NULL;
    const int count = take_nodes(source, axes, views, &nodes);
    if (count < 0)
        return NULL;
    Py_buffer *const out = &views[count];
    if (take(array, out, &wanted) < 0) {
        release_views(views, count);
        return NULL;
    }
    const char *problem = wrong_ends(&nodes, edge, out);
    for (int read = 0; read < count; read++)
        if (overlap(&views[read], out))
            problem = "out overlaps the nodes";
    if (problem != NULL)
        return release_all(views, count + 1, problem);
    uint64_t *const room = PyMem_New(uint64_t, room_for_cubes(&nodes, (size_t)edge));
    if (room == NULL) {
        release_views(views, count + 1);
        return PyErr_NoMemory();
    }
    Py_BEGIN_ALLOW_THREADS
    in_use->cube_ends(&nodes, (size_t)edge, room, out->buf);
    Py_END_ALLOW_THREADS
    PyMem_Free(room);
    return release_all(views, count + 1, NULL);
}

static int whole_strides(const Py_buffer *matrices)
{
    for (int axis = 0; axis < 3; axis++)
        if (matrices->strides[axis] % matrices->itemsize != 0)
            return 0;
    return 1;
}

static Matrices matrices_in(const Py_buffer *view)
{
    const Py_ssize_t *const strides = view->strides, *const shape = view->shape, item = view->itemsize;
    return (Matrices){view->buf,        strides[0] / item, strides[1] / item, strides[2] / item,
                      (size_t)shape[0], shape[1],          shape[2]};
}

static const char *wrong_square(const Py_buffer *matrices)
{
    const Py_ssize_t *const shape = matrices->shape;
    if (shape[1] != shape[2] || shape[1] < 1 || shape[1] > 6)
        return "matrices has another shape than (n, m, m) with m of 1 to 6";
    return whole_strides(matrices) ? NULL : "matrices has strides that are no whole numbers of its elements";
}

static const char *wrong_eigenvalues(const Py_buffer views[2])
{
    const char *const problem = wrong_square(&views[0]);
    if (problem != NULL)
        return problem;
    if (views[1].shape[0] != views[0].shape[0] || views[1].shape[1] != views[0].shape[1])
        return "out has another shape than (n, m), by the matrices";
    return overlap(&views[0], &views[1]) ? "out overlaps matrices" : NULL;
}

static const char *wrong_norms(const Py_buffer views[2])
{
    if (views[1].shape[0] != views[0].shape[0] || views[1].shape[1] != views[0].shape[1])
        return "out has another shape than (n, r), by the matrices";
    if (!whole_strides(&views[0]))
        return "matrices has strides that are no whole numbers of its elements";
    return overlap(&views[0], &views[1]) ? "out overlaps matrices" : NULL;
}

/* A kernel from matrices to a row of numbers for each. */
static PyObject *rows_by(void (*kernel)(const Matrices *, double *), const char *(*wrong)(const Py_buffer[2]),
                         PyObject *arguments, const char *signature)
{
    static const Argument wanted[2] = {{"matrices", "d", "float64", 3, READ_STRIDED}, {"out", "d", "float64", 2, WRITTEN}};
    Py_buffer views[2];
    if (take_all(arguments, signature, wanted, views, 2) < 0)
        return NULL;
    const char *const problem = wrong(views);
    if (problem == NULL) {
        const Matrices matrices = matrices_in(&views[0]);
        Py_BEGIN_ALLOW_THREADS
        kernel(&matrices, views[1].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 2, problem);
}

static PyObject *symmetric_eigenvalues(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return rows_by(in_use->symmetric_eigenvalues, wrong_eigenvalues, arguments, "OO:symmetric_eigenvalues");
}

static const char *wrong_eigenvectors(const Py_buffer views[3])
{
    const char *const problem = wrong_eigenvalues(views);
    if (problem != NULL)
        return problem;
    if (memcmp(views[2].shape, views[0].shape, 3 * sizeof *views[0].shape) != 0)
        return "vectors has another shape than matrices";
    return overlap(&views[2], &views[0]) || overlap(&views[2], &views[1]) ? "vectors overlaps another argument" : NULL;
}

static PyObject *symmetric_eigenvectors(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[3] = {{"matrices", "d", "float64", 3, READ_STRIDED},
                                       {"out", "d", "float64", 2, WRITTEN},
                                       {"vectors", "d", "float64", 3, WRITTEN}};
    Py_buffer views[3];
    if (take_all(arguments, "OOO:symmetric_eigenvectors", wanted, views, 3) < 0)
        return NULL;
    const char *const problem = wrong_eigenvectors(views);
    if (problem == NULL) {
        const Matrices matrices = matrices_in(&views[0]);
        Py_BEGIN_ALLOW_THREADS
        in_use->symmetric_eigenvectors(&matrices, views[1].buf, views[2].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 3, problem);
}

static PyObject *gram_eigenvalues(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return rows_by(in_use->gram_eigenvalues, wrong_eigenvalues, arguments, "OO:gram_eigenvalues");
}

static PyObject *row_norms(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return rows_by(in_use->row_norms, wrong_norms, arguments, "OO:row_norms");
}

/* Of views of which the last two, `out` and `safe`, are written. */
static const char *wrong_written(const Py_buffer views[], int count)
{
    const Py_buffer *const out = &views[count - 2], *const safe = &views[count - 1];
    if (safe->shape[0] != out->shape[0])
        return "safe has another shape than (n,)";
    for (int other = 0; other < count - 2; other++)
        if (overlap(out, &views[other]))
            return "out overlaps another argument";
    for (int other = 0; other < count - 1; other++)
        if (overlap(safe, &views[other]))
            return "safe overlaps another argument";
    return NULL;
}

static const char *wrong_inverses(const Py_buffer views[3])
{
    const char *const problem = wrong_square(&views[0]);
    if (problem != NULL)
        return problem;
    if (memcmp(views[1].shape, views[0].shape, 3 * sizeof *views[0].shape) != 0)
        return "out has another shape than matrices";
    return wrong_written(views, 3);
}

static PyObject *positive_inverse(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[3] = {{"matrices", "d", "float64", 3, READ_STRIDED},
                                       {"out", "d", "float64", 3, WRITTEN},
                                       {"safe", "B?", "uint8 or bool", 1, WRITTEN}};
    Py_buffer views[3];
    if (take_all(arguments, "OOO:positive_inverse", wanted, views, 3) < 0)
        return NULL;
    const char *const problem = wrong_inverses(views);
    if (problem == NULL) {
        const Matrices matrices = matrices_in(&views[0]);
        Py_BEGIN_ALLOW_THREADS
        in_use->positive_inverse(&matrices, views[1].buf, views[2].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 3, problem);
}

static const char *wrong_solutions(const Py_buffer views[4])
{
    const char *const problem = wrong_square(&views[0]);
    if (problem != NULL)
        return problem;
    if (memcmp(views[1].shape, views[0].shape, 2 * sizeof *views[0].shape) != 0)
        return "right has another shape than (n, m, k), by the matrices";
    if (!whole_strides(&views[1]))
        return "right has strides that are no whole numbers of its elements";
    if (memcmp(views[2].shape, views[1].shape, 3 * sizeof *views[0].shape) != 0)
        return "out has another shape than right";
    return wrong_written(views, 4);
}

static PyObject *positive_solve(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[4] = {{"matrices", "d", "float64", 3, READ_STRIDED},
                                       {"right", "d", "float64", 3, READ_STRIDED},
                                       {"out", "d", "float64", 3, WRITTEN},
                                       {"safe", "B?", "uint8 or bool", 1, WRITTEN}};
    Py_buffer views[4];
    if (take_all(arguments, "OOOO:positive_solve", wanted, views, 4) < 0)
        return NULL;
    const char *const problem = wrong_solutions(views);
    if (problem == NULL) {
        const Matrices matrices = matrices_in(&views[0]), right = matrices_in(&views[1]);
        Py_BEGIN_ALLOW_THREADS
        in_use->positive_solve(&matrices, &right, views[2].buf, views[3].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 4, problem);
}

static const char *wrong_chains(const Py_buffer views[4])
{
    const Py_ssize_t *const d = views[0].shape, *const w = views[1].shape, *const out = views[2].shape;
    if (d[2] != d[3] || d[2] < 1 || d[2] > 6)
        return "compliances has another shape than (n, chains, m, m) with m of 1 to 6";
    if (memcmp(d, w, 3 * sizeof *d) != 0 || w[3] != 6)
        return "wrenches has another shape than (n, chains, m, 6), by the compliances";
    if (out[0] != d[0] || out[1] != 6 || out[2] != 6)
        return "out has another shape than (n, 6, 6)";
    return wrong_written(views, 4);
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

static const char *wrong_elastic_legs(const Py_buffer views[5])
{
    const Py_ssize_t *const legs = views[0].shape, *const feet = views[1].shape, *const s = views[2].shape;
    const Py_ssize_t *const out = views[3].shape;
    if (legs[0] != 3 || legs[1] != ELASTIC_NUMBERS)
        return "legs has another shape than (3, 21)";
    if (feet[0] != 3 || feet[1] != 6 || feet[2] != 6)
        return "feet has another shape than (3, 6, 6)";
    if (s[0] != 3 || s[1] != 3)
        return "s has another shape than (3, 3, n)";
    if (out[0] != s[2] || out[1] != 6 || out[2] != 6)
        return "out has another shape than (n, 6, 6)";
    return wrong_written(views, 5);
}

static PyObject *legs_compliance(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    static const Argument wanted[5] = {{"legs", "d", "float64", 2, READ},
                                       {"feet", "d", "float64", 3, READ},
                                       {"s", "d", "float64", 3, READ},
                                       {"out", "d", "float64", 3, WRITTEN},
                                       {"safe", "B?", "uint8 or bool", 1, WRITTEN}};
    Py_buffer views[5];
    if (take_all(arguments, "OOOOO:legs_compliance", wanted, views, 5) < 0)
        return NULL;
    const char *const problem = wrong_elastic_legs(views);
    if (problem == NULL) {
        const ElasticLegs legs = {views[0].buf, views[1].buf, views[2].buf, (size_t)views[2].shape[2]};
        Py_BEGIN_ALLOW_THREADS
        in_use->legs_compliance(&legs, views[3].buf, views[4].buf);
        Py_END_ALLOW_THREADS
    }
    return release_all(views, 5, problem);
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

static PyObject *add(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return add_intervals(in_use, arguments);
}

static PyObject *multiply(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return multiply_intervals(in_use, arguments);
}

static PyObject *narrow(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return narrow_intervals(in_use, arguments);
}

static PyObject *contract(PyObject *Py_UNUSED(module), PyObject *arguments)
{
    return contract_intervals(in_use, arguments);
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
    {"largest_cube", largest_cube, METH_VARARGS,
     "largest_cube(nodes, axes)\n--\n\nEdge in nodes of the largest cube, or of the largest square for two axes."},
    {"cube_ends", cube_ends, METH_VARARGS,
     "cube_ends(nodes, axes, edge, out)\n--\n\nWhere cubes of this edge end, a bit a node."},
    {"symmetric_eigenvalues", symmetric_eigenvalues, METH_VARARGS,
     "symmetric_eigenvalues(matrices, out)\n--\n\nEigenvalues, ascending, from the lower triangles."},
    {"symmetric_eigenvectors", symmetric_eigenvectors, METH_VARARGS,
     "symmetric_eigenvectors(matrices, out, vectors)\n--\n\nEigenvalues, ascending, and unit vectors to them."},
    {"gram_eigenvalues", gram_eigenvalues, METH_VARARGS,
     "gram_eigenvalues(matrices, out)\n--\n\nEigenvalues, ascending, of each matrix's transpose times itself."},
    {"positive_inverse", positive_inverse, METH_VARARGS,
     "positive_inverse(matrices, out, safe)\n--\n\nInverses of positive definite matrices, from the lower triangles."},
    {"positive_solve", positive_solve, METH_VARARGS,
     "positive_solve(matrices, right, out, safe)\n--\n\nWhat positive definite matrices take to the right side."},
    {"row_norms", row_norms, METH_VARARGS, "row_norms(matrices, out)\n--\n\nThe length of each row."},
    {"chain_compliance", compliance, METH_VARARGS,
     "chain_compliance(compliances, wrenches, out, safe)\n--\n\nCompliance of a platform on chains side by side."},
    {"legs_compliance", legs_compliance, METH_VARARGS,
     "legs_compliance(legs, feet, s, out, safe)\n--\n\nCompliance of a platform on three legs on slides."},
    {"close_legs", close_legs, METH_VARARGS,
     "close_legs(geometry, poses, rho, s, along, closing)\n--\n\nThe loops of three legs on slides."},
    {"leg_margins", leg_margins, METH_VARARGS,
     "leg_margins(scales, s, closing, margins)\n--\n\nHow far three legs are from their singularities."},
    {"add_intervals", add, METH_VARARGS, "add_intervals(x, y, out)\n--\n\nThe sum, entry by entry; y may be numbers."},
    {"multiply_intervals", multiply, METH_VARARGS, "multiply_intervals(x, y, out)\n--\n\nThe product, entry by entry."},
    {"narrow_intervals", narrow, METH_VARARGS,
     "narrow_intervals(x, out)\n--\n\nThe narrower of the ends and the form, entry by entry."},
    {"contract_intervals", contract, METH_VARARGS,
     "contract_intervals(x, x_axes, y, y_axes, out)\n--\n\nSums of products over named axes."},
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

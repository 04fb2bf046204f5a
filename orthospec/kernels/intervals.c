/* Intervals: arrays of any strides are taken apart into blocks side by side, which the kernels go through. */
#include "intervals.h"

#include "arguments.h"

enum { MOST_AXES = 32, PARTS = 5 };

/* The doubles of an array broadcast to a shape, with axes that follow each other without a gap taken as one. */
typedef struct {
    const char *data;
    int axes;
    size_t extent[MOST_AXES];
    ptrdiff_t stride[MOST_AXES];
} Walk;

static Walk walk_of(const char *data, int axes, const size_t *extents, const ptrdiff_t *strides)
{
    Walk walk = {data, 0, {0}, {0}};
    for (int axis = 0; axis < axes; axis++) {
        const size_t extent = extents[axis];
        const ptrdiff_t stride = strides[axis];
        if (extent == 1)
            continue;
        const int last = walk.axes - 1;
        if (last >= 0 && walk.stride[last] == stride * (ptrdiff_t)extent) {
            walk.extent[last] *= extent;
            walk.stride[last] = stride;
        } else {
            walk.extent[walk.axes] = extent;
            walk.stride[walk.axes++] = stride;
        }
    }
    return walk;
}

static void copy_run(double *to, const char *from, ptrdiff_t stride, size_t count)
{
    if (stride == sizeof(double))
        memcpy(to, from, count * sizeof(double));
    else
        for (size_t n = 0; n < count; n++)
            to[n] = *(const double *)(from + (ptrdiff_t)n * stride);
}

static int is_side_by_side(const Walk *walk)
{
    return walk->axes == 1 && walk->stride[0] == sizeof(double);
}

/* `count` numbers from the one numbered `first`: where they stand if that is side by side, else copied to `room`. */
static const double *numbers_at(const Walk *walk, size_t first, size_t count, double *room)
{
    if (is_side_by_side(walk))
        return (const double *)walk->data + first;
    const int last = walk->axes - 1;
    if (last < 0) {
        copy_run(room, walk->data, 0, count);
        return room;
    }
    size_t at[MOST_AXES], left = first;
    const char *from = walk->data;
    for (int axis = last; axis >= 0; axis--) {
        at[axis] = left % walk->extent[axis];
        left /= walk->extent[axis];
        from += (ptrdiff_t)at[axis] * walk->stride[axis];
    }
    for (size_t done = 0; done < count;) {
        const size_t run = LEAST(walk->extent[last] - at[last], count - done);
        copy_run(room + done, from, walk->stride[last], run);
        done += run;
        from -= (ptrdiff_t)at[last] * walk->stride[last];
        at[last] = 0;
        for (int axis = last - 1; axis >= 0; axis--) {
            from += walk->stride[axis];
            if (++at[axis] < walk->extent[axis])
                break;
            from -= (ptrdiff_t)at[axis] * walk->stride[axis];
            at[axis] = 0;
        }
    }
    return room;
}

/* An argument's arrays: lo, hi, c, g, r, as many as it has. */
typedef struct {
    Py_buffer views[PARTS];
    int count;
} Quantities;

enum { LO, HI, C, G, R };

static Knowledge knowledge_of(const Quantities *x)
{
    return x->count == 1 ? NUMBERS : x->count == 2 ? WITHOUT_FORMS : WITH_FORMS;
}

static int take_quantities(PyObject *parts, Quantities *x)
{
    x->count = 0;
    const Py_ssize_t count = PyTuple_Check(parts) ? PyTuple_Size(parts) : 0;
    if (count != 1 && count != 2 && count != PARTS) {
        PyErr_SetString(PyExc_TypeError, "quantities: expected (numbers,), (lo, hi) or (lo, hi, c, g, r)");
        return -1;
    }
    for (int i = 0; i < (int)count; i++) {
        static const Argument wanted = {"quantities", "d", "float64", ANY_DIMENSIONS, READ_STRIDED};
        if (take(PyTuple_GetItem(parts, i), &x->views[i], &wanted) < 0) {
            release_views(x->views, i);
            x->count = 0;
            return -1;
        }
        x->count = i + 1;
    }
    return 0;
}

static int have_one_shape(const Py_buffer *a, const Py_buffer *b, int axes)
{
    for (int axis = 0; axis < axes; axis++)
        if (a->shape[axis] != b->shape[axis])
            return 0;
    return 1;
}

static const char *wrong_quantities(const Quantities *x, size_t d)
{
    const Py_buffer *const like = &x->views[LO];
    for (int i = 0; i < x->count; i++) {
        const Py_buffer *const view = &x->views[i];
        if (view->ndim - (i == G) != like->ndim || !have_one_shape(view, like, like->ndim))
            return "the arrays of quantities have different shapes";
        if (i == G && view->shape[like->ndim] != (Py_ssize_t)d)
            return "the slopes are of another number of coordinates than the rows of out";
        if (view->ndim > MOST_AXES)
            return "quantities have too many axes";
        for (int axis = 0; axis < view->ndim; axis++)
            if (view->strides[axis] % (Py_ssize_t)sizeof(double) != 0)
                return "quantities have strides that are no whole numbers of their elements";
    }
    return NULL;
}

/* What is written to: its rows of `size` numbers, and the coordinates that they are for. */
typedef struct {
    Py_buffer view;
    size_t extents[MOST_AXES], size, d;
    int axes;
} Rows;

static int take_rows(PyObject *array, Rows *out)
{
    static const Argument wanted = {"out", "d", "float64", ANY_DIMENSIONS, WRITTEN};
    if (take(array, &out->view, &wanted) < 0)
        return -1;
    const int axes = out->view.ndim - 1;
    const Py_ssize_t rows = axes < 0 ? 0 : out->view.shape[0];
    if ((rows != 2 && rows < 5) || axes > MOST_AXES) {
        PyBuffer_Release(&out->view);
        PyErr_SetString(PyExc_ValueError, "out has another shape than (2, ...) or (4 + d, ...) with d > 0");
        return -1;
    }
    out->axes = axes;
    out->d = rows == 2 ? 0 : (size_t)rows - 4;
    out->size = 1;
    for (int axis = 0; axis < axes; axis++) {
        out->extents[axis] = (size_t)out->view.shape[axis + 1];
        out->size *= out->extents[axis];
    }
    return 0;
}

/* The strides of a view whose axes run over some of those of a space, summed where two run over one; whether the
 * view can be broadcast so. */
static int strides_in(const Py_buffer *view, int own, const unsigned char *axes, const size_t *extents, ptrdiff_t *strides,
                      int space)
{
    memset(strides, 0, (size_t)space * sizeof *strides);
    for (int axis = 0; axis < own; axis++) {
        const size_t extent = (size_t)view->shape[axis];
        if (extent != extents[axes[axis]] && extent != 1)
            return 0;
        if (extent != 1)
            strides[axes[axis]] += view->strides[axis];
    }
    return 1;
}

/* One side of an operation entry by entry, with room for a block of it. */
typedef struct {
    Knowledge kind;
    Walk walks[PARTS];
    ptrdiff_t slope;
    double *room;
} Side;

static const char *side_of(Side *side, const Quantities *x, const Rows *out)
{
    const int own = x->views[LO].ndim;
    if (own > out->axes)
        return "out has fewer axes than the quantities";
    unsigned char axes[MOST_AXES];
    for (int axis = 0; axis < own; axis++)
        axes[axis] = (unsigned char)(out->axes - own + axis);
    side->kind = knowledge_of(x);
    side->slope = 0;
    for (int i = 0; i < x->count; i++) {
        ptrdiff_t strides[MOST_AXES];
        if (!strides_in(&x->views[i], own, axes, out->extents, strides, out->axes))
            return "the quantities cannot be broadcast to the shape of out";
        side->walks[i] = walk_of(x->views[i].buf, out->axes, out->extents, strides);
    }
    if (x->count == PARTS)
        side->slope = x->views[G].strides[own];
    return NULL;
}

static const double none[INTERVAL_BLOCK];

/* The slopes of those quantities, and how far apart they stand. */
static const double *slopes_of(const Side *side, size_t first, size_t count, size_t d, double *room, ptrdiff_t *next)
{
    Walk walk = side->walks[G];
    if (is_side_by_side(&walk)) {
        *next = side->slope / (ptrdiff_t)sizeof(double);
        return (const double *)walk.data + first;
    }
    *next = INTERVAL_BLOCK;
    for (size_t k = 0; k < d; k++, walk.data += side->slope)
        numbers_at(&walk, first, count, room + k * INTERVAL_BLOCK);
    return room;
}

/* Quantities `first` to `first + count` of a side; forms are made up where it has none. */
static Known block_of(const Side *side, size_t first, size_t count, size_t d)
{
    double *const room = side->room;
    Known known = {NULL, NULL, NULL, none, none, 0, side->kind == NUMBERS};
    known.lo = numbers_at(&side->walks[LO], first, count, room);
    known.hi = known.exact ? known.lo : numbers_at(&side->walks[HI], first, count, room + INTERVAL_BLOCK);
    if (d == 0)
        return known;
    if (known.exact) {
        known.c = known.lo;
    } else if (side->kind == WITHOUT_FORMS) {
        double *const c = room + 2 * INTERVAL_BLOCK, *const r = room + 3 * INTERVAL_BLOCK;
        for (size_t n = 0; n < count; n++) {
            c[n] = (known.lo[n] + known.hi[n]) / 2;
            r[n] = interval_radius(known.lo[n], known.hi[n], c[n]);
        }
        known.c = c;
        known.r = r;
    } else {
        known.c = numbers_at(&side->walks[C], first, count, room + 2 * INTERVAL_BLOCK);
        known.r = numbers_at(&side->walks[R], first, count, room + 3 * INTERVAL_BLOCK);
        known.g = slopes_of(side, first, count, d, room + 4 * INTERVAL_BLOCK, &known.next);
    }
    return known;
}

/* None, or NULL and an exception that tells the problem. */
static const char no_memory[] = "no memory is left";

static PyObject *concluded(Rows *out, const char *problem)
{
    if (problem != no_memory)
        return release_all(&out->view, 1, problem);
    PyBuffer_Release(&out->view);
    return PyErr_NoMemory();
}

typedef void (*Operation)(const Known *x, const Known *y, size_t count, size_t d, const Found *out);

/* An operation of two sides, or of one where there is none other. */
static void by_blocks(const Kernels *kernels, Operation operation, const Side sides[2], const Rows *out)
{
    double *const rows = out->view.buf;
    for (size_t first = 0; first < out->size; first += INTERVAL_BLOCK) {
        const size_t count = LEAST(out->size - first, (size_t)INTERVAL_BLOCK);
        double *const lo = rows + first, *const hi = lo + out->size, *const c = hi + out->size;
        const Found found = {lo, hi, c, c + out->size, c + 2 * out->size, (ptrdiff_t)out->size};
        const Known x = block_of(&sides[0], first, count, out->d);
        if (operation == NULL) {
            kernels->narrow_intervals(&x, count, out->d, &found);
        } else {
            const Known y = block_of(&sides[1], first, count, out->d);
            operation(&x, &y, count, out->d, &found);
        }
    }
}

static const char *run_by_blocks(const Kernels *kernels, Operation operation, const Quantities *given, int count, Rows *out)
{
    Side sides[2];
    for (int i = 0; i < count; i++) {
        const char *problem = wrong_quantities(&given[i], out->d);
        if (problem == NULL)
            problem = side_of(&sides[i], &given[i], out);
        for (int part = 0; problem == NULL && part < given[i].count; part++)
            if (overlap(&given[i].views[part], &out->view))
                problem = "out overlaps another argument";
        if (problem != NULL)
            return problem;
    }
    double *const room = PyMem_Malloc(2 * (4 + out->d) * INTERVAL_BLOCK * sizeof(double));
    if (room == NULL)
        return no_memory;
    sides[0].room = room;
    sides[1].room = room + (4 + out->d) * INTERVAL_BLOCK;
    Py_BEGIN_ALLOW_THREADS
    by_blocks(kernels, operation, sides, out);
    Py_END_ALLOW_THREADS
    PyMem_Free(room);
    return NULL;
}

static PyObject *entry_by_entry(const Kernels *kernels, Operation operation, PyObject *const *parts, int count, PyObject *array)
{
    Quantities given[2];
    int taken = 0;
    while (taken < count && take_quantities(parts[taken], &given[taken]) == 0)
        taken++;
    Rows out;
    PyObject *made = NULL;
    if (taken == count && take_rows(array, &out) == 0)
        made = concluded(&out, run_by_blocks(kernels, operation, given, count, &out));
    for (int i = 0; i < taken; i++)
        release_views(given[i].views, given[i].count);
    return made;
}

PyObject *add_intervals(const Kernels *kernels, PyObject *arguments)
{
    PyObject *parts[2], *out;
    if (!PyArg_ParseTuple(arguments, "OOO:add_intervals", &parts[0], &parts[1], &out))
        return NULL;
    return entry_by_entry(kernels, kernels->add_intervals, parts, 2, out);
}

PyObject *multiply_intervals(const Kernels *kernels, PyObject *arguments)
{
    PyObject *parts[2], *out;
    if (!PyArg_ParseTuple(arguments, "OOO:multiply_intervals", &parts[0], &parts[1], &out))
        return NULL;
    return entry_by_entry(kernels, kernels->multiply_intervals, parts, 2, out);
}

PyObject *narrow_intervals(const Kernels *kernels, PyObject *arguments)
{
    PyObject *part, *out;
    if (!PyArg_ParseTuple(arguments, "OO:narrow_intervals", &part, &out))
        return NULL;
    return entry_by_entry(kernels, NULL, &part, 1, out);
}

/* What the axes of two factors run over: those of the result, then what is summed over. */
typedef struct {
    size_t extents[MOST_AXES];
    int axes;
    int lane; /* the longest axis of the result: its nodes go side by side; -1 where it has none */
} Space;

/* One factor's entries for each lane. */
typedef struct {
    Knowledge kind;
    ptrdiff_t strides[PARTS][MOST_AXES], slope;
    const char *data[PARTS];
    size_t multiples[MOST_AXES]; /* of an axis' index in an entry's number; 0 where it has no part in it */
    size_t count;
} Operand;

static const char *operand_of(Operand *operand, const Quantities *x, const Py_buffer *axes, const Space *space)
{
    const int own = x->views[LO].ndim;
    if (axes->len != own)
        return "as many axes have to be named as the quantities have";
    for (int axis = 0; axis < own; axis++)
        if (((const unsigned char *)axes->buf)[axis] >= space->axes)
            return "an axis that is named is none of the result and of what is summed over";
    operand->kind = knowledge_of(x);
    operand->slope = x->count == PARTS ? x->views[G].strides[own] : 0;
    for (int i = 0; i < x->count; i++) {
        operand->data[i] = x->views[i].buf;
        if (!strides_in(&x->views[i], own, axes->buf, space->extents, operand->strides[i], space->axes))
            return "the quantities do not have the lengths of the axes that they run over";
    }
    int has[MOST_AXES] = {0};
    for (int axis = 0; axis < own; axis++)
        has[((const unsigned char *)axes->buf)[axis]] |= x->views[LO].shape[axis] != 1;
    operand->count = 1;
    for (int axis = space->axes - 1; axis >= 0; axis--) {
        operand->multiples[axis] = has[axis] && axis != space->lane ? operand->count : 0;
        if (operand->multiples[axis] != 0)
            operand->count *= space->extents[axis];
    }
    return NULL;
}

/* The lengths of what is summed over, from the factors' own axes; those of the result stand there already. */
static const char *measure_space(Space *space, const Quantities *x, const Py_buffer *axes, int own)
{
    for (int axis = 0; axis < x->views[LO].ndim && axis < axes->len; axis++) {
        const int over = ((const unsigned char *)axes->buf)[axis];
        if (over >= MOST_AXES)
            return "an axis that is named is beyond those that there can be";
        while (space->axes <= over)
            space->extents[space->axes++] = 1;
        const size_t extent = (size_t)x->views[LO].shape[axis];
        if (over >= own && extent != 1)
            space->extents[over] = extent;
    }
    return NULL;
}

/* All entries of a factor, of lanes `first` to `first + count`; lanes beyond are the last again. */
static void gather_entries(const Operand *operand, const Space *space, size_t first, size_t count, size_t d, Lanes *entries)
{
    size_t at[MOST_AXES] = {0};
    const ptrdiff_t lane_axis = space->lane;
    for (size_t e = 0; e < operand->count; e++, entries += interval_width(d)) {
        const int parts = operand->kind == NUMBERS ? 1 : operand->kind == WITHOUT_FORMS || d == 0 ? 2 : PARTS;
        for (int part = 0; part < parts; part++) {
            static const size_t places[PARTS] = {0, 1, 2, 5, 3};
            const char *from = operand->data[part];
            for (int axis = 0; axis < space->axes; axis++)
                if (operand->multiples[axis] != 0)
                    from += (ptrdiff_t)at[axis] * operand->strides[part][axis];
            const ptrdiff_t stride = lane_axis < 0 ? 0 : operand->strides[part][lane_axis];
            from += (ptrdiff_t)first * stride;
            for (size_t k = 0; k < (part == G ? d : 1); k++) {
                double *const to = entries[places[part] + k].of;
                const char *const own = from + (ptrdiff_t)k * operand->slope;
                for (size_t lane = 0; lane < GROUP; lane++)
                    to[lane] = *(const double *)(own + (ptrdiff_t)LEAST(lane, count - 1) * stride);
            }
        }
        for (int axis = space->axes - 1; axis >= 0; axis--) {
            if (operand->multiples[axis] == 0)
                continue;
            if (++at[axis] < space->extents[axis])
                break;
            at[axis] = 0;
        }
    }
}

/* The numbers of a factor's entries by output or by term: sums of its multiples over the axes `from` to `to`. */
static void number_entries(const Space *space, int from, int to, const size_t *multiples, size_t *numbers)
{
    numbers[0] = 0;
    size_t count = 1;
    for (int axis = to - 1; axis >= from; axis--) {
        if (axis == space->lane)
            continue;
        for (size_t i = 1; i < space->extents[axis]; i++)
            for (size_t n = 0; n < count; n++)
                numbers[i * count + n] = numbers[n] + i * multiples[axis];
        count *= space->extents[axis];
    }
}

/* Tables and room of a contraction, in one piece. */
typedef struct {
    Contraction by;
    size_t *out_offsets;
    Lanes *found;
    void *memory;
} Work;

static size_t product_of(const size_t *extents, int from, int to, int without)
{
    size_t count = 1;
    for (int axis = from; axis < to; axis++)
        if (axis != without)
            count *= extents[axis];
    return count;
}

static int plan_work(Work *work, const Space *space, const Operand factors[2], const Rows *out)
{
    const size_t d = out->d, width = interval_width(d);
    const size_t outs = product_of(space->extents, 0, out->axes, space->lane);
    const size_t terms = product_of(space->extents, out->axes, space->axes, -1);
    const size_t lanes = (factors[0].count + factors[1].count) * width + outs * interval_rows(d);
    /* A table has a number even where nothing is summed over, or an axis has no length. */
    const size_t numbers = 3 * (outs + 1) + 2 * (terms + 1);
    work->memory = PyMem_Malloc(lanes * sizeof(Lanes) + numbers * sizeof(size_t));
    if (work->memory == NULL)
        return -1;
    Lanes *const x = work->memory, *const y = x + factors[0].count * width;
    work->found = y + factors[1].count * width;
    size_t *const tables = (size_t *)(work->found + outs * interval_rows(d));
    size_t *const x_out = tables, *const y_out = x_out + outs + 1, *const x_term = y_out + outs + 1;
    size_t *const y_term = x_term + terms + 1;
    work->out_offsets = y_term + terms + 1;
    number_entries(space, 0, out->axes, factors[0].multiples, x_out);
    number_entries(space, 0, out->axes, factors[1].multiples, y_out);
    number_entries(space, out->axes, space->axes, factors[0].multiples, x_term);
    number_entries(space, out->axes, space->axes, factors[1].multiples, y_term);
    size_t steps[MOST_AXES], step = 1;
    for (int axis = out->axes - 1; axis >= 0; axis--) {
        steps[axis] = step;
        step *= out->extents[axis];
    }
    number_entries(space, 0, out->axes, steps, work->out_offsets);
    const Factor one = {x, factors[0].count, factors[0].kind, 1, x_out, x_term};
    const Factor other = {y, factors[1].count, factors[1].kind, 1, y_out, y_term};
    work->by = (Contraction){one, other, outs, terms, d};
    return 0;
}

static int runs_along(const Operand *operand, int lane)
{
    if (lane < 0)
        return 0;
    for (int part = 0; part < PARTS && operand->data[part] != NULL; part++)
        if (operand->strides[part][lane] != 0)
            return 1;
    return 0;
}

static void contract(const Kernels *kernels, Work *work, const Space *space, const Operand factors[2], const Rows *out)
{
    const size_t d = out->d, rows = interval_rows(d);
    const size_t lanes = space->lane < 0 ? 1 : space->extents[space->lane];
    const size_t step = space->lane < 0 ? 0 : product_of(out->extents, space->lane + 1, out->axes, -1);
    Factor *const own[2] = {&work->by.x, &work->by.y};
    for (size_t first = 0; first < lanes; first += GROUP) {
        const size_t count = LEAST(lanes - first, (size_t)GROUP);
        for (int i = 0; i < 2; i++) {
            own[i]->fresh = first == 0 || runs_along(&factors[i], space->lane);
            if (own[i]->fresh)
                gather_entries(&factors[i], space, first, count, d, own[i]->entries);
        }
        kernels->contract_intervals(&work->by, work->found);
        for (size_t p = 0; p < work->by.outs; p++)
            for (size_t row = 0; row < rows; row++) {
                double *const to = (double *)out->view.buf + row * out->size + work->out_offsets[p] + first * step;
                for (size_t lane = 0; lane < count; lane++)
                    to[lane * step] = work->found[p * rows + row].of[lane];
            }
    }
}

static const char *run_contraction(const Kernels *kernels, const Quantities given[2], const Py_buffer axes[2], Rows *out)
{
    Space space = {{0}, out->axes, -1};
    memcpy(space.extents, out->extents, (size_t)out->axes * sizeof *space.extents);
    Operand factors[2] = {{0}, {0}};
    for (int i = 0; i < 2; i++) {
        const char *problem = wrong_quantities(&given[i], out->d);
        for (int part = 0; problem == NULL && part < given[i].count; part++)
            if (overlap(&given[i].views[part], &out->view))
                problem = "out overlaps another argument";
        if (problem == NULL)
            problem = measure_space(&space, &given[i], &axes[i], out->axes);
        if (problem != NULL)
            return problem;
    }
    for (int axis = 0; axis < out->axes; axis++)
        if (space.lane < 0 || space.extents[axis] > space.extents[space.lane])
            space.lane = axis;
    for (int i = 0; i < 2; i++) {
        const char *const problem = operand_of(&factors[i], &given[i], &axes[i], &space);
        if (problem != NULL)
            return problem;
    }
    if (out->size == 0)
        return NULL;
    Work work;
    if (plan_work(&work, &space, factors, out) < 0)
        return no_memory;
    Py_BEGIN_ALLOW_THREADS
    contract(kernels, &work, &space, factors, out);
    Py_END_ALLOW_THREADS
    PyMem_Free(work.memory);
    return NULL;
}

PyObject *contract_intervals(const Kernels *kernels, PyObject *arguments)
{
    static const Argument named = {"axes", "B", "uint8", 1, READ};
    PyObject *parts[2], *names[2], *array, *made = NULL;
    if (!PyArg_ParseTuple(arguments, "OOOOO:contract_intervals", &parts[0], &names[0], &parts[1], &names[1], &array))
        return NULL;
    Quantities given[2];
    Py_buffer axes[2];
    int taken = 0;
    for (; taken < 2 && take_quantities(parts[taken], &given[taken]) == 0; taken++)
        if (take(names[taken], &axes[taken], &named) < 0) {
            release_views(given[taken].views, given[taken].count);
            break;
        }
    Rows out;
    if (taken == 2 && take_rows(array, &out) == 0)
        made = concluded(&out, run_contraction(kernels, given, axes, &out));
    for (int i = 0; i < taken; i++) {
        release_views(given[i].views, given[i].count);
        PyBuffer_Release(&axes[i]);
    }
    return made;
}

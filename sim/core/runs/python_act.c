// A controller that is a Python object.
//
// With the loop in Python, and a call of the core in each step, a fast controller made 0.63 million
// steps per second; with the loop here it makes 1.1 million.

#include "wg_python_act.h"

#include "Python.h"
#include "step.h"

enum { TOOLS = 9 };

// The loop's tools; it does not own references to them.
typedef struct Tools {
    PyObject *act;
    PyObject *first;
    PyObject *measured;
    PyObject *new_tuple;
    PyObject *observation;
    PyObject *command;
    PyObject *tuple;
    PyObject *number;
    PyObject *settle;
} Tools;

int64_t wg_episode_stop(void *subject)
{
    return wg_episode_step(subject);
}

// Returns true if an object has exactly this type, not a subtype.
static bool is_just(PyObject *object, PyObject *type)
{
    PyObject *own = PyObject_Type(object);
    Py_DecRef(own);
    return own == type;
}

// Returns a tuple of floats; NULL after an exception.
static PyObject *floats(const double *numbers, int64_t count)
{
    PyObject *made = PyTuple_New((Py_ssize_t)count);
    for (int64_t k = 0; made != NULL && k < count; k++) {
        PyObject *number = PyFloat_FromDouble(numbers[k]);
        if (number == NULL || PyTuple_SetItem(made, (Py_ssize_t)k, number) != 0) {
            Py_DecRef(made);
            made = NULL;
        }
    }
    return made;
}

// The controller's observation, as a new object, because the controller may keep it. NULL after an
// exception.
static PyObject *observation_of(const WgWorkspace *workspace, const Tools *tools)
{
    const double *seen = workspace->flat;
    PyObject *fields = PyTuple_New(WG_SENSES + 5);
    if (fields == NULL) {
        return NULL;
    }
    bool made = PyTuple_SetItem(fields, 0, PyBool_FromLong(seen[0] != 0.0)) == 0;
    for (Py_ssize_t k = 1; made && k < WG_SENSES; k++) {
        PyObject *number = PyFloat_FromDouble(seen[k]);
        made = number != NULL && PyTuple_SetItem(fields, k, number) == 0;
    }
    PyObject *beams = made ? floats(seen + WG_SENSES, workspace->observation.beam_count) : NULL;
    made = beams != NULL && PyTuple_SetItem(fields, WG_SENSES, beams) == 0;
    // A robot that is driven from here is alone: it has no neighbours.
    PyObject *neighbours = made ? PyTuple_New(0) : NULL;
    made = neighbours != NULL && PyTuple_SetItem(fields, WG_SENSES + 1, neighbours) == 0;
    const WgObservation *now = &workspace->observation;
    const double last[] = {now->goal_heading, now->tilt, now->tilt_heading};
    for (Py_ssize_t k = 0; made && k < 3; k++) {
        PyObject *number = PyFloat_FromDouble(last[k]);
        made = number != NULL && PyTuple_SetItem(fields, WG_SENSES + 2 + k, number) == 0;
    }
    PyObject *observation =
        made ? PyObject_CallFunctionObjArgs(tools->new_tuple, tools->observation, fields, NULL) : NULL;
    Py_DecRef(fields);
    return observation;
}

// Reads a number; returns false, without an exception, if it isn't one.
static bool read_number(PyObject *object, double *number)
{
    *number = PyFloat_AsDouble(object);
    if (*number == -1.0 && PyErr_Occurred() != NULL) {
        PyErr_Clear();
        return false;
    }
    return true;
}

// Reads all items of a tuple; returns false, without an exception, if one isn't a number. `plain`:
// true if all are exactly floats.
static bool read_numbers(PyObject *tuple, int64_t count, const Tools *tools, double *numbers, bool *plain)
{
    *plain = true;
    for (int64_t k = 0; k < count; k++) {
        PyObject *item = PyTuple_GetItem(tuple, (Py_ssize_t)k);
        if (!read_number(item, &numbers[k])) {
            return false;
        }
        *plain = *plain && is_just(item, tools->number);
    }
    return true;
}

// Reads an answer that is a tuple of a command, which is a Command or a tuple of two to four, and
// a tuple of numbers. Returns the memory to continue with; for any other answer, which Python must
// judge, returns NULL without an exception.
static PyObject *take_quickly(PyObject *answer, int64_t size, const Tools *tools, double *taken)
{
    if (!is_just(answer, tools->tuple) || PyTuple_Size(answer) != 2) {
        return NULL;
    }
    PyObject *asked = PyTuple_GetItem(answer, 0);
    PyObject *after = PyTuple_GetItem(answer, 1);
    if (!is_just(asked, tools->command) && !is_just(asked, tools->tuple)) {
        return NULL;
    }
    Py_ssize_t fields = PyTuple_Size(asked);
    if (fields < 2 || fields > 4 || !is_just(after, tools->tuple) || PyTuple_Size(after) != size) {
        return NULL;
    }

    int used_random = fields >= 3 ? PyObject_IsTrue(PyTuple_GetItem(asked, 2)) : 0;
    if (used_random < 0) {
        return NULL;
    }
    bool plain = false;
    if (!read_number(PyTuple_GetItem(asked, 0), &taken[1]) || !read_number(PyTuple_GetItem(asked, 1), &taken[2])
        || !read_numbers(after, size, tools, taken + WG_ANSWER, &plain)) {
        return NULL;
    }
    taken[3] = used_random;
    if (!plain) {
        return floats(taken + WG_ANSWER, size);
    }
    Py_IncRef(after);
    return after;
}

// Does the same for any answer, judged by Python. NULL after an exception.
static PyObject *take_slowly(PyObject *answer, int64_t size, const Tools *tools, double *taken)
{
    PyObject *length = PyLong_FromLongLong(size);
    PyObject *settled = length == NULL ? NULL : PyObject_CallFunctionObjArgs(tools->settle, answer, length, NULL);
    Py_DecRef(length);
    if (settled == NULL) {
        return NULL;
    }
    bool plain = false;
    bool fits = PyTuple_Size(settled) == WG_ANSWER - 1 + size
                && read_numbers(settled, WG_ANSWER - 1 + size, tools, taken + 1, &plain);
    Py_DecRef(settled);
    return fits ? floats(taken + WG_ANSWER, size) : NULL;
}

// Lets the controller act once, and writes its answer. Returns its memory, a new reference; NULL
// after an exception.
static PyObject *act_once(WgActing *acting, const Tools *tools, PyObject *memory)
{
    WgWorkspace *workspace = &acting->episode->workspace;
    PyObject *observation = observation_of(workspace, tools);
    if (observation == NULL) {
        return NULL;
    }

    // Choose the function by how its time is counted: the first call only for itself, later ones
    // for all calls around them.
    PyObject *act = tools->act;
    if (acting->calls == 0) {
        act = tools->first;
    } else if ((acting->calls - 1) % acting->every == acting->every / 2) {
        act = tools->measured;
    }
    acting->calls++;
    PyObject *answer = PyObject_CallFunctionObjArgs(act, observation, memory, NULL);
    Py_DecRef(observation);
    if (answer == NULL) {
        return NULL;
    }

    int64_t size = acting->episode->controller.memory_size;
    PyObject *after = take_quickly(answer, size, tools, workspace->answer);
    if (after == NULL && PyErr_Occurred() == NULL) {
        after = take_slowly(answer, size, tools, workspace->answer);
    }
    Py_DecRef(answer);
    if (after != NULL) {
        workspace->answer[0] = 1.0;
    }
    return after;
}

// Reads the tools; false after an exception.
static bool read_tools(PyObject *from, Tools *tools)
{
    PyObject **to[TOOLS] = {&tools->act,         &tools->first,   &tools->measured, &tools->new_tuple,
                            &tools->observation, &tools->command, &tools->tuple,    &tools->number,
                            &tools->settle};
    for (Py_ssize_t k = 0; k < TOOLS; k++) {
        *to[k] = PyTuple_GetItem(from, k);
        if (*to[k] == NULL) {
            return false;
        }
    }
    return true;
}

void *wg_act_in_python(WgActing *acting, void *tools, void *memory, int64_t most)
{
    Tools own;
    if (!read_tools(tools, &own)) {
        return NULL;
    }
    PyObject *kept = memory;
    Py_IncRef(kept);
    for (int64_t k = 0; k < most; k++) {
        // The controller may be a function that never looks for signals.
        if (PyErr_CheckSignals() != 0) {
            Py_DecRef(kept);
            return NULL;
        }
        if (acting->stop(acting->subject) == WG_OVER) {
            acting->over = 1;
            return kept;
        }
        PyObject *after = act_once(acting, &own, kept);
        Py_DecRef(kept);
        if (after == NULL) {
            return NULL;
        }
        kept = after;
    }
    return kept;
}

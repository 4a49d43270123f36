// The part of Python's stable ABI that cffi's bindings and the cores use, from Python 3.11 on.
//
// CPython guarantees that these functions keep their names, arguments and meaning in every later
// Python 3, so the cores need no headers of the Python that they are built with. Many machines lack
// them, and those of another system are unavailable when a wheel for it is built.
//
// Source: Python documentation, "C API Stability", contents of the limited API.

#ifndef WORLDGEN_PYTHON_H
#define WORLDGEN_PYTHON_H

#include <assert.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <malloc.h>  // alloca
#define WG_IMPORTED __declspec(dllimport)
#define PyMODINIT_FUNC __declspec(dllexport) PyObject *
#else
#include <alloca.h>
#define WG_IMPORTED
#define PyMODINIT_FUNC __attribute__((visibility("default"))) PyObject *
#endif

typedef struct _object PyObject;
typedef struct _ts PyThreadState;
typedef intptr_t Py_ssize_t;

WG_IMPORTED void Py_IncRef(PyObject *object);
WG_IMPORTED void Py_DecRef(PyObject *object);
#define Py_INCREF(object) Py_IncRef(object)
#define Py_DECREF(object) Py_DecRef(object)
#define Py_XINCREF(object) Py_IncRef(object)
#define Py_XDECREF(object) Py_DecRef(object)

// None. A binding returns it from functions without a result.
WG_IMPORTED extern PyObject _Py_NoneStruct;
#define Py_None (&_Py_NoneStruct)

WG_IMPORTED PyThreadState *PyEval_SaveThread(void);
WG_IMPORTED void PyEval_RestoreThread(PyThreadState *state);
#define Py_BEGIN_ALLOW_THREADS { PyThreadState *_save = PyEval_SaveThread();
#define Py_END_ALLOW_THREADS PyEval_RestoreThread(_save); }

WG_IMPORTED int PyArg_UnpackTuple(PyObject *arguments, const char *name, Py_ssize_t least, Py_ssize_t most, ...);
WG_IMPORTED PyObject *PyBool_FromLong(long value);
WG_IMPORTED int PyErr_CheckSignals(void);
WG_IMPORTED void PyErr_Clear(void);
WG_IMPORTED PyObject *PyErr_Occurred(void);
WG_IMPORTED void PyErr_SetString(PyObject *type, const char *message);
WG_IMPORTED void Py_FatalError(const char *message);
WG_IMPORTED double PyFloat_AsDouble(PyObject *value);
WG_IMPORTED PyObject *PyFloat_FromDouble(double value);
WG_IMPORTED PyObject *PyImport_ImportModule(const char *name);
WG_IMPORTED PyObject *PyLong_FromLong(long value);
WG_IMPORTED PyObject *PyLong_FromLongLong(long long value);
WG_IMPORTED PyObject *PyLong_FromUnsignedLong(unsigned long value);
WG_IMPORTED PyObject *PyLong_FromUnsignedLongLong(unsigned long long value);
WG_IMPORTED PyObject *PyLong_FromVoidPtr(void *address);
WG_IMPORTED PyObject *PyObject_CallFunctionObjArgs(PyObject *function, ...);
WG_IMPORTED PyObject *PyObject_CallMethod(PyObject *object, const char *name, const char *format, ...);
WG_IMPORTED void PyObject_Free(void *memory);
WG_IMPORTED int PyObject_IsTrue(PyObject *object);
WG_IMPORTED void *PyObject_Malloc(size_t size);
WG_IMPORTED PyObject *PyObject_Type(PyObject *object);
WG_IMPORTED PyObject *PyTuple_GetItem(PyObject *tuple, Py_ssize_t at);
WG_IMPORTED PyObject *PyTuple_New(Py_ssize_t size);
WG_IMPORTED int PyTuple_SetItem(PyObject *tuple, Py_ssize_t at, PyObject *item);
WG_IMPORTED Py_ssize_t PyTuple_Size(PyObject *tuple);

#endif

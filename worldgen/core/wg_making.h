// What is slow about making, measuring and importing worlds.
//
// Arrays are row-major. Functions check the sizes that they are given; none keeps a pointer.

#ifndef WG_MAKING_H
#define WG_MAKING_H

#include <stdint.h>

#include "wg_types.h"

#endif

// Types that every core uses. The prover and the simulator share only this header.

#ifndef WG_TYPES_H
#define WG_TYPES_H

#include <stdint.h>

// The result of every function that can fail; worldgen/support/ccall.py raises all but WG_OK.
typedef enum WgStatus {
    WG_OK = 0,
    WG_BAD_SIZE = 1,       // an array is smaller than the arguments require
    WG_BAD_VALUE = 2,      // a number is outside its range
    WG_OUT_OF_MEMORY = 3,
} WgStatus;

#endif
